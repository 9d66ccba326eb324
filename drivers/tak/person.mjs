// A TAK user's part in a mission: orders of the mission become messages, a place to go to and a route; the user's place and words become
// what a phone would say. The rules of a person's part are those of phones (drivers/phone/phone.mjs).
import { createHash } from "node:crypto";
import { chat, deletion, event, route } from "./cot.mjs";

const HOLDS_MS = 60_000;
const SHOWN_MS = 10 * 60_000;
const GUESSED_M = 50; // of a place whose accuracy is not said
const AWAY_MS = 60_000; // who was silent for longer is told again what to do
const HELP = "write: here, done, battery changed, cannot WHY";

/** "task 12, School"; undefined: the goto is to a place. */
function goalOf({ task, task_name: name, charging_point: charge }) {
  if (task !== null) return name ? `task ${task}, ${name}` : `task ${task}`;
  return charge === null ? undefined : `charging point ${charge}`;
}

const lasts = (seconds) => (seconds < 90 ? `${Math.round(seconds)} s` : `${Math.round(seconds / 60)} min`);

export class Person {
  #told = ""; // what the newest message was about
  #seen_ms = null; // the user was heard last
  #shown = null; // {key, until} of the goal
  #present_ms = -Infinity; // our own contact was said last
  #number = 0;

  /** `phone`: Phone; `send(event)`: to TAK; `clock(ms)`: a time for people. */
  constructor({ callsign, phone, send, clock, session }) {
    Object.assign(this, { callsign, phone, send, clock, session });
  }

  get self() {
    const { agent } = this.phone.hello;
    return { uid: `muster.${agent.replace(":", ".")}`, callsign: `MUSTER ${agent}` };
  }

  /** An event of TAK, as readEvent read it. */
  hear(read, now) {
    const { phone } = this;
    if (!phone.hello) return;
    if (read.chat) {
      const isOurs = read.chat.room === this.self.callsign || read.chat.room === this.self.uid;
      if (isOurs && read.chat.sender === this.callsign) this.#command(read, now);
    } else if (/^a-f-/.test(read.type) && read.callsign === this.callsign) {
      this.uid = read.uid;
      const wasAway = this.#seen_ms === null || now - this.#seen_ms > AWAY_MS;
      this.#seen_ms = now;
      this.#give(read, now, { type: "place", latitude_deg: read.at.latitude, longitude_deg: read.at.longitude, accuracy_m: read.ce ?? GUESSED_M });
      if (wasAway) this.#told = "";
    }
  }

  /** What the mission made of it; "": taken. The same event twice is the same word. */
  #give(read, now, item) {
    const id = createHash("sha256").update(`${read.uid} ${read.time} ${read.chat ? read.remarks : ""}`).digest("hex").slice(0, 32);
    const { results } = this.phone.sync({ sent_ms: now, items: [{ id, session: this.phone.session, at_ms: read.time, ...item }] });
    return results[id];
  }

  #command(read, now) {
    const [verb, ...rest] = read.remarks.trim().split(/\s+/);
    const words = read.remarks.trim().toLowerCase();
    const { order } = this.phone;
    let refused = null;
    if (/^(i am |i'm )?(here|there)$/.test(words)) refused = order ? this.#give(read, now, { type: "here", order: order.goto.id }) : "you are not sent anywhere";
    else if (/^(done|(battery )?changed)$/.test(words)) refused = order?.work ? this.#give(read, now, { type: "done", order: order.work.id }) : "nothing of yours has begun";
    else if (/^cannot$/i.test(verb) && rest.length > 0) refused = this.#give(read, now, { type: "cannot", reason: rest.join(" ") });
    else if (/^cannot$/i.test(verb)) refused = "say why: cannot WHY. It takes you out of the mission for good";
    else this.#told = ""; // said again, with what may be said
    if (refused) this.#say(refused, now);
    this.step(now);
  }

  #say(text, now) {
    if (!this.uid) return; // nobody to say it to, yet
    this.send(chat({ from: this.self, to: { callsign: this.callsign, uid: this.uid }, text, at: this.#here, now, number: `${this.session}-${++this.#number}` }));
  }

  #degrees(place) {
    const { map } = this.phone;
    if (!map) return { latitude: 0, longitude: 0 };
    const { latitude_deg: latitude, longitude_deg: longitude } = map.toDegrees(place);
    return { latitude, longitude };
  }

  get #here() {
    return this.#degrees(this.phone.track.last.at);
  }

  /** [what it is about, words] of how things are. */
  #story(now) {
    const { phone } = this;
    const { order, hello } = phone;
    if (phone.over !== null) return ["over", `the mission is over: ${phone.over}`];
    if (phone.failed !== null) return ["failed", `you are out of the mission: ${phone.failed}`];
    if (!order) return [`none ${phone.stopped}`, phone.stopped === null ? "wait; you will be told where to go" : `stop, and stay where you are: ${phone.stopped}`];
    const { partner, expected_s: expected, then } = order.goto;
    const goal = goalOf(order.goto) ?? "the place that is shown";
    const with_ = partner ? `, meet ${partner} there` : "";
    const by = hello.rate ? ` by ${this.clock(now + (1000 * (expected - phone.mission_s)) / hello.rate)}` : "";
    if (order.stage === "working") return [`work ${order.id}`, order.work.type === "charge" ? `change the battery (${lasts(order.work.for_s)}); then write: battery changed` : `sensing of ${goal} has begun (${lasts(order.work.for_s)}); when it is finished, write: done`];
    if (order.stage === "finished") return [`finished ${order.id}`, "thank you; wait for what comes next"];
    if (order.stage !== "going") return [`there ${order.goto.id}`, then === "wait" ? `you are at ${goal}; wait there` : `you are at ${goal}; wait for ${partner ?? "what comes next"}`];
    return [`going ${goal} ${partner}`, `go to ${goal}${with_}${by}; there, write: here`];
  }

  /** Says and shows what is new. Some times a second. */
  step(now) {
    const { phone } = this;
    if (!phone.hello) return;
    if (now - this.#present_ms > HOLDS_MS / 2) {
      this.#present_ms = now;
      this.send(event({ uid: this.self.uid, type: "a-f-G-I", at: this.#here, now, holds: HOLDS_MS, detail: { contact: { $: { callsign: this.self.callsign, endpoint: "*:-1:stcp" } },
        __group: { $: { name: "White", role: "HQ" } }, remarks: `Tells ${this.callsign} what to do; ${HELP}` } }));
    }
    const [about, words] = this.#story(now);
    if (about !== this.#told && this.uid) {
      const isAnswer = this.#told === "";
      this.#told = about;
      this.#say(isAnswer ? `${words} (${HELP})` : words, now);
    }
    this.#show(now);
  }

  /** The goal as a point to go to, and the way there. */
  #show(now) {
    const { order, map, hello } = this.phone;
    const isGoing = order?.stage === "going" && map && this.phone.over === null && this.phone.failed === null;
    const key = isGoing ? `${order.goto.id}` : "";
    if (key === (this.#shown?.key ?? "") && now < (this.#shown?.until ?? Infinity)) return;
    const uid = `${this.self.uid}.goto`, way = `${this.self.uid}.way`;
    if (!isGoing) {
      this.#shown = null;
      for (const [gone, type] of [[uid, "b-m-p-w-GOTO"], [way, "b-m-r"]]) this.send(deletion({ uid: gone, type, at: this.#here, now }));
      return;
    }
    this.#shown = { key, until: now + SHOWN_MS / 2 };
    const goal = goalOf(order.goto) ?? "go here";
    const callsign = goal[0].toUpperCase() + goal.slice(1);
    const at = this.#degrees(order.to);
    this.send(event({ uid, type: "b-m-p-w-GOTO", how: "h-g-i-g-o", at, now, holds: SHOWN_MS, detail: { contact: { $: { callsign } }, remarks: this.#story(now)[1] } }));
    const places = order.way?.map((place) => this.#degrees(place)) ?? [this.#here, at];
    this.send(route({ uid: way, callsign, places, now, holds: SHOWN_MS, isOnFoot: hello.class === "worker" }));
  }

  /** Everything again: somebody new listens. */
  repeat() {
    this.#present_ms = -Infinity;
    if (this.#shown) this.#shown.until = -Infinity;
  }
}
