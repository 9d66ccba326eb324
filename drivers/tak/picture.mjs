// The mission as Cursor on Target: what is new or must be said again. Times of events are of the wall, as their readers' are.
import { attentionAt } from "../../tools/report/page/attention.js";
import { directivesOf, directiveWords } from "../../tools/report/page/directives.js";
import { closuresAt } from "../../tools/report/page/layers/roads.js";
import { degreesOf } from "../../tools/report/page/place.js";
import { actionsOf, placeAt, statusAt, taskStatusAt } from "../../tools/report/page/run.js";
import { PRIORITIES, arrivalAt, taskNow } from "../../tools/report/page/story.js";
import { timeText } from "../../tools/report/page/time.js";
import { BEING_SENSED, CANCELLED, CHARGING, DONE, EXPIRED, HELD, LAST_STAY, MOVING, OFFLINE, OPEN, RESERVED, SENSING, UAV, UNREPORTED, WAITING, WORKER } from "../../tools/report/page/words.js";
import { deletion, event, route } from "./cot.mjs";

const AGENT_TYPES = ["a-f-A-M-H-Q", "a-f-G-U-C", "a-f-G-E-V-C"]; // drone, ground unit, vehicle
const AGENT_HOLDS_MS = 60_000;
const PLACE_HOLDS_MS = 10 * 60_000;
const MOVED_M = 1; // less is no move
const TROUBLES = ["failed", "stranded", "range", "process"];
const MOST_SHAPE_POINTS = 500;
const MOST_CLOSED = 200; // roads of one closure

// Signed ARGB, as ATAK has colours.
const argb = (rgb) => (0xff000000 | rgb) | 0;
const [RED, ORANGE, YELLOW, WHITE, CYAN, BLUE, GREEN, GREY] = [0xff0000, 0xff8800, 0xffff00, 0xffffff, 0x00ffff, 0x0066ff, 0x00cc44, 0x888888].map(argb);
const OPEN_COLOURS = [WHITE, YELLOW, ORANGE, RED]; // by priority

function taskColour(task, status) {
  if (status === DONE) return GREEN;
  if (status === BEING_SENSED) return BLUE;
  if (status === RESERVED) return CYAN;
  if ([EXPIRED, CANCELLED, HELD].includes(status)) return GREY;
  return OPEN_COLOURS[task.priority ?? 1];
}

export const taskName = (task) => `Task ${task.id}${task.name ? ` ${task.name}` : ""}`;

/** Where the mission's members are, what its tasks are; each event when it is new, changed, or about to go stale. */
export class Picture {
  #said = new Map(); // uid -> {key, until}
  #alerts = new Map(); // uid -> last event's object
  #commands = new Map(); // agent -> its newest command
  #learned = 0; // decisions whose commands are known
  #told = -1; // newest decision that the room heard of
  #ways = new Set(); // agents whose way is shown

  /** `ways`: the ways of those who move, too. */
  constructor({ ways = false } = {}) {
    this.run = null;
    this.ways = ways;
  }

  /** Another mission, or the same from its beginning: everything is said anew. Names stay those of the run. */
  begin(run) {
    this.run = run;
    this.prefix = `muster.${run.name}`;
    this.self = { uid: this.prefix, callsign: "MUSTER" };
    this.#said.clear();
    this.#commands.clear();
    this.#ways.clear();
    this.#learned = 0;
  }

  /** Forget what was said: somebody new listens. */
  repeat() {
    this.#said.clear();
  }

  get hasPlaces() {
    return Boolean(this.run?.scenario.origin);
  }

  at(place) {
    const [latitude, longitude] = degreesOf(this.run, place);
    return { latitude, longitude };
  }

  get middle() {
    const { width_m: width, height_m: height } = this.run.scenario;
    return this.at({ x: width / 2, y: height / 2 });
  }

  /** The events that are due at wall time `now`, the most important first. */
  due(now) {
    const { run } = this;
    if (!run || !this.hasPlaces) return [];
    const t = run.nowMs;
    this.#learn();
    const events = [this.#presence(now), ...this.#alertsAt(t, now)];
    for (const agent of run.agents) {
      const made = agent.vacant ? null : this.#agent(agent, t, now);
      if (made) events.push(made);
    }
    for (const task of run.tasks) {
      const made = task.vacant ? null : this.#task(task, t, now);
      if (made) events.push(made);
    }
    for (const point of run.charging) events.push(this.#charging(point, now));
    events.push(...this.#zones(t, now), ...this.#closedRoads(t, now));
    if (this.ways) events.push(...run.agents.map((agent) => (agent.vacant ? null : this.#way(agent, t, now))));
    return events.filter(Boolean);
  }

  /** The event, if it says something new or the last one is past half of its time. */
  #make(options, key) {
    const said = this.#said.get(options.uid);
    if (said && said.key === key && options.now < said.until) return null;
    this.#said.set(options.uid, { key, until: options.now + options.holds / 2 });
    return event(options);
  }

  #presence(now) {
    return this.#make({ uid: this.self.uid, type: "a-f-G-I", at: this.middle, now, holds: AGENT_HOLDS_MS, detail: {
      contact: { $: { callsign: this.self.callsign, endpoint: "*:-1:stcp" } }, __group: { $: { name: "White", role: "HQ" } },
      takv: { $: { platform: "Muster", device: "", os: "", version: "1" } }, remarks: `Mission ${this.run.name}` } }, "");
  }

  uidOf(agent) {
    return `${this.prefix}.${agent.label.replace(":", ".")}`;
  }

  #agent(agent, t, now) {
    const { run } = this;
    const status = statusAt(agent, t);
    const place = placeAt(agent, t);
    if (status === OFFLINE || !place) return null;
    const before = placeAt(agent, t - run.tickMs) ?? place;
    const [dx, dy] = [place.x - before.x, place.y - before.y];
    const moves = Math.hypot(dx, dy) >= MOVED_M;
    const doing = this.#doing(agent, status, t);
    const directed = directivesOf(run, { type: "agent", index: agent.index }, t).map(directiveWords);
    const up = agent.kind === UAV ? run.altitudes.at(agent.id, t) : null;
    const remarks = [doing, ...(up > 0 ? [`${Math.round(up)} m above the ground`] : []), ...directed].join(", ");
    const battery = agent.kind === UAV ? Math.round((100 * place.range) / agent.fullRange) : null;
    const detail = {
      contact: { $: { callsign: agent.label } }, uid: { $: { Droid: agent.label } },
      track: { $: { course: moves ? ((Math.atan2(dx, dy) * 180 / Math.PI + 360) % 360).toFixed(1) : "0.0", speed: (Math.hypot(dx, dy) / (run.tickMs / 1000)).toFixed(2) } },
      ...(agent.kind === UAV ? {} : { __group: { $: { name: agent.kind === WORKER ? "Cyan" : "Orange", role: "Team Member" } } }),
      ...(battery === null ? {} : { status: { $: { battery: String(battery) } } }),
      remarks,
    };
    const key = `${Math.round(place.x)} ${Math.round(place.y)} ${battery} ${remarks}`;
    return this.#make({ uid: this.uidOf(agent), type: AGENT_TYPES[agent.kind], at: this.at(place), now, holds: AGENT_HOLDS_MS, detail }, key);
  }

  /** "moving to task 12, there by 14:32" */
  #doing(agent, status, t) {
    const { run } = this;
    const words = run.words.statuses[status];
    const command = [MOVING, WAITING, SENSING, CHARGING].includes(status) ? this.#commands.get(agent.index) : null;
    if (!command || (command.task < 0 && command.charge < 0)) return words;
    const isTask = command.task >= 0;
    const place = isTask ? run.tasks[command.task] : run.charging[command.charge];
    const arrival = status === MOVING ? arrivalAt(run, agent, t, place.x, place.y) : null;
    const where = `${words} ${status === MOVING ? "to" : "at"} ${isTask ? "task" : "charging point"} ${place.id}`;
    return arrival ? `${where}, there by ${timeText(run, arrival.t)}` : where;
  }

  /** The way that is ahead of one who moves; its end when nothing is. */
  #way(agent, t, now) {
    const { run } = this;
    const uid = `${this.prefix}.way.${agent.label.replace(":", ".")}`;
    const place = placeAt(agent, t);
    const command = this.#commands.get(agent.index);
    const goal = command && (command.task >= 0 ? run.tasks[command.task] : run.charging[command.charge]);
    if (statusAt(agent, t) !== MOVING || !goal || !place) {
      if (!this.#ways.delete(agent.index)) return null;
      this.#said.delete(uid);
      return deletion({ uid, type: "b-m-r", at: this.middle, now });
    }
    const places = [place];
    for (let i = 0; i < agent.stops.length; i += 4) {
      const [when, x, y] = agent.stops.slice(i, i + 3);
      if (when > t && Math.hypot(goal.x - x, goal.y - y) > MOVED_M) places.push({ x, y });
      else if (when > t) break;
    }
    places.push(goal);
    const callsign = `${agent.label} to ${command.task >= 0 ? "task" : "charging point"} ${goal.id}`;
    const key = `${callsign} ${places.slice(1).map(({ x, y }) => `${x} ${y}`).join()}`;
    const said = this.#said.get(uid);
    if (said?.key === key && now < said.until) return null;
    this.#said.set(uid, { key, until: now + AGENT_HOLDS_MS / 2 });
    this.#ways.add(agent.index);
    return route({ uid, callsign, places: places.map((one) => this.at(one)), now, holds: AGENT_HOLDS_MS, isOnFoot: agent.kind === WORKER });
  }

  /** Takes in the decisions that came since. */
  #learn() {
    const { decisions } = this.run;
    for (; this.#learned < decisions.length; ++this.#learned) {
      for (const action of actionsOf(this.run, decisions[this.#learned])) {
        if (action.kind <= LAST_STAY) continue;
        [action.uav, action.worker, action.vehicle].forEach((id, kind) => id >= 0 && this.#commands.set(this.run.agentIndex(kind, id), action));
      }
    }
  }

  #task(task, t, now) {
    const { run } = this;
    const status = taskStatusAt(task, t);
    if (status === UNREPORTED) return null;
    const { activity } = taskNow(run, task, t);
    const pair = activity && status !== OPEN ? `uav:${activity.uav} and worker:${activity.partner}` : "";
    const directed = directivesOf(run, { type: "task", id: task.id }, t).map(directiveWords);
    const remarks = [run.words.tasks[status], pair, run.timed ? PRIORITIES[task.priority] : "", run.timed && task.due !== null ? `due ${timeText(run, task.due)}` : "", ...directed].filter(Boolean).join(", ");
    return this.#spot(`${this.prefix}.task.${task.id}`, taskName(task), task, taskColour(task, status), remarks, now);
  }

  #charging(point, now) {
    return this.#spot(`${this.prefix}.charge.${point.id}`, `Charging point ${point.id}`, point, GREEN, point.capacity === null ? "any number of UAVs" : `${point.capacity} at a time`, now);
  }

  #spot(uid, callsign, place, colour, remarks, now) {
    return this.#make({ uid, type: "b-m-p-s-m", at: this.at(place), now, holds: PLACE_HOLDS_MS, detail: {
      contact: { $: { callsign } }, color: { $: { argb: String(colour) } }, usericon: { $: { iconsetpath: `COT_MAPPING_SPOTMAP/b-m-p-s-m/${colour}` } },
      status: { $: { readiness: "true" } }, remarks } }, `${colour} ${callsign} ${remarks} ${place.x} ${place.y}`);
  }

  /** Zones in force: a shape each, its outer ring. */
  #zones(t, now) {
    return closuresAt(this.run, t).filter(([, , , , rings]) => rings?.length).map(([order, name, , , rings]) => {
      const corners = [];
      for (let i = 0; i + 1 < rings[0].length && corners.length < MOST_SHAPE_POINTS; i += 2) corners.push(this.at({ x: rings[0][i], y: rings[0][i + 1] }));
      const links = [...corners, corners[0]].map(({ latitude, longitude }) => ({ $: { point: `${latitude.toFixed(7)},${longitude.toFixed(7)}` } }));
      return this.#make({ uid: `${this.prefix}.zone.${order}`, type: "u-d-f", how: "h-e", at: corners[0], now, holds: PLACE_HOLDS_MS, detail: {
        link: links, contact: { $: { callsign: name || `Zone ${order}` } }, strokeColor: { $: { value: String(RED) } }, strokeWeight: { $: { value: "3.0" } },
        fillColor: { $: { value: String(0x33ff0000 | 0) } }, labels_on: { $: { value: "true" } }, remarks: "UAVs keep out" } }, order);
    });
  }

  /** Roads that are closed: a line each. */
  #closedRoads(t, now) {
    const lines = this.run.scenario.roads?.lines;
    if (!lines) return [];
    return closuresAt(this.run, t).flatMap(([order, name, , roads]) => roads.slice(0, MOST_CLOSED).map((road) => {
      const corners = [];
      const line = lines[road];
      for (let i = 1; i + 1 < line.length && corners.length < MOST_SHAPE_POINTS; i += 2) corners.push(this.at({ x: line[i], y: line[i + 1] }));
      const links = corners.map(({ latitude, longitude }) => ({ $: { point: `${latitude.toFixed(7)},${longitude.toFixed(7)}` } }));
      return this.#make({ uid: `${this.prefix}.closed.${order}.${road}`, type: "u-d-f", how: "h-e", at: corners[0], now, holds: PLACE_HOLDS_MS, detail: {
        link: links, contact: { $: { callsign: name || "Closed road" } }, strokeColor: { $: { value: String(RED) } }, strokeWeight: { $: { value: "4.0" } },
        remarks: "closed road" } }, order);
    }));
  }

  /** What has begun to need attention, and what no longer does. */
  #alertsAt(t, now) {
    const { run } = this;
    const present = new Map();
    for (const concern of attentionAt(run, t)) {
      if (!TROUBLES.includes(concern.kind)) continue;
      const agent = concern.item?.type === "agent" ? run.agents[concern.item.index] : null;
      const subject = agent ? agent.label : concern.text;
      present.set(`${this.prefix}.alert.${concern.kind}.${subject}`, { subject, agent, text: `${subject}: ${concern.kind === "process" ? "process lost" : concern.kind} ${concern.note}` });
    }
    const events = [];
    const say = (uid, { subject, agent, text }, over) => {
      const place = agent ? placeAt(agent, t) : null;
      events.push(event({ uid, type: over ? "b-a-o-can" : "b-a-o-pan", at: place ? this.at(place) : this.middle, now, holds: AGENT_HOLDS_MS, detail: {
        contact: { $: { callsign: `${subject}-Alert` } }, link: { $: { uid: agent ? this.uidOf(agent) : this.self.uid, type: agent ? AGENT_TYPES[agent.kind] : "a-f-G-I", relation: "p-p" } },
        emergency: over ? { $: { cancel: "true" }, "#text": subject } : { $: { type: "Ring The Bell" }, "#text": subject }, remarks: text } }));
    };
    for (const [uid, alert] of present) if (!this.#alerts.has(uid)) say(uid, alert, false);
    for (const [uid, alert] of this.#alerts) if (!present.has(uid)) say(uid, alert, true);
    this.#alerts = present;
    return events;
  }

  /** What the newest decision sends, as lines for the room; empty when the room has heard them. */
  news() {
    const { run } = this;
    const decision = run?.decisions.at(-1);
    if (!decision || decision.index <= this.#told) return [];
    const isFirst = this.#told < 0;
    this.#told = decision.index;
    if (isFirst && decision.t < run.nowMs - run.tickMs) return []; // it was there before us
    return actionsOf(run, decision).filter(({ symbol }) => symbol === "UiTxWj" || symbol === "UiCyVk").map(({ symbol, uav, worker, vehicle, task, charge }) => (symbol === "UiTxWj"
      ? `${taskName(run.tasks[task])}: uav:${uav} and worker:${worker}` : `Charging point ${charge}: uav:${uav} and vehicle:${vehicle}`));
  }
}
