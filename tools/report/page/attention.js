import { approachText, comingClose } from "./air.js";
import { oncePerFrame } from "./canvas.js";
import { byId, element, isolated, number } from "./dom.js";
import { fill, say, sayParts } from "./language.js";
import { messagesAt } from "./messages.js";
import { taskName } from "./names.js";
import { reasonAt, shortReason, storyOf } from "./reasons.js";
import { decisionAt, doneAt, faultBands, placeAt, statusAt, taskStatusAt } from "./run.js";
import { PRIORITIES, spanAt, taskNow, undoneTasks } from "./story.js";
import { clockText } from "./time.js";
import { CANCELLED, CHARGING, DONE, EXPIRED, FAILED, HELD, NOT_READY, OFFLINE, OPEN, RESERVED, UAV, UNREPORTED, WAITING } from "./words.js";

const SHOWN = 4; // of each kind
const LONG_WAIT_MS = 5 * 60000;
const LOW_RANGE = 0.2;
const SILENT_MS = 5000;

/** Kinds of what needs attention, the most harmful first. `more` is the filter of the task table that shows all of them. */
export const KINDS = [
  { id: "help", title: say("Calls for help"), mark: "!" },
  { id: "process", title: say("Processes lost"), mark: "!" },
  { id: "log", title: say("Log behind"), mark: "!" },
  { id: "differ", title: say("Schedulers disagree"), mark: "!" },
  { id: "fault", title: say("Faults in force"), mark: "!" },
  { id: "failed", title: say("Agents failed"), mark: "×" },
  { id: "near", title: say("UAVs come too close"), mark: "!" },
  { id: "stranded", title: say("Cannot reach a charging point"), mark: "×" },
  { id: "undone", title: say("Not done"), mark: "◇", more: "never" },
  { id: "risk", title: say("At risk"), mark: "◇", more: "open" },
  { id: "says", title: say("Messages"), mark: "…" },
  { id: "ready", title: say("Not ready"), mark: "…" },
  { id: "wait", title: say("Waiting for a partner"), mark: "…" },
  { id: "range", title: say("Low range"), mark: "▾" },
];

const minutes = (ms) => `${number(ms / 60000)} min`;

/** Of tasks that need attention those of higher priority come first. */
const weightOf = (task) => 10 * (task.priority ?? 0);

/** "task 17, emergency: School" */
export const taskText = ({ id, name, priority }) => `${taskName(id)}${priority >= 2 ? `, ${PRIORITIES[priority]}` : ""}${name ? `: ${isolated(name)}` : ""}`;

/**
 * Why a task will be late or lost, from its due time and expiry: { harm, note }; null when nothing speaks for it. Soon is
 * within two intervals.
 */
export function timeRisk(run, task, now, t) {
  if (now.status !== OPEN && now.status !== RESERVED && now.status !== HELD) return null;
  const { due = null, expires = null } = task;
  const soon = 2 * run.intervalMs;
  const start = now.status === RESERVED ? now.activity?.start ?? null : null;
  if (start !== null) {
    const begins = clockText(start);
    if (expires !== null && start >= expires) return { harm: 7, note: say("starts at {start}, expires at {end}", { start: begins, end: clockText(expires) }) };
    return due !== null && start > due ? { harm: 3, note: say("starts at {start}, {late} too late", { start: begins, late: minutes(start - due) }) } : null;
  }
  if (now.status === RESERVED) return null; // a live page may not have heard when it starts
  const nobody = now.status === HELD ? say("held by an order") : say("nobody is on the way");
  const nearness = (left) => 1 - left / soon;
  if (expires !== null && expires - t <= soon) return { harm: 6 + nearness(Math.max(0, expires - t)), note: say("expires in {left}, {nobody}", { left: minutes(Math.max(0, expires - t)), nobody }) };
  if (due === null || due - t > soon) return null;
  return due <= t ? { harm: 5, note: say("was due {late} ago, {nobody}", { late: minutes(t - due), nobody }) } : { harm: 4 + nearness(due - t), note: say("due in {left}, {nobody}", { left: minutes(due - t), nobody }) };
}

/** Tasks that are or will be late or lost. Reports: one that is never done is known before the end. */
function tasksAtRisk(run, t) {
  const found = [];
  const last = run.ended && t >= run.nowMs;
  const behind = !run.ended && t >= 3 * run.intervalMs && late(run, t);
  for (const task of run.timed || behind ? run.tasks : run.ended ? undoneTasks(run) : []) {
    if ([DONE, UNREPORTED, CANCELLED].includes(taskStatusAt(task, t))) continue;
    const now = taskNow(run, task, t);
    if (now.status === EXPIRED) {
      found.push({ kind: "undone", item: { type: "task", id: task.id }, harm: 1 + weightOf(task), text: taskText(task), note: say("expired: sensing had not begun") });
      continue;
    }
    if (now.doneAt !== null && now.doneAt <= t) continue;
    const never = run.ended && now.doneAt === null;
    const risk = last ? null : timeRisk(run, task, now, t);
    if (risk) {
      found.push({ kind: "risk", item: { type: "task", id: task.id }, harm: risk.harm + weightOf(task), text: taskText(task), note: risk.note });
    } else if (never) {
      found.push({ kind: last ? "undone" : "risk", item: { type: "task", id: task.id }, harm: (now.status === OPEN ? 2 : 1) + weightOf(task),
        text: taskText(task), note: (now.status === OPEN && why(run, task, t)) || say(last ? "never done" : now.status === OPEN ? "nobody is sent: it will not be done" : "somebody is sent, in vain") });
    } else if (behind && now.status === OPEN) {
      found.push({ kind: "risk", item: { type: "task", id: task.id }, harm: weightOf(task), text: taskText(task), note: say("nobody is sent") });
    }
  }
  return found;
}

/** Why the decision in force sends nobody, in a few words; null: the page does not say. */
function why(run, task, t) {
  const story = storyOf(run, task.id);
  const reason = story && reasonAt(story, decisionAt(run, t));
  return reason ? shortReason(reason) : null;
}

/** Whether the forecast leaves tasks undone. */
const late = (run, t) => forecastAt(run, t).done < run.tasksKnownAt(t);

/**
 * What is wrong with an agent: { kind, harm, note }; null: nothing. `since` and `nearest` (metres to the nearest charging
 * point; null: there is none) are asked for where they matter, as is what its driver waits for (`waits`). The terminal has the
 * same rule (TroubleOf in tools/top/attention.h).
 */
export function troubleOf({ kind, status, range, fullRange }, t, since, nearest, waits) {
  if (status === FAILED) return { kind: "failed", harm: -since() / 1000, note: say("since {time}", { time: clockText(since()) }) };
  if (status === NOT_READY) return { kind: "ready", harm: -since() / 1000, note: waits() };
  if (status === WAITING) {
    const waited = t - since();
    return waited < LONG_WAIT_MS ? null : { kind: "wait", harm: waited / 1000, note: say("for {time}", { time: minutes(waited) }) };
  }
  if (kind !== UAV || status === OFFLINE || status === CHARGING || !(range < LOW_RANGE * fullRange)) return null;
  const km = (m) => `${number(m / 1000, 1)} km`;
  const far = nearest();
  return far !== null && range < far
    ? { kind: "stranded", harm: far - range, note: say("{left} left, {far} to the nearest", { left: km(range), far: km(far) }) }
    : { kind: "range", harm: -range / fullRange, note: say("{left} of {full} left", { left: km(range), full: km(fullRange) }) };
}

/** Kept until another time is asked for: the first panel and the map both ask. */
function agentsInTrouble(run, t) {
  const kept = run.once("agents in trouble", () => ({ t: null, found: null }));
  if (kept.t !== t) Object.assign(kept, { t, found: findTrouble(run, t) });
  return kept.found;
}

/** The agents that an alert names at t, each with its place in the order of urgency: 0 is the most urgent. */
export function agentsWithAlerts(run, t) {
  const found = new Map();
  const add = (agent) => found.has(agent) || found.set(agent, found.size);
  const all = [...agentsInTrouble(run, t), ...messages(run, t), ...nearPairs(run, t)];
  for (const { item, others = [] } of byUrgency(all)) [run.agents[item.index], ...others].forEach(add);
  return found;
}

/** The most harmful kinds first, and of each the most harmful. */
function byUrgency(found) {
  const rank = new Map(KINDS.map((kind, i) => [kind.id, i]));
  return found.sort((a, b) => rank.get(a.kind) - rank.get(b.kind) || b.harm - a.harm);
}

function findTrouble(run, t) {
  return run.agents.flatMap((agent) => {
    const place = agent.kind === UAV ? placeAt(agent, t) : null;
    const known = { kind: agent.kind, status: statusAt(agent, t), range: place?.range, fullRange: agent.fullRange };
    // Places and ranges are whole metres in the page.
    const trouble = troubleOf(known, t, () => spanAt(run, agent, t).since,
      () => (run.charging.length > 0 ? Math.max(0, toCharging(run, place) - 2) : null),
      () => waitWords(run, agent, t));
    return trouble ? [{ ...trouble, item: { type: "agent", index: agent.index }, text: agent.label }] : [];
  });
}

/** What its driver has said by then that it waits for. */
function waitWords(run, agent, t) {
  const said = run.events.findLast((event) => event.kind === "driver_waits" && event.t <= t && event[run.words.agents[agent.kind]] === agent.id);
  return said ? say("waits for {what}", { what: said.detail }) : say("since {time}", { time: clockText(spanAt(run, agent, t).since) });
}

function messages(run, t) {
  return messagesAt(run, t).map(({ agent, text, at, isCall }) => ({ kind: isCall ? "help" : "says", harm: -at, text: agent.label,
    item: { type: "agent", index: agent.index }, note: text }));
}

const closePairs = (run, t) => (run.ended && t >= run.nowMs ? [] : comingClose(run, t));

function nearPairs(run, t) {
  return closePairs(run, t).map(({ a, b, ...approach }) => ({ kind: "near", harm: -approach.inS, note: approachText(approach),
    item: { type: "agent", index: a.index }, others: [b], text: say("{a} and {b}", { a: a.label, b: b.label }) }));
}

/** Metres to the nearest charging point: those further to the east or west than the nearest so far are not looked at. */
function toCharging(run, place) {
  const points = run.once("charging by x", () => [...run.charging].sort((a, b) => a.x - b.x));
  let middle = 0;
  for (let high = points.length; middle < high;) {
    const mid = (middle + high) >> 1;
    if (points[mid].x < place.x) middle = mid + 1;
    else high = mid;
  }
  let nearest = Infinity;
  const look = (point) => { nearest = Math.min(nearest, Math.hypot(point.x - place.x, point.y - place.y)); };
  for (let i = middle; i < points.length && points[i].x - place.x < nearest; ++i) look(points[i]);
  for (let i = middle - 1; i >= 0 && place.x - points[i].x < nearest; --i) look(points[i]);
  return nearest;
}

/** What needs attention at t, by kind and harm: [{ kind, item, text, note }]. `silentMs`: since a live page heard anything. */
export function attentionAt(run, t, silentMs = 0) {
  const found = [...agentsInTrouble(run, t), ...messages(run, t), ...nearPairs(run, t), ...tasksAtRisk(run, t)];
  for (const band of faultBands(run)) {
    const lasts = band.open || (band.to === band.from ? t - band.to <= run.tickMs : t < band.to);
    if (band.kind === "agent" || band.from > t || !lasts) continue;
    const kind = band.kind === "process" ? "process" : "fault";
    found.push({ kind, item: null, t: band.from, harm: -band.from, text: band.lost ?? band.label, note: say("since {time}", { time: clockText(band.from) }) });
  }
  const disputes = run.events.filter((event) => event.kind === "decisions_differ" && event.t <= t);
  if (disputes.length > 0) {
    found.push({ kind: "differ", item: null, harm: 0, t: disputes.at(-1).t, note: disputes.at(-1).detail,
      text: say(disputes.length === 1 ? "once" : "{n} times", { n: number(disputes.length) }) });
  }
  if (silentMs > SILENT_MS && !run.ended) {
    found.push({ kind: "log", item: null, harm: 0, text: say("nothing heard for {n} s", { n: number(silentMs / 1000) }), note: "" });
  }
  if (t >= run.nowMs && run.ended && run.report && !run.report.log.complete) {
    found.push({ kind: "log", item: null, harm: 0, text: say("the log is incomplete"),
      note: say("{n} messages missing", { n: number(run.report.log.n_missing) }) });
  }
  return byUrgency(found);
}

/**
 * How many tasks will be done by the end, from the rate so far: those of the last three intervals go on, per task that
 * is open; tasks that nobody has reported yet do not count. Source: ours; tasks get scarce as they are done, so the rate falls with them.
 */
export function forecastAt(run, t) {
  const total = run.tasksKnownAt(t);
  const done = doneAt(run, t);
  const left = Math.max(0, run.limitMs - t);
  const window = Math.min(t, 3 * run.intervalMs);
  const before = total - doneAt(run, t - window);
  const open = total - done;
  if (window <= 0 || before === 0) return { done, total };
  return { done: Math.round(total - open * (open / before) ** (left / window)), total };
}

/** The task that an alert is about; null: it is about something else. */
const taskOf = (run, { item }) => (item?.type === "task" ? run.tasks[item.id] : null);

/** "12 min": until the task is due, or, once it was, until it expires; how late it is. "": it has no such time. */
export function dueWords(run, found, t) {
  const { due = null, expires = null } = taskOf(run, found) ?? {};
  const next = [due, expires].find((at) => at !== null && at > t);
  if (next !== undefined) return minutes(next - t);
  return due === null || found.kind === "undone" ? "" : say("{time} late", { time: minutes(t - due) });
}

/** Whether an alert is about an emergency, or a task that is late. */
export function isLoud(run, found, t) {
  const task = taskOf(run, found);
  return Boolean(task) && (task.priority >= PRIORITIES.length - 1 || ((task.due ?? null) !== null && task.due < t && found.kind === "risk"));
}

/** What an alert is recognised by while it lasts. */
const alertOf = ({ kind, text }) => `${kind} ${text}`;

/** The first panel of the page: what needs attention at the clock's time. */
export class Attention {
  constructor(state, clock, showTasks) {
    this.state = state;
    this.clock = clock;
    this.showTasks = showTasks;
    this.heard = performance.now();
    this.all = []; // what needs attention
    this.found = []; // without what somebody has seen to
    this.acknowledged = new Set(); // on a live page: what somebody has seen to, until it is over
    this.draw = oncePerFrame(() => this.#draw());
    clock.subscribe(this.draw);
    state.on("data", () => { this.heard = performance.now(); });
    state.on("run data selection", this.draw);
  }

  #draw() {
    const { run, live, selected } = this.state;
    if (!run) return;
    const t = this.clock.t;
    const all = attentionAt(run, t, live ? performance.now() - this.heard : 0);
    if (this.clock.follow) this.#forget(all);
    const found = all.filter((f) => !this.acknowledged.has(alertOf(f)));
    Object.assign(this, { all, found });
    this.state.emit("attention");
    const seen = all.length - found.length;
    const groups = KINDS.map((kind) => found.filter((f) => f.kind === kind.id));
    const key = JSON.stringify([groups.map((group) => [group.length, ...group.slice(0, SHOWN).map((f) => [f.text, f.note])]),
      selected, run.name, decisionAt(run, t)?.index, doneAt(run, t), seen,
      groups.map((group) => group.slice(0, SHOWN).map((f) => dueWords(run, f, t)))]);
    if (key === this.key) return; // what has the focus stays
    this.key = key;
    byId("attention-count").textContent = (found.length === 0 ? say("nothing") : number(found.length))
      + (seen ? `, ${say("{n} acknowledged", { n: number(seen) })}` : "");
    const focused = document.activeElement?.dataset?.attention;
    byId("attention-list").replaceChildren(...KINDS.flatMap((kind, i) => this.#group(kind, groups[i])));
    if (found.length === 0) byId("attention-list").append(element("p", { class: "empty" }, say(seen ? "Nothing else needs attention now." : "Nothing needs attention now.")));
    if (seen) byId("attention-list").append(element("p", {}, element("button", { type: "button", class: "quiet", id: "attention-again", onclick: () => this.#again() }, say("Show {n} acknowledged again", { n: number(seen) }))));
    if (focused) [...byId("attention-list").querySelectorAll("[data-attention]")].find((row) => row.dataset.attention === focused)?.focus({ preventScroll: true });
    byId("forecast").replaceChildren(...this.#forecast(run, t));
  }

  /** What is over needs no acknowledgement any more: it is an alert again when it comes again. */
  #forget(all) {
    const now = new Set(all.map(alertOf));
    for (const alert of this.acknowledged) if (!now.has(alert)) this.acknowledged.delete(alert);
  }

  #acknowledge(found) {
    this.acknowledged.add(alertOf(found));
    this.draw();
    byId("attention-list").focus({ preventScroll: true });
  }

  #again() {
    this.acknowledged.clear();
    this.draw();
  }

  #group(kind, found) {
    if (found.length === 0) return [];
    const more = found.length - SHOWN;
    return [
      element("h3", {}, kind.title, " ", element("b", {}, number(found.length))),
      element("ul", {}, ...found.slice(0, SHOWN).map((f) => element("li", { class: this.state.live ? "live" : null }, this.#row(kind, f),
        this.state.live ? element("button", { type: "button", class: "quiet seen", title: say("Acknowledge"), "aria-label": say("Acknowledge {what}", { what: f.text }), onclick: () => this.#acknowledge(f) }, "✓") : null)),
      more > 0 ? element("li", {}, kind.more
        ? element("button", { type: "button", class: "quiet more", onclick: () => this.showTasks(kind.more) }, say("{n} more in the table", { n: number(more) }))
        : element("span", { class: "muted" }, say("and {n} more", { n: number(more) }))) : null),
    ];
  }

  #row(kind, found) {
    const chosen = found.item && this.state.isSelected(found.item);
    const { run } = this.state;
    const due = dueWords(run, found, this.clock.t);
    return element("button", { type: "button", class: `alarm a-${kind.id}${isLoud(run, found, this.clock.t) ? " loud" : ""}`, "aria-pressed": found.item ? String(Boolean(chosen)) : null,
      "data-attention": `${kind.id} ${found.text}`, onclick: () => (found.item ? this.state.flyTo(found.item) : this.clock.seek(found.t ?? this.clock.t)) },
    element("i", { "aria-hidden": "true" }, kind.mark), element("b", {}, found.text), due ? element("span", { class: "due" }, due) : null, found.note ? element("small", {}, found.note) : null);
  }

  #forecast(run, t) {
    if (t < 3 * run.intervalMs || t >= run.limitMs || (run.ended && t >= run.nowMs)) return [];
    const { done, total } = forecastAt(run, t);
    const parts = sayParts("Forecast: {share} tasks done by the end, at the rate of the last three decisions.", {
      share: element("b", {}, say("{n} of {total}", { n: number(done), total: number(total) })) });
    if (run.ended) {
      const off = done - run.tasksDone;
      const text = off === 0 ? say("It was {n}: exact.") : off > 0 ? say("It was {n}: {off} too many.") : say("It was {n}: {off} too few.");
      parts.push(` ${fill(text, { n: number(run.tasksDone), off: number(Math.abs(off)) })}`);
    }
    return parts;
  }
}

