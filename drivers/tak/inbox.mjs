// What TAK users say: reports that become tasks, and commands in chat. Only those whom the list allows are heard.
import { readStory } from "../../tools/report/page/reasons.js";
import { planeOf } from "../../tools/report/page/place.js";
import { taskStatusAt } from "../../tools/report/page/run.js";
import { NoEvent, readEvent } from "./cot.mjs";
import { taskName } from "./picture.mjs";

const MOST_REMEMBERED = 20_000;
const MOST_WAITING = 1000;
const MOVED_DEGREES = 2e-4; // some 20 m: a marker that moves less is where it was

const HELP = "status 12 | why 12 | pin UAV WORKER TASK | unpin TASK | charge UAV | cancel TASK";

/** Which events report something to be sensed: [type, priority]. */
const REPORTS = [[/^b-r-f-h-c/, 3], [/^b-a-o-(?!can)/, 3], [/^b-m-p-[sw]/, 1], [/^a-u-G/, 1]];
const priorityOf = (type) => REPORTS.find(([kind]) => kind.test(type))?.[1];

/** Of the latest keys, the values; older ones are forgotten. */
class Recent extends Map {
  set(key, value) {
    super.delete(key);
    super.set(key, value);
    if (this.size > MOST_REMEMBERED) super.delete(this.keys().next().value);
    return this;
  }
}

export class Inbox {
  #seen = new Recent(); // uid and time of an event
  #callsigns = new Recent(); // uid -> callsign
  #waiting = 0;
  #tasks = new Recent(); // uid of a report -> {task, order, at}

  /** `mission`: Mission; `picture`: Picture; `say(to, text)`: a chat message; `note(words)`: for the log. */
  constructor({ allow, mission, picture, say, note }) {
    Object.assign(this, { allow, mission, picture, say, note });
    this.counts = { heard: 0, taken: 0, refused: 0, ignored: 0, unreadable: 0 };
  }

  /** Takes an event as it came; resolves when what follows from it is done. */
  async take(xml, now = Date.now()) {
    ++this.counts.heard;
    let event;
    try {
      event = readEvent(xml, now);
    } catch (error) {
      if (!(error instanceof NoEvent)) throw error;
      ++this.counts.unreadable;
      return this.note(`an event is dropped: ${error.message}`, "unreadable");
    }
    const key = `${event.uid} ${event.time} ${event.chat ? event.remarks : ""}`;
    const isOwn = event.uid.startsWith("muster.") || event.uid.startsWith("GeoChat.muster.");
    if (isOwn || this.#seen.has(key)) return void ++this.counts.ignored;
    this.#seen.set(key, true);
    if (/^a-f-/.test(event.type) && event.callsign) this.#callsigns.set(event.uid, event.callsign);
    const sender = this.#senderOf(event);
    const isReport = priorityOf(event.type) !== undefined || event.type === "t-x-d-d" || event.type === "b-a-o-can";
    if (!isReport && !event.chat) return void ++this.counts.ignored;
    if (!this.allow.has(sender)) {
      ++this.counts.refused;
      return this.note(`${event.chat ? "a message" : "a report"} of ${sender || "somebody without a callsign"} is not heard: --allow does not name them`, `refused ${sender}`);
    }
    // What is said before the mission is known waits for it.
    if (this.#waiting >= MOST_WAITING) return void ++this.counts.refused;
    ++this.#waiting;
    await this.mission.known;
    --this.#waiting;
    return event.chat ? this.#command(event, sender) : this.#report(event, sender);
  }

  #senderOf(event) {
    if (event.chat) return event.chat.sender;
    const link = event.links.find(({ relation }) => relation === "p-p");
    return event.creator || link?.parent_callsign || this.#callsigns.get(link?.uid) || event.callsign;
  }

  async #report(event, sender) {
    const cancelled = event.type === "t-x-d-d" ? event.links.map(({ uid }) => uid).find((uid) => this.#tasks.has(uid)) : event.cancels || event.type === "b-a-o-can" ? event.uid : null;
    const known = this.#tasks.get(cancelled ?? event.uid);
    if (cancelled !== null && cancelled !== undefined) {
      if (!known) return void ++this.counts.ignored;
      this.#tasks.delete(cancelled);
      return this.#answered(await this.mission.order({ id: `${known.order}-cancel`, issuer: sender, order: "task_cancel", task: known.task }), `cancels task ${known.task}`, sender, event);
    }
    if (event.type === "t-x-d-d") return void ++this.counts.ignored;
    const { latitude, longitude } = event.at;
    const isNear = (a, b) => Math.abs(a - b) < MOVED_DEGREES;
    if (known && isNear(latitude, known.at.latitude) && isNear(longitude, known.at.longitude)) return void ++this.counts.ignored;
    // The place is part of the id: after a restart of ours the same report is the same order.
    const order = `tak-${event.uid}@${latitude.toFixed(4)},${longitude.toFixed(4)}`.slice(0, 190);
    const { x, y } = planeOf(this.mission.run, latitude, longitude);
    const name = (event.callsign || event.remarks).slice(0, 80);
    const taken = await this.mission.order({ id: order, issuer: sender, order: "task_add", task: {
      x_km: Math.round(x) / 1000, y_km: Math.round(y) / 1000, priority: priorityOf(event.type), external_id: event.uid.slice(0, 190), source: "TAK", ...(name ? { name } : {}) } });
    this.#answered(taken, `reports ${name || event.type}`, sender, event);
    if (taken.refused !== undefined) return;
    this.#tasks.set(event.uid, { task: taken.task, order, at: event.at });
    // Where it was before, nobody needs to go any more.
    if (known) await this.mission.order({ id: `${known.order}-moved`, issuer: sender, order: "task_cancel", task: known.task });
  }

  #answered(taken, what, sender, event) {
    const good = taken.refused === undefined;
    ++this.counts[good ? "taken" : "refused"];
    const words = good ? `taken${taken.task === undefined ? "" : ` as task ${taken.task}`}` : `refused: ${taken.refused}`;
    this.note(`${sender} ${what}: ${words}`);
    const uid = event.links.find(({ relation }) => relation === "p-p")?.uid ?? event.chat?.uid;
    if (uid) this.say({ callsign: sender, uid }, `${what}: ${words}`);
  }

  async #command(event, sender) {
    const [verb, ...rest] = event.remarks.trim().toLowerCase().split(/\s+/);
    const numbers = rest.map((word) => Number(word.replace(/^(uav|worker|vehicle|task|u|w|v|t):?/, "")));
    const to = { callsign: sender, uid: event.chat.uid };
    const good = numbers.every((n) => Number.isInteger(n) && n >= 0);
    const [a, b, c] = numbers;
    const orders = {
      pin: [3, () => ({ order: "pin", agents: [`uav:${a}`, `worker:${b}`], task: c })],
      unpin: [1, () => ({ order: "unpin", task: a })],
      charge: [1, () => ({ order: "charge_now", agents: [`uav:${a}`] })],
      cancel: [1, () => ({ order: "task_cancel", task: a })],
    };
    if (["status", "why"].includes(verb) && good && numbers.length === 1 && this.mission.run.tasks[a] && !this.mission.run.tasks[a].vacant) {
      ++this.counts.taken;
      return this.say(to, verb === "status" ? this.#status(a) : await this.#why(a));
    }
    const [n, make] = orders[verb] ?? [];
    if (n === numbers.length && good) return this.#answered(await this.mission.order({ id: `tak-${event.uid}`.slice(0, 190), issuer: sender, ...make() }), event.remarks.trim(), sender, event);
    // A room is for people, too: what is no command there is none of ours.
    const isOurs = event.chat.room === this.picture.self.callsign;
    if (!isOurs) return void ++this.counts.ignored;
    ++this.counts.refused;
    return this.say(to, `I know: ${HELP}`);
  }

  #status(id) {
    const { run } = this.mission;
    const task = run.tasks[id];
    return `${taskName(task)}: ${run.words.tasks[taskStatusAt(task, run.nowMs)]}`;
  }

  async #why(id) {
    const text = await this.mission.why(`task:${id}`);
    if (!text) return `${this.#status(id)}; the mission does not say why`;
    const last = readStory(text).decisions.at(-1);
    return last ? `Decision ${last.index}: ${last.lines.slice(0, 3).join("; ")}` : this.#status(id);
  }
}
