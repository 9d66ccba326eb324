// The page of one person: asks how things are once a second, brings what was pressed and where the phone is.
import { Ground } from "./ground.mjs";
import { LANGUAGES, languageOf, say, speak } from "./language.mjs";
import { drawMap, SIZE } from "./map.mjs";
import { Noise } from "./noise.mjs";
import { newId, Queue } from "./queue.mjs";
import { action, duration, lines, title, whereabouts } from "./words.mjs";

const EVERY_MS = 1000, PATIENCE_MS = 8000, PHOTO_PATIENCE_MS = 240_000;
/** The phone is asked for its place when it has told none for so long. */
const PLACE_MS = 15_000;
const MOST_NOTES = 5;
const LABEL = "aria-label";
const WORDS = { here: "I am here", done: "Done", cannot: "I cannot …", message: "Message", help: "Call for help", late: "I will be late", pause: "Take a break", resume: "My break is over" };

const $ = (id) => document.getElementById(id);
let storage = null;
try {
  storage = localStorage;
} catch { /* not allowed: what is pressed waits in the page */ }
const code = languageOf(storage?.getItem("muster-phone-language"), navigator.languages ?? []);
if (code !== "en") speak((await import(`./${code}.mjs`)).default);
const queue = new Queue(storage, `muster-phone-${location.pathname}`);
const noise = new Noise($("sound"), storage);
const ground = new Ground($("ground"), () => show());
const photos = [];  // {id, file, at_ms, session, order}
const notes = [];
let view = { agent: null, over: null, failed: null, order: null };
let heard_ms = null;   // when it was heard last
let lost = say("connecting");  // why it is not; "": it is
let gps = "", placed_ms = 0;
let heading_deg = null;
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
  if (isEnded) return say("over");
  if (!lost) return say("connected");
  return heard_ms === null ? lost : say("{why}; last heard {time} ago", { why: lost, time: duration((Date.now() - heard_ms) / 1000) });
}

function showButtons(isOver) {
  const act = action(view);
  const isWaiting = act && queue.isWaiting(act.type, act.order);
  const waits = (...types) => queue.pressed.some(({ type }) => types.includes(type));
  setText($("act"), act ? `${act.text}${isWaiting ? ` – ${say("not sent yet")}` : ""}` : say("Nothing to press"));
  $("act").disabled = !act || isWaiting;
  for (const id of ["cannot", "pause"]) $(id).disabled = !view.agent || isOver;
  // Somebody who has left the mission may still call for help.
  for (const id of ["message", "help"]) $(id).disabled = !view.agent || view.over !== null;
  $("cannot").disabled ||= waits("cannot");
  $("pause").disabled ||= waits("pause", "resume");
  $("late").disabled = isOver || view.order?.stage !== "going";
  setText($("pause"), say(view.isPaused ? "My break is over" : "Take a break"));
  setText($("help"), say(view.called ? "I am all right again" : "Call for help"));
  $("photo-label").hidden = !view.photos || isOver;
  const to = view.order?.to;
  $("geo").hidden = to?.latitude_deg === undefined;
  if (to?.latitude_deg !== undefined) {
    const place = `${to.latitude_deg.toFixed(6)},${to.longitude_deg.toFixed(6)}`;
    $("geo").href = `geo:${place}?q=${place}`;
  }
}

function show() {
  const isOver = view.over !== null || view.failed !== null;
  setText($("agent"), view.agent ?? "Muster");
  $("connection").dataset.state = lost ? "lost" : "here";
  setText($("connection"), connection());
  setText($("title"), title(view));
  setLines($("lines"), lines(view, now_s(), Date.now(), heading_deg));
  setText($("called"), view.called ? say("You have called for help: {text}", { text: view.called }) : "");
  showButtons(isOver);
  ground.draw(view, drawMap($("map"), view, heading_deg), SIZE);
  setText($("source"), ground.source);
  setText($("whereabouts"), whereabouts(view, gps, now_s()));
  const n = queue.pressed.length + photos.length;
  setText($("waiting"), n && !isEnded ? say(n === 1 ? "1 thing waits to be sent. Keep this page open." : "{n} things wait to be sent. Keep this page open.", { n }) : "");
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
    throw new Error(say("no connection"));
  } finally {
    clearTimeout(timer);
  }
}

const wordsOf = ({ type, help }) => WORDS[help ? "help" : type];

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
      const values = { word: say(wordsOf(item)), why: say(why) };
      if (item.type !== "place") note(say(why ? "not taken: \"{word}\": {why}" : "sent: \"{word}\"", values));
    }
    view = answer;
    heard_ms = Date.now();
    lost = "";
    isEnded = view.over !== null;
    noise.hear([view.order?.goto, view.order?.stage === "working", view.stopped, view.over, view.failed].join());
  } catch (error) {
    lost = error.status === 403 || error.status === 404 ? say("this link is not valid any more") : error.message;
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
      note(say("sent: {photo}", { photo }));
    } catch (error) {
      if (!error.status || error.status >= 500) break;  // later
      note(say("the photo was not taken: {why}", { why: error.message }));
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
  if (Number.isFinite(coords.heading) && coords.speed > 0.5) heading_deg = coords.heading;
  queue.add({ type: "place", at_ms: Math.min(timestamp, Date.now()), latitude_deg: coords.latitude, longitude_deg: coords.longitude, accuracy_m: coords.accuracy });
}

function seeNoPlace({ code: why }) {
  gps = say(why === 1 ? "this page may not ask for it (see the browser's settings)" : "the phone does not find it");
}

function follow() {
  if (!window.isSecureContext) gps = say("the browser tells it to https pages only");
  else if (!navigator.geolocation) gps = say("this browser tells none");
  if (gps) return;
  const how = { enableHighAccuracy: true, maximumAge: 0, timeout: PLACE_MS };
  navigator.geolocation.watchPosition(seePlace, seeNoPlace, how);
  setInterval(() => {
    if (!isEnded && Date.now() - placed_ms >= PLACE_MS) navigator.geolocation.getCurrentPosition(seePlace, seeNoPlace, how);
  }, PLACE_MS);
  // A phone that lies flat: alpha is counted from north to west.
  addEventListener("deviceorientationabsolute", ({ alpha }) => { if (alpha !== null) heading_deg = (360 - alpha) % 360; });
}

/** A dark phone asks for nothing, and counts as lost after a while. */
async function stayAwake() {
  try {
    if (document.visibilityState === "visible") await navigator.wakeLock?.request("screen");
  } catch { /* battery low, or not allowed */ }
}

/** Opens a dialog; `then` is called with what stands in its field if it is not left by "back". */
function ask(id, then) {
  const dialog = $(id), field = dialog.querySelector("input, select");
  if (field.tagName === "INPUT") field.value = "";
  dialog.returnValue = "";
  dialog.showModal();
  dialog.addEventListener("close", () => dialog.returnValue === "go" && then(field.value), { once: true });
}

function translate() {
  document.documentElement.lang = code;
  for (const element of document.querySelectorAll("[data-say]")) element.append(say(element.dataset.say));
  for (const option of document.querySelectorAll("datalist option")) option.value = say(option.value);
  for (const element of document.querySelectorAll(`[${LABEL}]`)) element.setAttribute(LABEL, say(element.getAttribute(LABEL)));
  const select = $("language");
  for (const [its, name] of Object.entries(LANGUAGES)) select.append(Object.assign(document.createElement("option"), { value: its, lang: its, textContent: name }));
  select.value = code;
  select.addEventListener("change", () => {
    storage?.setItem("muster-phone-language", select.value);
    location.reload();
  });
}

$("act").addEventListener("click", () => {
  const act = action(view);
  if (act && !queue.isWaiting(act.type, act.order)) press(act.type, { order: act.order });
});
$("cannot").addEventListener("click", () => ask("ask-cannot", (reason) => press("cannot", { reason })));
$("message").addEventListener("click", () => ask("ask-message", (text) => press("message", { text })));
$("late").addEventListener("click", () => ask("ask-late", (minutes) => press("late", { minutes: Number(minutes), order: view.order?.goto })));
$("help").addEventListener("click", () => {
  if (view.called) press("message", { text: "all right again" });
  else ask("ask-help", (text) => press("message", { text, help: true }));
});
$("pause").addEventListener("click", () => press(view.isPaused ? "resume" : "pause"));
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
translate();
follow();
stayAwake();
sync();
navigator.serviceWorker?.register("worker.js").catch(() => {});  // without it the page needs the connection to open
