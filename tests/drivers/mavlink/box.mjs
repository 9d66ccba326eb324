// A driver and a copter in one process, with a link between them that loses and delays on purpose, and the mission that speaks
// to the driver. Time is a number: an hour takes a second, and every run is the same.
import { Driver } from "../../../drivers/mavlink/driver.mjs";
import { FrameReader } from "../../../drivers/mavlink/frames.mjs";
import { Signing } from "../../../drivers/mavlink/signing.mjs";
import { MissionMap } from "../../../drivers/places.mjs";
import { Copter } from "./copter.mjs";
import { CopterProtocol } from "./copter_protocol.mjs";
import { Referee } from "./referee.mjs";

const STEP_S = 0.02, TICK_S = 30;
/** Of the wall, at the beginning. */
const BEGUN_MS = Date.UTC(2026, 10, 27);
export const ORIGIN = { latitude_deg: 52.2, longitude_deg: 0.1 };
export const AREA = { width_m: 4000, height_m: 3000 };
export const START = { x_m: 500, y_m: 400 };
const SPEED_M_S = 12, FULL_M = 20000;

const OPTIONS = {
  system: 3, ownSystem: 255, altitude: 40, altitudeStep: 5, ceiling: 120, reserve: 25, landIdle: 120, confirm: "battery", charged: 90, cells: 4, camera: "digicam", speedup: 1,
};

const READER = new FrameReader();

/** A message on the link, which is read only where somebody asks what it is. */
class Sent {
  #frame = null;
  #bytes;

  constructor(direction, bytes) {
    this.direction = direction;
    this.#bytes = bytes;
  }

  get #read() {
    return (this.#frame ??= READER.readDatagram(this.#bytes)[0]);
  }

  get name() {
    return this.#read.name;
  }

  get message() {
    return this.#read.message;
  }
}

export class Box {
  now = 0;
  lines = [];   // what the driver says: [seconds, object]
  notes = [];
  pictures = [];
  kept = null;  // settings that are kept
  isChanged = false;
  /** The driver gets no processor time; what is sent to it waits. */
  isStalled = false;
  /** Of the link: seconds; whether a message gets lost, of {direction: "up" to the copter or "down", name, message}. */
  delay_s = 0.02;
  loses = () => false;
  /** So much later than it is the mission tells the time, of a tick's number. */
  tickLate_s = () => 0;
  /** What was sent, by direction: bytes. */
  sent = { up: [], down: [] };
  #onTheWay = [];
  #ids = 0;
  #told_s = 0;
  #said = new Map();  // type -> lines of it

  constructor({ kind = "ardupilot", options = {}, at = START, battery, drain_percent_s, ready_s, hover, hello = {}, key = null, copterKey = key } = {}) {
    this.map = new MissionMap(ORIGIN);
    this.copter = new Copter({ kind, at: this.map.toDegrees(at), drain_percent_s, ready_s, hover });
    if (battery !== undefined) this.copter.battery_percent = battery;
    const signs = copterKey && new Signing(copterKey, () => this.unix_ms);
    this.protocol = new CopterProtocol(this.copter, { system: 3, send: (bytes) => this.#put("down", bytes), signing: signs });
    this.key = key;
    this.startDriver({ ...OPTIONS, ...options });
    this.greeting = {
      type: "hello", version: 1, agent: "uav:3", class: "uav", speed_m_s: SPEED_M_S, full_range_m: FULL_M, range_m: FULL_M, at: START,
      area: AREA, origin: ORIGIN, rate: 1, mission_s: 0, online_from_s: 0, online_until_s: 36000, ...hello,
    };
    this.referee = new Referee(this.greeting);
    this.tell(this.greeting);
  }

  get unix_ms() {
    return BEGUN_MS + 1000 * this.now;
  }

  startDriver(options) {
    this.signing = this.key && new Signing(this.key, () => this.unix_ms);
    this.reader = new FrameReader(this.signing);
    this.driver = new Driver(options, {
      now: () => this.now,
      say: (line) => {
        this.lines.push([this.now, line]);
        this.#keep(line);
        this.referee.hear(line, this.now);
      },
      send: (bytes) => this.#put("up", bytes),
      note: (words) => this.notes.push(words),
      kept: { load: () => structuredClone(this.kept), save: (object) => (this.kept = structuredClone(object)), drop: () => (this.kept = null) },
      isChanged: () => this.isChanged && ((this.isChanged = false), true),
      keepPicture: (of) => this.pictures.push(of),
      signing: this.signing,
    });
    this.isDead = false;
  }

  #put(direction, bytes) {
    this.sent[direction].push(bytes);
    if (this.loses(new Sent(direction, bytes))) return;
    this.#onTheWay.push({ direction, bytes, due: this.now + this.delay_s });
  }

  /** The driver hears that; returns whether it believes some of it. */
  hear(bytes) {
    return this.reader.readDatagram(bytes).filter((frame) => this.driver.hearFrame(frame)).length > 0;
  }

  tell(line) {
    this.referee.told(line, this.now);
    if (!this.isDead) this.driver.hearLine(JSON.stringify(line));
  }

  goTo(x_m, y_m, then = "wait", via = undefined, more = {}) {
    this.tell({ type: "goto", id: ++this.#ids, mission_s: this.now, to: { x_m, y_m }, expected_s: this.now + 100, then, task: null, charging_point: null, partner: null, ...(via && { via }), ...more });
    return this.#ids;
  }

  order(type, for_s) {
    this.tell({ type, id: ++this.#ids, mission_s: this.now, for_s });
    return this.#ids;
  }

  /** Of the copter. It forgets what it was told, and hears nothing. */
  cutPower() {
    this.isPowerCut = true;
  }

  /** With a battery of that charge, of which it knows nothing. */
  restorePower(charge_percent = 100) {
    this.isPowerCut = false;
    this.copter.charge_percent = charge_percent;
    this.copter.boot(this.now);
    this.protocol.boot();
  }

  step() {
    this.now += STEP_S;
    if (this.#onTheWay.length) this.#bring();
    this.copter.step(this.now);
    if (!this.isPowerCut) this.protocol.step();
    if (this.isDead || this.isStalled) return;
    const tick_s = this.#told_s + TICK_S;
    if (this.now >= tick_s + this.tickLate_s(tick_s / TICK_S)) this.tell({ type: "time", mission_s: (this.#told_s = tick_s) });
    this.driver.step();
  }

  /** What is on the way and due. */
  #bring() {
    const isDue = ({ due, direction }) => due <= this.now && !(this.isStalled && direction === "down");
    const due = this.#onTheWay.filter(isDue);
    this.#onTheWay = this.#onTheWay.filter((packet) => !isDue(packet));
    for (const { direction, bytes } of due) {
      if (direction === "up") {
        if (!this.isPowerCut) this.protocol.hear(bytes);
      } else if (!this.isDead) this.hear(bytes);
    }
  }

  /** Goes on until that is so; returns how long it took. Fails when it is not by then. */
  until(isSo, most_s, what = String(isSo)) {
    const from = this.now;
    while (!isSo()) {
      if (this.now - from > most_s) throw new Error(`not within ${most_s} s: ${what}\nnotes: ${this.notes.join(" | ")}\nmodes: ${this.copter.history.join(" ")}`);
      this.step();
      if (this.referee.wrong.length) throw new Error(`wrong: ${this.referee.wrong[0]}`);
    }
    return this.now - from;
  }

  run(seconds) {
    const from = this.now;
    while (this.now - from < seconds) this.step();
  }

  /** The lines of that type, or those of that type with that number. */
  said(type, id) {
    const lines = this.#said.get(type) ?? [];
    return lines.filter((line) => id === undefined || line.id === id);
  }

  /** For said(), which is asked at every step. */
  #keep(line) {
    if (!this.#said.has(line.type)) this.#said.set(line.type, []);
    this.#said.get(line.type).push(line);
  }

  get failure() {
    return this.said("failed")[0]?.reason ?? null;
  }

  /** Where the copter is on the mission's map. */
  get place() {
    return this.map.toMetres(this.copter.place);
  }

  ready() {
    this.until(() => this.notes.some((words) => words.startsWith("ready")), 60 * this.driver.options.speedup, "ready");
    return this;
  }

  /** Takes off, and is on its way to a place a kilometre away. */
  flying() {
    this.ready();
    this.goTo(1500, 400);
    this.until(() => this.place.x_m > 700, 120, "on its way");
    return this;
  }

  landed(most_s = 900) {
    return this.until(() => !this.copter.armed, most_s, "landed");
  }

  distanceTo({ x_m, y_m }) {
    return Math.hypot(this.place.x_m - x_m, this.place.y_m - y_m);
  }
}
