// One person's part: lines of the mission (docs/guide/drivers.md) on one side, what the phone's page sends on the other, as a function
// of what it hears and of the time. Sockets, clocks and files are elsewhere.
import { randomUUID } from "node:crypto";
import { MissionMap } from "../places.mjs";
import { Track } from "./track.mjs";

/** So many of what was pressed and seen is remembered, so that nothing is taken twice. */
const MOST_REMEMBERED = 2000;
const MOST_ITEMS = 200;
const LONGEST_BYTES = 480;  // of what is said
const FAR_M = 300;  // that far from the place, "I am here" is asked back
const FRESH_S = 60;  // a place is not believed for longer, wall time
const ID = /^[0-9a-zA-Z-]{8,40}$/;

class Refusal extends Error {}

function between(value, low, high, what) {
  if (!(typeof value === "number" && value >= low && value <= high)) throw new Refusal(`${what} is not a number from ${low} to ${high}`);
  return value;
}

/** A person's words in one line, as long as the mission takes. */
function plain(words) {
  if (typeof words !== "string") return "";
  const letters = [...words.replace(/[\p{Cc}\p{Cf}\s]+/gu, " ").trim()];
  for (let left = LONGEST_BYTES, i = 0; i < letters.length; ++i) {
    left -= Buffer.byteLength(letters[i]);
    if (left < 0) return letters.slice(0, i).join("");
  }
  return letters.join("");
}

function minutes(seconds) {
  return seconds < 60 ? `${Math.round(seconds)} s` : `${Math.round(seconds / 60)} min`;
}

export class Phone {
  /** Of this start of the driver: numbers of orders count anew in each. */
  session = randomUUID();
  hello = null;
  /** null: none; else {goto, to, way (places, or null without roads), stage: "going", "held", "there", "working" or "finished", work}. */
  order = null;
  /** Why it was stopped, when it has no order any more. */
  stopped = null;
  failed = null;
  over = null;
  /** It has a break, or will have it when its order is done. */
  isPaused = false;
  /** What it called for help with; null: it does not, or not any more. */
  called = null;
  /** A phone has been there. */
  isHeard = false;
  /** Its page has been told that it is over. */
  isOverTold = false;
  #told_s = 0;  // the mission's time, told at:
  #told_at = 0;
  #tick_s = 0;
  #word_at = 0;  // the phone was heard last, by the wall
  #taken = new Map();
  #orders = new Map();
  #place = null;  // the phone's, as it told it: {latitude_deg, longitude_deg, accuracy_m, x_m, y_m, mission_s, trouble}

  /** `options`: {lostAfter, accuracy, isAuto, photos}; `edge`: {now() in seconds of the wall, say(object), note(words)}. */
  constructor(options, edge) {
    Object.assign(this, { options, edge });
  }

  get mission_s() {
    return this.#told_s + (this.edge.now() - this.#told_at) * (this.hello.rate ?? 0);
  }

  /** The mission takes what is said now for said by then: at its next tick at the latest, which may be late by the wall. */
  get #heard_s() {
    return Math.min(this.mission_s, this.#told_s + this.#tick_s);
  }

  /** Takes a line of the mission. What is none is passed over. */
  hearLine(text) {
    let line = null;
    try {
      line = JSON.parse(text);
    } catch {
      return this.edge.note("a line of the mission is no JSON");
    }
    const take = {
      hello: () => this.#hello(line), time: () => this.#time(line), goto: () => this.#goTo(line), sense: () => this.#work(line),
      charge: () => this.#work(line), meeting: () => this.#meet(line), cancel: () => this.#cancel(line), bye: () => this.bye(line.reason),
    };
    if (line && Object.hasOwn(take, line.type) && (this.hello || line.type === "hello" || line.type === "bye")) take[line.type]();
  }

  /** The mission is over, or gone. */
  bye(reason) {
    if (this.over === null) this.edge.note(`the mission is over: ${reason}`);
    this.over ??= String(reason);
    this.order = null;
  }

  #hello(line) {
    if (this.hello) return;
    this.hello = line;
    this.map = line.origin ? new MissionMap(line.origin) : null;
    this.track = new Track(line);
    this.#told_s = line.mission_s;
    this.#told_at = this.#word_at = this.edge.now();
    const isThere = this.isHeard || this.options.isAuto;
    this.edge.say({ type: "hello", version: 1, name: `phone of ${line.agent}`, ...(isThere ? {} : { not_ready: "a word of its phone" }) });
    if (line.class === "uav") this.fail("a phone is for workers and vehicles, not for a uav");
    else if (line.rate === null && !this.options.isAuto) this.fail("the mission runs at full speed: a person needs a rate");
  }

  #time(line) {
    if (line.mission_s > this.#told_s) this.#tick_s = line.mission_s - this.#told_s;
    this.#told_s = line.mission_s;
    this.#told_at = this.edge.now();
    this.beforeTick?.();  // --auto
    this.step();
    if (this.failed !== null || this.over !== null) return;
    const told = this.track.tell(line.mission_s);
    const late_s = this.order?.stage === "going" ? this.order.late_s : null;
    this.edge.say({ type: "state", ...told, ...(late_s > line.mission_s ? { expected_s: late_s } : {}) });
  }

  /** It has no order, or another; what it said of the one before was of that. */
  #drop() {
    if (this.order?.stage === "held") this.track.forget();
    this.order = null;
  }

  #goTo(line) {
    this.#drop();
    const metres = (place) => (Number.isFinite(place.x_m) ? { x_m: place.x_m, y_m: place.y_m } : this.map.toMetres(place));
    const to = metres(line.to);
    // By road: from where it is now.
    const way = line.via ? [this.track.last.at, ...line.via.map(metres), to] : null;
    this.order = { id: line.id, goto: line, to, way, stage: "going", work: null, late_s: null, meeting_s: null };
    this.stopped = null;
    this.#orders.set(line.id, line);
  }

  #meet({ id, expected_s }) {
    if (this.order?.goto.id === id && Number.isFinite(expected_s)) this.order.meeting_s = expected_s;
  }

  #work(line) {
    if (!this.order) return;
    Object.assign(this.order, { id: line.id, work: line, stage: "working" });
    this.#orders.set(line.id, this.order.goto);
  }

  #cancel(line) {
    this.#drop();
    this.stopped = String(line.reason);
  }

  fail(reason) {
    if (this.failed !== null || this.over !== null) return;
    this.failed = reason;
    this.edge.note(`out of the mission: ${reason}`);
    this.edge.say({ type: "failed", id: this.order?.id ?? null, reason });
    this.order = null;
  }

  /** Goes on as far as it can. Some times a second. */
  step() {
    const { order, hello, options } = this;
    if (!hello || this.failed !== null || this.over !== null) return;
    if (order?.stage === "held" && this.#heard_s >= this.track.soonest_s(order.to)) {
      order.stage = "there";
      this.track.arrive(order.to, this.mission_s);
      this.edge.say({ type: "arrived", id: order.goto.id });
    }
    if (options.isAuto) return;
    const now = this.edge.now();
    if (this.mission_s < hello.online_from_s || (!this.isHeard && !order)) this.#word_at = now;  // nobody is asked anything yet
    if (now - this.#word_at > options.lostAfter) this.fail(`no word from the phone for ${minutes(options.lostAfter)}`);
  }

  /** Of an order that was given: {task, ...} as the mission told it; undefined: there was none of that number. */
  orderOf(id) {
    return this.#orders.get(id);
  }

  /**
   * The page asks how things are, and brings what was pressed and seen: {session, sent_ms, items: [{id, session, at_ms, type,
   * ...}]}, in order. Returns what became of each, and how things are. Throws a TypeError when it is none of that.
   */
  sync(asked) {
    const { items, sent_ms } = asked ?? {};
    if (!Array.isArray(items) || items.length > MOST_ITEMS || !Number.isFinite(sent_ms)) throw new TypeError("expected sent_ms and items");
    if (items.some((item) => typeof item !== "object" || item === null || !ID.test(item.id) || !Number.isFinite(item.at_ms))) {
      throw new TypeError("expected items with id and at_ms");
    }
    this.#word_at = this.edge.now();
    if (!this.isHeard && !this.options.isAuto) {
      this.edge.note("the phone is there");
      if (this.hello && this.failed === null && this.over === null) this.edge.say({ type: "ready" });
    }
    this.isHeard ||= !this.options.isAuto;
    const results = Object.fromEntries(items.map((item) => [item.id, this.#once(item, Math.max(0, sent_ms - item.at_ms) / 1000)]));
    if (this.over !== null) this.isOverTold = true;
    return { results, ...this.view() };
  }

  #once(item, ago_s) {
    const before = this.#taken.get(item.id);
    if (before !== undefined) return before;
    let result = "";
    try {
      this.#take(item, ago_s);
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      result = error.message;
    }
    this.#taken.set(item.id, result);
    if (this.#taken.size > MOST_REMEMBERED) this.#taken.delete(this.#taken.keys().next().value);
    return result;
  }

  #take(item, ago_s) {
    if (!this.hello) throw new Refusal("the mission has not begun");
    if (this.over !== null || (this.failed !== null && item.type !== "message")) throw new Refusal("you are out of the mission");
    if (item.type === "place") return this.#seePlace(item, ago_s);
    if (!["here", "done", "cannot", "message", "late", "pause", "resume"].includes(item.type)) throw new Refusal("that is not known here");
    if (item.session !== this.session) throw new Refusal("the mission's program has started again since; if it is still so, say it again");
    this.edge.note(`${item.type}, pressed ${minutes(ago_s)} ago`);
    if (item.type === "cannot") return this.#cannot(item);
    if (item.type === "message") return this.#message(item);
    if (item.type === "pause" || item.type === "resume") return this.#pause(item.type === "pause");
    const { order } = this;
    const isHere = item.type === "here";
    const isOnItsWay = isHere || item.type === "late";
    if (!order || item.order !== (isOnItsWay ? order.goto.id : order.work?.id)) throw new Refusal("the mission has told you something else since");
    if (item.type === "late") this.#late(order, item, ago_s);
    else if (isHere) this.#here(order);
    else if (order.stage === "working") this.#done(order);
  }

  #here(order) {
    if (order.stage !== "going") return;
    const far_m = this.#farFrom(order.to);
    if (far_m !== null && order.doubted !== true) {
      order.doubted = true;
      throw new Refusal(`your phone is ${far_m < 1000 ? `${Math.round(far_m / 10) * 10} m` : `${(far_m / 1000).toFixed(1)} km`} from there; if you are there, press again`);
    }
    order.stage = "held";
    this.track.see(order.to, this.mission_s);
    this.step();
  }

  /** Metres between the phone and a place that it is not near to; null: it is near, or has not told lately where it is. */
  #farFrom(to) {
    const place = this.#place;
    if (!place || place.trouble || this.mission_s - place.mission_s > FRESH_S * this.hello.rate) return null;
    const far_m = Math.hypot(place.x_m - to.x_m, place.y_m - to.y_m);
    return far_m > FAR_M + place.accuracy_m ? far_m : null;
  }

  #done(order) {
    order.stage = "finished";
    this.track.stay(this.mission_s);
    this.edge.say({ type: "done", id: order.work.id });
  }

  #cannot({ reason }) {
    this.fail(`says: ${plain(reason) || "I cannot"}`);
  }

  #message({ text, help }) {
    const words = plain(text);
    if (!words) throw new Refusal("there is nothing in that message");
    this.called = help === true ? words : null;
    this.edge.say({ type: "message", text: words, ...(help === true ? { help: true } : {}) });
  }

  /** The mission sends it nowhere as long as it is not ready; what it was told already goes on. */
  #pause(isPaused) {
    if (this.isPaused === isPaused) return;
    this.isPaused = isPaused;
    this.edge.say(isPaused ? { type: "not_ready", reason: "the end of a break" } : { type: "ready" });
  }

  /** It comes so much later than planned, or than when that was pressed if that is over. */
  #late(order, { minutes: later }, ago_s) {
    if (order.stage !== "going") return;
    const { rate } = this.hello;
    order.late_s = Math.max(order.goto.expected_s, this.mission_s - ago_s * rate) + 60 * between(later, 1, 600, "minutes") * rate;
  }

  #seePlace(item, ago_s) {
    if (!this.map) throw new Refusal("the mission has no origin: it is nowhere on the earth");
    const place = {
      latitude_deg: between(item.latitude_deg, -90, 90, "latitude_deg"), longitude_deg: between(item.longitude_deg, -180, 180, "longitude_deg"),
      accuracy_m: between(item.accuracy_m, 0, 1e7, "accuracy_m"), mission_s: Math.max(this.hello.mission_s, this.mission_s - ago_s * this.hello.rate),
    };
    const at = this.map.toMetres(place);
    let trouble = null;
    if (place.accuracy_m > this.options.accuracy) trouble = "inexact";
    else if (this.track.isOutside(at)) trouble = "outside";
    if (!this.#place || place.mission_s >= this.#place.mission_s) this.#place = { ...place, ...at, trouble };
    // Who has said "I am here" is there.
    if (!trouble && this.order?.stage !== "held") this.track.see(at, place.mission_s);
  }

  /** Where the phone is, as it told it last; null: it never has. */
  get place() {
    return this.#place;
  }

  /** How things are, for the page. */
  view() {
    const { hello, order, track } = this;
    const base = { session: this.session, over: this.over, failed: this.failed, photos: this.options.photos };
    if (!hello) return base;
    const { agent, rate, area, speed_m_s, online_from_s, online_until_s } = hello;
    return {
      ...base, agent, class: hello.class, rate, area, speed_m_s, online_from_s, online_until_s, mission_s: this.mission_s,
      has_origin: this.map !== null,
      origin: hello.origin ?? null, has_tiles: this.options.hasTiles === true, accuracy_m: this.options.accuracy, place: this.#place, stopped: this.stopped,
      isPaused: this.isPaused, called: this.called,
      told: { ...track.last.at, is_limited: track.isLimited || order?.stage === "held" },
      order: order && {
        id: order.id, stage: order.stage, to: { ...order.goto.to, ...order.to }, way: order.way,
        then: order.goto.then, task: order.goto.task, task_name: order.goto.task_name ?? "", task_note: order.goto.task_note ?? "", goto: order.goto.id,
        charging_point: order.goto.charging_point, partner: order.goto.partner, expected_s: order.late_s ?? order.goto.expected_s,
        meeting_s: order.meeting_s, priority: order.goto.priority ?? 1, due_s: order.goto.due_s ?? null,
        work: order.work?.type ?? null, ends_s: order.work ? order.work.mission_s + order.work.for_s : null,
        held_until_s: order.stage === "held" ? track.soonest_s(order.to) : null,
      },
    };
  }
}
