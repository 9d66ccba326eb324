// The page of one person: asks how things are once a second, brings what was pressed and where the phone is.
import { drawMap } from "./map.mjs";
import { newId, Queue } from "./queue.mjs";
import { action, duration, lines, title, whereabouts } from "./words.mjs";

const EVERY_MS = 1000, PATIENCE_MS = 8000, PHOTO_PATIENCE_MS = 240_000;
/** The phone is asked for its place when it has told none for so long. */
const PLACE_MS = 15_000;
const MOST_NOTES = 5;
const WORDS = { here: "I am here", done: "done", cannot: "I cannot" };

const $ = (id) => document.getElementById(id);
let storage = null;
try {
  storage = localStorage;
} catch { /* not allowed: what is pressed waits in the page */ }
const queue = new Queue(storage, `muster-phone-${location.pathname}`);
const photos = [];  // {id, file, at_ms, session, order}
const notes = [];
let view = { agent: null, over: null, failed: null, order: null };
let heard_ms = null;   // when it was heard last
let lost = "connecting";  // why it is not; "": it is
let gps = "", placed_ms = 0;
let isEnded = false, isBusy = false, isWanted = false;

function note(text) {
  notes.unshift(`${new Date().toTimeString().slice(0, 5)} ${text}`);
  notes.length = Math.min(notes.length, MOST_NOTES);
}

const now_s = () => (heard_ms === null ? 0 : view.mission_s + ((Date.now() - heard_ms) / 1000) * (view.rate ?? 0));

function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

function setLines(list, texts) {
  while (list.children.length < texts.length) list.append(document.createElement("li"));
  while (list.children.length > texts.length) list.lastChild.remove();
  texts.forEach((text, i) => setText(list.children[i], text));
}

function connection() {
  if (isEnded) return "over";
  if (!lost) return "connected";
  return heard_ms === null ? lost : `${lost}; last heard ${duration((Date.now() - heard_ms) / 1000)} ago`;
}

function show() {
  const isOver = view.over !== null || view.failed !== null;
  const act = action(view);
  const isWaiting = act && queue.isWaiting(act.type, act.order);
  setText($("agent"), view.agent ?? "Muster");
  $("connection").dataset.state = lost ? "lost" : "here";
  setText($("connection"), connection());
  setText($("title"), title(view));
  setLines($("lines"), lines(view, now_s(), Date.now()));
  setText($("act"), act ? `${act.text}${isWaiting ? " – not sent yet" : ""}` : "Nothing to press");
  $("act").disabled = !act || isWaiting;
  $("cannot").disabled = !view.agent || isOver || queue.pressed.some(({ type }) => type === "cannot");
  $("photo-label").hidden = !view.photos || isOver;
  const to = view.order?.to;
  $("geo").hidden = to?.latitude_deg === undefined;
  if (to?.latitude_deg !== undefined) {
    const place = `${to.latitude_deg.toFixed(6)},${to.longitude_deg.toFixed(6)}`;
    $("geo").href = `geo:${place}?q=${place}`;
  }
  drawMap($("map"), view);
  setText($("whereabouts"), whereabouts(view, gps, now_s()));
  const waiting = queue.pressed.length + photos.length;
  setText($("waiting"), waiting && !isEnded ? `${waiting} ${waiting === 1 ? "thing waits" : "things wait"} to be sent. Keep this page open.` : "");
  setLines($("notes"), notes);
}

/** Sends; returns the answer. Throws an Error that says why there is none. */
async function post(address, body, patience_ms) {
  const stop = new AbortController();
  const timer = setTimeout(() => stop.abort(), patience_ms);
  try {
    const response = await fetch(address, { method: "POST", body, signal: stop.signal, cache: "no-store" });
    const text = await response.text();
    if (response.ok) return JSON.parse(text);
    throw Object.assign(new Error(text.slice(0, 200)), { status: response.status });
  } catch (error) {
    if (error.status) throw error;
    throw new Error("no connection");
  } finally {
    clearTimeout(timer);
  }
}

async function sync() {
  if (isBusy) {
    isWanted = true;
    return;
  }
  isBusy = true;
  isWanted = false;
  try {
    const answer = await post("sync", JSON.stringify({ sent_ms: Date.now(), items: queue.next() }), PATIENCE_MS);
    for (const [item, why] of queue.settle(answer.results)) {
      if (item.type !== "place") note(why ? `not taken: "${WORDS[item.type]}": ${why}` : `sent: "${WORDS[item.type]}"`);
    }
    view = answer;
    heard_ms = Date.now();
    lost = "";
    isEnded = view.over !== null || view.failed !== null;
  } catch (error) {
    lost = error.status === 403 || error.status === 404 ? "this link is not valid any more" : error.message;
  }
  isBusy = false;
  show();
  if (isWanted && !isEnded && !lost) sync();
}

async function sendPhotos() {
  while (photos.length && !lost && !isEnded) {
    const [{ id, file, at_ms, session, order }] = photos;
    const query = new URLSearchParams({ id, ago_ms: Math.max(0, Date.now() - at_ms), session, order });
    try {
      const { photo } = await post(`photo?${query}`, file, PHOTO_PATIENCE_MS);
      note(`sent: ${photo}`);
    } catch (error) {
      if (!error.status || error.status >= 500) break;  // later
      note(`the photo was not taken: ${error.message}`);
    }
    photos.shift();
    show();
  }
}

function press(type, more = {}) {
  queue.add({ type, session: view.session, at_ms: Date.now(), ...more });
  show();
  sync();
}

function seePlace({ coords, timestamp }) {
  gps = "";
  placed_ms = Date.now();
  queue.add({ type: "place", at_ms: Math.min(timestamp, Date.now()), latitude_deg: coords.latitude, longitude_deg: coords.longitude, accuracy_m: coords.accuracy });
}

function seeNoPlace({ code }) {
  gps = code === 1 ? "this page may not ask for it (see the browser's settings)" : "the phone does not find it";
}

function follow() {
  if (!window.isSecureContext) gps = "the browser tells it to https pages only";
  else if (!navigator.geolocation) gps = "this browser tells none";
  if (gps) return;
  const how = { enableHighAccuracy: true, maximumAge: 0, timeout: PLACE_MS };
  navigator.geolocation.watchPosition(seePlace, seeNoPlace, how);
  setInterval(() => {
    if (!isEnded && Date.now() - placed_ms >= PLACE_MS) navigator.geolocation.getCurrentPosition(seePlace, seeNoPlace, how);
  }, PLACE_MS);
}

/** A dark phone asks for nothing, and counts as lost after a while. */
async function stayAwake() {
  try {
    if (document.visibilityState === "visible") await navigator.wakeLock?.request("screen");
  } catch { /* battery low, or not allowed */ }
}

$("act").addEventListener("click", () => {
  const act = action(view);
  if (act && !queue.isWaiting(act.type, act.order)) press(act.type, { order: act.order });
});
$("cannot").addEventListener("click", () => {
  $("reason").value = "";
  $("ask").returnValue = "";
  $("ask").showModal();
});
$("ask").addEventListener("close", () => {
  if ($("ask").returnValue === "leave") press("cannot", { reason: $("reason").value });
});
$("photo").addEventListener("change", () => {
  for (const file of $("photo").files) photos.push({ id: newId(), file, at_ms: Date.now(), session: view.session, order: view.order?.id ?? 0 });
  $("photo").value = "";
  show();
});
addEventListener("beforeunload", (event) => {
  if (photos.length && !isEnded) event.preventDefault();
});
document.addEventListener("visibilitychange", () => {
  stayAwake();
  if (document.visibilityState === "visible" && !isEnded) sync();
});

let isSendingPhotos = false;
const timer = setInterval(async () => {
  if (isEnded) clearInterval(timer);
  else sync();
  show();
  if (isSendingPhotos) return;
  isSendingPhotos = true;
  await sendPhotos();
  isSendingPhotos = false;
}, EVERY_MS);
follow();
stayAwake();
sync();
