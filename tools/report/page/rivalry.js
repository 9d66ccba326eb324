import { figuresAt, isSameCommand, isSameScenario } from "./compare.js";
import { say } from "./language.js";
import { reasonAt, storyOf } from "./reasons.js";
import { decisionAt, doneAt, taskStatusAt } from "./run.js";
import { commandsAt, commandsByTask, doneTime, waitedMs } from "./story.js";
import { clockText } from "./time.js";
import { CANCELLED, DONE, EXPIRED } from "./words.js";

const ACTION = 9; // numbers in the row of an action, the last one its weight
const SIDE = 3; // parts of the map in a row and in a column

/** The parts of the map, from the south-west on to the east, then to the north. */
export const PARTS = [say("In the south-west"), say("In the south"), say("In the south-east"), say("In the west"), say("In the centre"),
  say("In the east"), say("In the north-west"), say("In the north"), say("In the north-east")];

/** Until when both runs are known: nothing happens in a run after its end. */
function knownUntil(runs) {
  const going = runs.filter((run) => !run.ended).map((run) => run.nowMs);
  return going.length > 0 ? Math.min(...going) : Math.max(...runs.map((run) => run.nowMs));
}

/** What a decision commands, by the agents' names. */
function commandsByName(run, decision) {
  return new Map([...commandsAt(run, decision)].map(([index, command]) => [run.agents[index].label, command]));
}

/** Agents of `run` that two decisions command otherwise. */
function commandedOtherwise(run, mine, other, theirs) {
  const [here, there] = [commandsByName(run, mine), commandsByName(other, theirs)];
  return run.agents.filter(({ label }) => !isSameCommand(here.get(label) ?? null, there.get(label) ?? null));
}

/** Whether two decisions are the same row by row, but for what they weigh. */
function isSameButWeights({ actions: a }, { actions: b }) {
  return a.length === b.length && a.every((value, i) => value === b[i] || i % ACTION === ACTION - 1);
}

/** The first decision that commands agents otherwise: { index, t, agents }; null: none does until then. */
function firstOtherwise(run, other, until) {
  const theirs = new Map(other.decisions.map((decision) => [decision.index, decision]));
  const mine = new Map(run.decisions.map((decision) => [decision.index, decision]));
  for (const index of [...new Set([...mine.keys(), ...theirs.keys()])].sort((a, b) => a - b)) {
    const [a, b] = [mine.get(index) ?? null, theirs.get(index) ?? null];
    const { t } = a ?? b;
    if (t > until) return null;
    if (a && b && isSameButWeights(a, b)) continue;
    const agents = commandedOtherwise(run, a, other, b);
    if (agents.length > 0) return { index, t, agents };
  }
  return null;
}

/** Tasks done in a run less those done in the other: { t, n }, each time that it changes, the first at 0, the last at `until`. */
function leadOver(run, other, until) {
  const times = [run, other].flatMap(({ done }) => done.filter((_, i) => i % 2 === 0));
  const t = [];
  const n = [];
  for (const at of [0, ...new Set(times.filter((time) => time > 0 && time < until).sort((a, b) => a - b)), until]) {
    const lead = doneAt(run, at) - doneAt(other, at);
    if (at > 0 && at < until && lead === n.at(-1)) continue;
    t.push(at);
    n.push(lead);
  }
  return { t, n };
}

/**
 * What the lead over time tells: `changes`, when another run came to be ahead: [{ t, of }]; `most`, the largest lead of each run:
 * { t, n } or null; `since`, from when on the one that is ahead in the end was so for good, null: nobody is. Runs are 0 and 1.
 */
export function readLead({ t, n }) {
  const changes = [];
  const most = [null, null];
  let leader = null;
  let since = null;
  n.forEach((lead, i) => {
    if (lead === 0) {
      since = null;
      return;
    }
    const of = lead > 0 ? 0 : 1;
    if (leader !== null && leader !== of) changes.push({ t: t[i], of });
    if (since === null || leader !== of) since = t[i];
    leader = of;
    if (Math.abs(lead) > (most[of]?.n ?? 0)) most[of] = { t: t[i], n: Math.abs(lead) };
  });
  return { changes, most, since };
}

/** The box around all tasks, cut into parts: { partOf(task), boxOf(part) }, metres. */
function partsOf(tasks) {
  const ends = (key) => tasks.reduce(([low, high], task) => [Math.min(low, task[key]), Math.max(high, task[key])], [Infinity, -Infinity]);
  const [[west, east], [south, north]] = [ends("x"), ends("y")];
  const cut = (value, low, high) => (high > low ? Math.min(SIDE - 1, Math.floor(((value - low) / (high - low)) * SIDE)) : SIDE >> 1);
  const [wide, high] = [(east - west) / SIDE, (north - south) / SIDE];
  return {
    partOf: ({ x, y }) => cut(y, south, north) * SIDE + cut(x, west, east),
    boxOf: (part) => ({ x: west + ((part % SIDE) + 0.5) * wide, y: south + (Math.floor(part / SIDE) + 0.5) * high, wide, high }),
  };
}

const isTask = (task) => task !== undefined && !task.vacant;
const isDone = (task, t) => isTask(task) && taskStatusAt(task, t) === DONE;

/** The tasks that only one of two runs has done by t, of the first one and of the second one. */
export function doneInOne(run, other, t) {
  const only = [[], []];
  for (let id = 0; id < Math.max(run.tasks.length, other.tasks.length); ++id) {
    const [here, there] = [isDone(run.tasks[id], t), isDone(other.tasks[id], t)];
    if (here !== there) only[here ? 0 : 1].push((here ? run : other).tasks[id]);
  }
  return only;
}

/** Of tasks done, { t, of }: from when on one run is ahead for good; null: nobody is. */
function aheadSince(list) {
  const lead = { t: [], n: [] };
  let sum = 0;
  [...list].sort((a, b) => a.t - b.t).forEach(({ t, of }, i, all) => {
    sum += of === 0 ? 1 : -1;
    if (all[i + 1]?.t === t) return; // at one time
    lead.t.push(t);
    lead.n.push(sum);
  });
  return readLead(lead).since;
}

/**
 * Tasks done in each part of the map where their number differs, the largest difference first: { part, done, more, since (from when on
 * one was ahead there for good), box }.
 */
function partsThatDiffer(run, other, until) {
  const tasks = [...run.tasks, ...other.tasks].filter(isTask);
  if (tasks.length === 0) return [];
  const { partOf, boxOf } = partsOf(tasks);
  const done = PARTS.map(() => []); // { t, of }
  [run, other].forEach((one, of) => {
    for (const task of one.tasks) if (isDone(task, until)) done[partOf(task)].push({ t: doneTime(one, task), of });
  });
  const told = (list, part) => {
    const n = [0, 1].map((one) => list.filter(({ of }) => of === one).length);
    return { part, done: n, more: n[0] - n[1], since: aheadSince(list), box: boxOf(part) };
  };
  return done.map(told).filter(({ more }) => more !== 0)
    .sort((a, b) => Math.abs(b.more) - Math.abs(a.more) || a.part - b.part);
}

/** Why a run has not done a task that another one did at t: in a line. */
function whyNot(run, id, t, until) {
  if (!isTask(run.tasks[id])) return say("it has no such task");
  const later = doneTime(run, run.tasks[id]);
  if (later !== null) return say("done later, at {time}", { time: clockText(later) }); // than the other one is known
  const status = taskStatusAt(run.tasks[id], until);
  if (status === CANCELLED) return say(run.words.tasks[status]);
  const story = storyOf(run, id);
  const reason = story && (reasonAt(story, decisionAt(run, t)) ?? story.decisions[0]);
  if (reason) return reason.lines[0];
  if (status === EXPIRED) return say(run.words.tasks[status]);
  if (!run.ended) return say("not yet done");
  return say(commandsByTask(run)[id].length > 0 ? "somebody was sent, in vain" : "nobody was ever sent");
}

/** Mean time that the tasks done took, from their report or, without reports, from the mission's start: milliseconds; NaN: none is done. */
function tookMs(run, until) {
  const times = run.tasks.filter((task) => isDone(task, until)).map((task) => doneTime(run, task) - (run.timed ? task.reported ?? 0 : 0));
  return times.reduce((sum, ms) => sum + ms, 0) / times.length;
}

/** Of two numbers the larger one's place; null where they are equal or not known. */
const larger = ([a, b]) => (a > b ? 0 : b > a ? 1 : null);

function compared(run, other) {
  const both = [run, other];
  const until = knownUntil(both);
  const ended = run.ended && other.ended;
  const done = both.map((one) => doneAt(one, until));
  const worth = ended ? both.map((one) => one.report?.service?.worth_done ?? null) : [null, null];
  const byWorth = worth.includes(null) ? null : larger(worth);
  const byDone = larger(done);
  const figures = both.map((one) => figuresAt(one, until));
  const only = doneInOne(run, other, until).map((tasks, of) => tasks.map((task) => {
    const t = doneTime(both[of], task);
    return { task, t, why: whyNot(both[1 - of], task.id, t, until) };
  }).sort((a, b) => (b.task.priority ?? 0) - (a.task.priority ?? 0) || a.t - b.t || a.task.id - b.task.id));
  const decision = firstOtherwise(run, other, until);
  const lead = leadOver(run, other, until);
  const isAlike = decision === null && only.every((tasks) => tasks.length === 0) && lead.n.every((n) => n === 0);
  return {
    until, ended, done, worth: worth.includes(null) ? null : worth, byDone, byWorth, decision, lead, only, isAlike,
    better: byDone ?? byWorth, // null: undecided
    isOpen: byDone !== null && byWorth !== null && byDone !== byWorth, // one did more tasks, the other one worth more
    total: both.map((one) => one.tasksKnownAt(until)),
    ends: ended && run.nowMs !== other.nowMs ? both.map((one) => one.nowMs) : null,
    took: both.map((one) => tookMs(one, until)),
    ...readLead(lead),
    parts: partsThatDiffer(run, other, until),
    by: { flownM: figures.map((f) => f.flownM), charges: figures.map((f) => f.charges), failed: figures.map((f) => f.failed),
      waitedMs: both.map((one) => waitedMs(one, Math.min(until, one.nowMs))) },
    failures: both.map((one) => one.events.find((event) => event.kind === "agent_failed" && event.t <= until) ?? null),
  };
}

/** How two runs of a scenario compare, run 0 with run 1; null: they are of different scenarios. It is found once. */
export function rivalry(run, other) {
  if (!isSameScenario(run, other)) return null;
  const kept = run.once("rivals", () => new Map());
  const known = kept.get(other);
  // The other one's once() begins anew with each thing that it learns.
  const mark = other.once("as a rival", () => ({}));
  if (known?.mark !== mark) kept.set(other, { mark, found: compared(run, other) });
  return kept.get(other).found;
}
