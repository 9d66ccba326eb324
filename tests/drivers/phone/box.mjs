// A person's driver in virtual time: a mission that tells it lines and holds its speed against it, and a phone.
import { Phone } from "../../../drivers/phone/phone.mjs";
import { MissionMap } from "../../../drivers/places.mjs";

export const ORIGIN = { latitude_deg: 18.41, longitude_deg: -72.47 };
export const map = new MissionMap(ORIGIN);
export const TICK_S = 30;
const distance_m = (a, b) => Math.hypot(a.x_m - b.x_m, a.y_m - b.y_m);

export function helloOf(more = {}) {
  return { type: "hello", version: 1, agent: "worker:4", class: "worker", speed_m_s: 5, at: { x_m: 4000, y_m: 4000 }, area: { width_m: 10000, height_m: 10000 },
    origin: ORIGIN, rate: 1, mission_s: 0, online_from_s: 0, online_until_s: 86400, ...more };
}

export class Box {
  wall_s = 1000;
  said = [];
  notes = [];
  /** What the mission would call impossible (model/measured.cc). */
  wrong = [];
  ticks = 0;
  #items = 0;
  #orders = 0;

  constructor(hello = helloOf(), options = {}) {
    this.hello = hello;
    this.seen = { at: hello.at, at_s: hello.mission_s };
    this.phone = new Phone({ lostAfter: 600, accuracy: 100, isAuto: false, photos: true, ...options }, {
      now: () => this.wall_s, say: (line) => this.#hear(line), note: (words) => this.notes.push(words) });
    this.tell(hello);
  }

  get mission_s() {
    return this.hello.mission_s + (this.wall_s - 1000) * (this.hello.rate ?? 0);
  }

  #isPossible(at, at_s) {
    const way_m = distance_m(this.seen.at, at), time_s = at_s - this.seen.at_s;
    if (way_m > this.hello.speed_m_s * (Math.max(0, time_s) + 1)) this.wrong.push(`${way_m} m in ${time_s} s`);
    if (at_s > this.mission_s + 1.25) this.wrong.push(`of ${at_s} s, and it is ${this.mission_s} s`);
  }

  #hear(line) {
    this.said.push(line);
    if (line.type === "state") {
      if (line.mission_s < Math.max(this.seen.at_s, this.set_out_s ?? 0)) return;  // old: passed over
      this.#isPossible(line.at, line.mission_s);
      this.seen = { at: line.at, at_s: line.mission_s };
    } else if (line.type === "arrived") {
      const now_s = Math.min(this.mission_s, (this.ticks + 1) * TICK_S);
      this.#isPossible(this.goal, now_s);
      this.seen = { at: this.goal, at_s: Math.max(now_s, this.seen.at_s) };
    }
  }

  tell(line) {
    this.phone.hearLine(JSON.stringify(line));
  }

  goTo(to, more = {}) {
    this.goal = to;
    this.set_out_s = this.ticks * TICK_S;
    const id = ++this.#orders;
    const expected_s = this.set_out_s + distance_m(this.seen.at, to) / this.hello.speed_m_s;
    this.tell({ type: "goto", id, mission_s: this.set_out_s, to: { ...to, ...map.toDegrees(to) }, expected_s, then: "sense", task: 12, charging_point: null, partner: "uav:3", ...more });
    return id;
  }

  work(type, for_s = 60) {
    const id = ++this.#orders;
    this.tell({ type, id, mission_s: this.mission_s, for_s });
    return id;
  }

  cancel(reason = "given up") {
    this.set_out_s = this.ticks * TICK_S;
    this.tell({ type: "cancel", id: this.#orders, mission_s: this.set_out_s, reason });
  }

  /** Lets so many ticks of the mission pass; the phone, if there is one, is asked by `each` in every second of the wall. */
  pass(ticks, each = () => {}) {
    const tick_wall_s = TICK_S / (this.hello.rate ?? TICK_S);
    for (const until = this.ticks + ticks; this.ticks < until;) {
      const due_s = 1000 + (this.ticks + 1) * tick_wall_s;
      while (this.wall_s + 0.1 < due_s) {
        this.wall_s += 0.1;
        if (Math.abs(this.wall_s - Math.round(this.wall_s)) < 0.05) each();
        this.phone.step();
      }
      this.wall_s = due_s;
      ++this.ticks;
      this.tell({ type: "time", mission_s: this.hello.mission_s + this.ticks * TICK_S });
    }
  }

  item(type, more = {}, at_s = this.wall_s) {
    return { id: `item-${String(++this.#items).padStart(6, "0")}`, type, session: this.phone.session, at_ms: at_s * 1000, ...more };
  }

  sync(...items) {
    return this.phone.sync({ sent_ms: this.wall_s * 1000, items });
  }

  /** Presses, and returns "" or why it is not taken. */
  press(type, more) {
    const item = this.item(type, more);
    return this.sync(item).results[item.id];
  }

  /** The phone is there. */
  place(at, accuracy_m = 8, at_s = this.wall_s) {
    return this.item("place", { ...map.toDegrees(at), accuracy_m }, at_s);
  }

  last(type) {
    return this.said.findLast((line) => line.type === type);
  }
}
