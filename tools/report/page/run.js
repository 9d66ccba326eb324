import { Altitudes } from "./air.js";
import { BaseMap } from "./base_map.js";
import { readDirectives } from "./directives.js";
import { say } from "./language.js";
import { rowAt } from "./time.js";
import { CANCELLED, DECIDING, FAILED, HELD, IDLE, MOVING, NOT_READY, OFFLINE, OPEN, UAV, UNREPORTED, WORKER, readWords } from "./words.js";

export const KIND_NAMES = [say("UAVs"), say("Workers"), say("Vehicles")];

const STOP = 4; // t_ms, x_m, y_m, range_m
const SAMPLE = 10; // t_ms, wall_ms, start, received, lost, rejected, resent, cpu_s, rss_bytes, state
const ACTION = 9; // kind, uav, worker, vehicle, task, charge, x_m, y_m, weight

function splice(list, from, fresh) {
  list.length = from;
  for (const value of fresh) list.push(value);
}

/** One mission, as the chunks tell it (docs/reference/report-format.md): the first makes it, later ones add to it. */
export class Run {
  constructor() {
    this.name = "";
    this.scenario = null;
    this.words = null; // names of the wire's numbers: agents, statuses, tasks, actions, processes
    this.report = null;
    this.nowMs = 0;
    this.epochMs = 0;
    this.ended = false;
    this.agents = [];
    this.tasks = [];
    this.charging = [];
    this.done = []; // t_ms, tasks
    this.decisions = [];
    this.activities = []; // kind, uav, partner, site, start_ms, end_ms
    this.events = [];
    this.processes = new Map(); // name -> rows of SAMPLE
    this.faults = [];
    this.altitudes = new Altitudes();
    this.roadChanges = []; // [t_ms, closures in force from then on: [order, name, since_ms, roads, rings of a zone]]
    this.directives = []; // what the commander has decided: directives.js
    this.coast = null; // where land is: coast.js
    this.baseMap = null; // tiles below all else: base_map.js
    this.background = null; // shapes in degrees, drawn below the map
    this.reasons = null; // task -> why it was not done; reports only
    this.derived = new Map();
  }

  /** What `make` gives, made once for all that is known now. */
  once(key, make) {
    if (!this.derived.has(key)) this.derived.set(key, make());
    return this.derived.get(key);
  }

  apply(chunk) {
    if (chunk.scenario) this.#begin(chunk);
    this.derived.clear();
    for (const row of chunk.task_rows ?? []) this.#takeTask(row);
    for (const [index, fullRange] of chunk.agent_rows ?? []) Object.assign(this.agents[index], { fullRange, vacant: false });
    this.nowMs = Math.max(this.nowMs, chunk.now_ms);
    this.epochMs = chunk.epoch_ms;
    this.ended = chunk.ended;
    if (chunk.report) {
      this.report = chunk.report;
      const skipped = new Set(chunk.report.skipped_decisions ?? []);
      this.decisions = this.decisions.filter((decision) => !skipped.has(decision.index));
    }
    for (const [i, from, rows] of chunk.stops ?? []) splice(this.agents[i].stops, from * STOP, rows);
    for (const [i, from, rows] of chunk.spans ?? []) splice(this.agents[i].spans, from * 2, rows);
    for (const [i, from, rows] of chunk.tasks ?? []) splice(this.tasks[i].changes, from * 2, rows);
    if (chunk.done) splice(this.done, chunk.done[0] * 2, chunk.done[1]);
    if (chunk.activities) splice(this.activities, chunk.activities[0] * 6, chunk.activities[1]);
    for (const row of chunk.decisions?.[1] ?? []) this.#addDecision(row);
    if (chunk.events) {
      this.rawEvents ??= [];
      splice(this.rawEvents, chunk.events[0], chunk.events[1]);
      this.events = this.rawEvents.map(readEvent).sort((a, b) => a.t - b.t);
    }
    for (const [name, from, rows] of chunk.processes ?? []) {
      if (!this.processes.has(name)) this.processes.set(name, []);
      splice(this.processes.get(name), from * SAMPLE, rows);
    }
    for (const row of chunk.altitudes?.[1] ?? []) this.altitudes.take(row);
    if (chunk.road_changes) this.roadChanges = chunk.road_changes;
    if (chunk.directives) this.directives = readDirectives(chunk.directives);
    if (chunk.coast) this.coast = chunk.coast;
    if (chunk.basemap) this.baseMap = new BaseMap(this, chunk.basemap);
    if (chunk.background) this.background = chunk.background;
    if (chunk.reasons) this.reasons = new Map(chunk.reasons.tasks);
    if (chunk.faults) {
      this.faults = chunk.faults.map(([id, kind, target, at, forMs, probability]) => ({
        id, kind, target, at, forMs, probability }));
    }
  }

  #begin(chunk) {
    this.name = chunk.name;
    const s = chunk.scenario;
    this.scenario = s;
    this.words = chunk.words;
    readWords(chunk.words);
    this.limitMs = s.limit_ms;
    this.intervalMs = s.interval_ms;
    this.tickMs = s.tick_ms;
    [s.uavs, s.workers, s.vehicles].forEach((n, kind) => {
      for (let id = 0; id < n; ++id) {
        const fullRange = kind === UAV ? s.range_full_m[id] : 0;
        this.agents.push({ index: this.agents.length, kind, id, label: `${this.words.agents[kind]}:${id}`,
          fullRange, stops: [], spans: [], vacant: id >= n - (s.vacant?.[kind] ?? 0) });
      }
    });
    for (let i = 0; i < s.tasks.length; i += 3) {
      this.tasks.push({ id: i / 3, x: s.tasks[i], y: s.tasks[i + 1], cost: s.tasks[i + 2], changes: [] });
    }
    /** Whether tasks have reports, due times, expiry and priorities: { reported, due, expires, priority, name }, null: none. */
    this.timed = s.task_times !== undefined;
    (s.task_times ?? []).forEach(([reported, due, expires, priority, name, note], id) => {
      Object.assign(this.tasks[id], { reported, due, expires, priority, name, note, vacant: reported === null });
    });
    for (let i = 0; i < s.charging_points.length; i += 3) {
      this.charging.push({ id: i / 3, x: s.charging_points[i], y: s.charging_points[i + 1],
        capacity: s.charging_points[i + 2] });
    }
  }

  /** A task that an order has added or changed. */
  #takeTask([id, x, y, cost, reported, due, expires, priority, name, note]) {
    Object.assign(this.tasks[id], { x, y, cost, reported, due, expires, priority, name, note, vacant: reported === null });
  }

  #addDecision([index, t, weight, bound, candidates, solveUs, policy, actions]) {
    const place = this.decisions.findIndex((d) => d.index >= index);
    const decision = { index, t, weight, bound, candidates, solveUs, policy, actions };
    if (place < 0) this.decisions.push(decision);
    else if (this.decisions[place].index === index) this.decisions[place] = decision;
    else this.decisions.splice(place, 0, decision);
  }

  agentIndex(kind, id) {
    const s = this.scenario;
    return kind === UAV ? id : kind === WORKER ? s.uavs + id : s.uavs + s.workers + id;
  }

  /** How many tasks the mission has: as its report counts them; before, without vacant places and what was cancelled. */
  get tasksTotal() {
    const report = this.ended ? this.report?.tasks_total : undefined;
    return report ?? this.once("tasks total", () => this.tasks.filter((task) => !task.vacant && task.changes.at(-1) !== CANCELLED).length);
  }

  /** How many tasks the mission knows of at t: those reported by then and not cancelled; at its end, as its report counts them. */
  tasksKnownAt(t) {
    if ((!this.timed && !this.hasOrders) || (this.ended && t >= this.nowMs)) return this.tasksTotal;
    return this.tasks.filter((task) => !task.vacant && ![UNREPORTED, CANCELLED].includes(taskStatusAt(task, t))).length;
  }

  /** Whether any task was ever held or cancelled. */
  get hasOrders() {
    return this.once("has orders", () => this.tasks.some(({ changes }) => changes.some((status, i) => i % 2 === 1 && (status === CANCELLED || status === HELD))));
  }

  /** Agents that the mission has, of each class. */
  get crew() {
    return this.once("crew", () => [0, 1, 2].map((kind) => this.agents.filter((agent) => agent.kind === kind && !agent.vacant).length));
  }

  get tasksDone() {
    return this.done.length ? this.done[this.done.length - 1] : 0;
  }
}

function readEvent([kind, t, uav, worker, vehicle, task, charge, fault, detail]) {
  return { kind, t, uav, worker, vehicle, task, charge, fault, detail };
}

/** Where an agent is at t: x, y, range, where its leg leads and the way that it goes; null before its first state. */
export function placeAt(agent, t) {
  const { stops } = agent;
  if (stops.length === 0) return null;
  const i = Math.max(0, rowAt(stops, STOP, t)) * STOP;
  const x = stops[i + 1];
  const y = stops[i + 2];
  const range = stops[i + 3];
  if (i + STOP >= stops.length || stops[i] >= t) {
    // The newest place of a live mission is its last: what it did before tells the way.
    const atEnd = i + STOP >= stops.length && i > 0;
    const dx = atEnd ? x - stops[i - STOP + 1] : 0;
    const dy = atEnd ? y - stops[i - STOP + 2] : 0;
    return { x, y, range, toX: x, toY: y, dx, dy };
  }
  const share = (t - stops[i]) / (stops[i + STOP] - stops[i]);
  const toX = stops[i + 5];
  const toY = stops[i + 6];
  return { x: x + share * (toX - x), y: y + share * (toY - y), range: range + share * (stops[i + 7] - range), toX, toY, dx: toX - x, dy: toY - y };
}

/** Metres a second: { vx, vy }, of one that moves. */
export function velocityAt(agent, t) {
  const { stops } = agent;
  let i = Math.max(0, rowAt(stops, STOP, t)) * STOP;
  if (i + STOP >= stops.length) i -= STOP; // the newest place: what it did before tells the way
  const seconds = i < 0 ? 0 : (stops[i + STOP] - stops[i]) / 1000;
  if (!(seconds > 0) || statusAt(agent, t) !== MOVING) return { vx: 0, vy: 0 };
  return { vx: (stops[i + STOP + 1] - stops[i + 1]) / seconds, vy: (stops[i + STOP + 2] - stops[i + 2]) / seconds };
}

export function statusAt(agent, t) {
  const i = rowAt(agent.spans, 2, t);
  return i < 0 ? OFFLINE : agent.spans[2 * i + 1];
}

export function taskStatusAt(task, t) {
  const i = rowAt(task.changes, 2, t);
  return i < 0 ? OPEN : task.changes[2 * i + 1];
}

export function doneAt(run, t) {
  const i = rowAt(run.done, 2, t);
  return i < 0 ? 0 : run.done[2 * i + 1];
}

/** The decision in force at t; null before the first. */
export function decisionAt(run, t) {
  let found = null;
  for (const decision of run.decisions) {
    if (decision.t > t) break;
    found = decision;
  }
  return found;
}

const ACTION_NAMES = { Ui: say("stays"), Wj: say("stays"), Vk: say("stays"), UiTx: say("goes ahead"), WjTx: say("goes ahead"), UiCy: say("goes to charge"),
  VkCy: say("goes to charge"), UiTxWj: say("sense"), UiCyVk: say("charge") };

/** A decision's actions as objects. */
export function actionsOf(run, decision) {
  const list = [];
  for (let i = 0; i < decision.actions.length; i += ACTION) {
    const [kind, uav, worker, vehicle, task, charge, x, y, weight] = decision.actions.slice(i, i + ACTION);
    const symbol = run.words.actions[kind];
    list.push({ kind, symbol, name: ACTION_NAMES[symbol] ?? say("goes"), uav, worker, vehicle, task, charge, x, y, weight });
  }
  return list;
}

/** Whether two decisions command the same. */
export function sameActions(a, b) {
  return a.actions.length === b.actions.length && a.actions.every((value, i) => value === b.actions[i]);
}

/** Sums over all processes and their starts, at each time that one of them said something. */
export function busOverTime(run) {
  return run.once("bus", () => sumBus(run));
}

function sumBus(run) {
  const samples = [];
  for (const [name, rows] of run.processes) {
    for (let i = 0; i < rows.length; i += SAMPLE) {
      samples.push({ name, t: rows[i], start: rows[i + 2], lost: rows[i + 4], rejected: rows[i + 5], resent: rows[i + 6] });
    }
  }
  samples.sort((a, b) => a.t - b.t);
  const latest = new Map();
  const total = { lost: 0, rejected: 0, resent: 0 };
  const out = { t: [], lost: [], rejected: [], resent: [] };
  for (const sample of samples) {
    const key = `${sample.name}/${sample.start}`;
    const before = latest.get(key) ?? { lost: 0, rejected: 0, resent: 0 };
    for (const what of ["lost", "rejected", "resent"]) total[what] += sample[what] - before[what];
    latest.set(key, sample);
    if (out.t[out.t.length - 1] !== sample.t) out.t.push(sample.t);
    for (const what of ["lost", "rejected", "resent"]) out[what][out.t.length - 1] = total[what];
  }
  return out;
}

/** For how long a process has said that it is deciding; 0: it does not. */
export function decidingMs(rows) {
  const state = (i) => rows[i + SAMPLE - 1];
  const last = rows.length - SAMPLE;
  let first = last;
  while (first >= 0 && state(first) === DECIDING) first -= SAMPLE;
  return first === last ? 0 : rows[last + 1] - rows[first + SAMPLE + 1];
}

/**
 * What went wrong when: bands { from, to, label, kind }, those of an instant with to = from. kind:
 * "fault" or "process" touch the whole mission, "agent" one agent.
 */
export function faultBands(run) {
  return run.once("faults", () => findBands(run));
}

function findBands(run) {
  const bands = [];
  const lost = new Map(); // by process, its latest
  const faults = new Map();
  const end = Math.max(run.nowMs, 1);
  for (const event of run.events) {
    const process = event.detail.split(/[ ,]/)[0];
    if (event.kind === "fault_applied") {
      if (faults.has(event.fault)) continue; // each process that it hits says so
      const band = { from: event.t, to: end, label: faultText(run, event.fault), kind: "fault", open: !run.ended };
      faults.set(event.fault, band);
      bands.push(band);
    } else if (event.kind === "fault_ended") {
      const band = faults.get(event.fault);
      if (band) Object.assign(band, { to: band.ended ? Math.max(band.to, event.t) : event.t, ended: true, open: false });
    } else if (event.kind === "process_lost") {
      // The launcher and the world both say so, each when it notices.
      if (lost.get(process)?.open) continue;
      const band = { from: event.t, to: end, label: say("lost: {what}", { what: event.detail }), lost: event.detail, kind: "process", open: true };
      lost.set(process, band);
      bands.push(band);
    } else if (event.kind === "process_back") {
      const band = lost.get(process);
      if (band) Object.assign(band, { to: event.t, open: false });
    } else if (event.kind === "agent_failed") {
      bands.push({ from: event.t, to: event.t, label: say("{agent} failed", { agent: who(event) }), kind: "agent" });
    }
  }
  for (const [id, band] of faults) {
    const kind = run.faults.find((fault) => fault.id === id)?.kind;
    if (kind?.startsWith("agent_")) band.kind = "agent"; // of one agent alone
    // How long a killed process is away is a band of its own.
    if (kind === "process_killed") Object.assign(band, { to: band.from, open: false });
  }
  return bands;
}

function faultText(run, id) {
  const fault = run.faults.find((other) => other.id === id);
  return fault ? `${id}: ${say(fault.kind.replaceAll("_", " "))} ${fault.target}` : say("fault {id}", { id });
}

/** "uav:3, worker:5" of an event or action. */
export function who(item) {
  const names = [];
  if (item.uav >= 0) names.push(`uav:${item.uav}`);
  if (item.worker >= 0) names.push(`worker:${item.worker}`);
  if (item.vehicle >= 0) names.push(`vehicle:${item.vehicle}`);
  return names.join(", ");
}

/** Milliseconds an agent was moving, sensing or charging until `t`. */
export function busyMs(agent, t) {
  let sum = 0;
  const { spans } = agent;
  for (let i = 0; i < spans.length; i += 2) {
    const status = spans[i + 1];
    if ([OFFLINE, IDLE, FAILED, NOT_READY].includes(status)) continue;
    const until = Math.min(t, i + 2 < spans.length ? spans[i + 2] : t);
    sum += Math.max(0, until - spans[i]);
  }
  return sum;
}
