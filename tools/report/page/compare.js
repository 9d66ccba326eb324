import { say } from "./language.js";
import { busOverTime, decisionAt, doneAt, sameActions } from "./run.js";
import { doneTime, flownAt } from "./story.js";
import { rowAt } from "./time.js";

/** The numbers that a run is known by: those of its report, or, while it runs, what is known now. */
export function numbersOf(run) {
  const r = run.report ?? {};
  const live = !run.ended || !run.report;
  const done = live ? run.tasksDone : r.tasks_done;
  const solve = run.decisions.map((d) => d.solveUs / 1e6).sort((a, b) => a - b);
  const processes = r.processes ?? [];
  const bus = live ? busOverTime(run) : null;
  const sum = (key) => (bus ? bus[key].at(-1) ?? 0 : processes.reduce((total, process) => total + process[key], 0));
  return {
    live,
    tasksDone: done,
    tasksTotal: run.tasksKnownAt(run.nowMs),
    completion: live ? done / Math.max(1, run.tasksKnownAt(run.nowMs)) : r.completion_rate,
    weight: run.decisions.reduce((total, d) => total + (d.weight ?? 0), 0),
    decisions: run.decisions.length,
    charges: live ? run.events.filter((e) => e.kind === "charging_done").length : r.charges,
    flownM: live ? flownAt(run, run.nowMs) : r.flown_m,
    medianS: live ? solve[solve.length >> 1] : r.decision_time?.median_s,
    maxS: live ? solve[solve.length - 1] : r.decision_time?.max_s,
    wallS: live ? null : r.wall_s,
    lost: sum("lost"),
    resent: sum("resent"),
    failed: run.events.filter((e) => e.kind === "agent_failed").length,
    complete: r.log?.complete,
    messages: r.log?.messages,
    digest: r.digest,
    policy: r.policy || run.decisions[0]?.policy || "–",
    seed: r.seed ?? run.scenario.seed,
  };
}

/** Whether two runs are of the same scenario, so that they compare. A run that goes on has no report yet: then its places tell. */
export function isSameScenario(a, b) {
  const [mine, yours] = [a, b].map((run) => run.report?.scenario?.sha256);
  if (mine && yours) return mine === yours;
  const placesOf = ({ scenario: s }) => JSON.stringify([s.name, s.seed, s.width_m, s.height_m, s.charging_points]);
  return placesOf(a) === placesOf(b);
}

/** Whether two commands are the same; null: nothing is commanded. What a command weighs does not matter. */
export const isSameCommand = (a, b) => a === b
  || Boolean(a && b && ["kind", "uav", "worker", "vehicle", "task", "charge", "x", "y"].every((key) => a[key] === b[key]));

/** "decision 3", "none" or "other scenario": where `run` first decided otherwise than `reference`. */
export function firstDifference(reference, run) {
  if (reference.report?.scenario?.sha256 !== run.report?.scenario?.sha256) return say("other scenario");
  for (let i = 0; i < Math.max(reference.decisions.length, run.decisions.length); ++i) {
    const a = reference.decisions[i];
    const b = run.decisions[i];
    if (!a || !b || !sameActions(a, b)) return say("decision {index}", { index: i });
  }
  return say("none");
}

/** The numbers of a run as they stood at t; from its end on those of its report. */
export function figuresAt(run, t) {
  const end = numbersOf(run);
  const decision = decisionAt(run, t);
  const until = { solveS: decision ? decision.solveUs / 1e6 : NaN, end };
  if (t >= run.nowMs) return { ...end, ...until };
  const bus = busOverTime(run);
  const row = rowAt(bus.t, 1, t);
  const made = run.decisions.filter((d) => d.t <= t);
  const happened = (kind) => run.events.filter((e) => e.kind === kind && e.t <= t).length;
  const done = doneAt(run, t);
  const tasksTotal = run.tasksKnownAt(t);
  return { ...end, ...until,
    tasksDone: done,
    tasksTotal,
    completion: done / Math.max(1, tasksTotal),
    weight: made.reduce((total, d) => total + (d.weight ?? 0), 0),
    decisions: made.length,
    charges: happened("charging_done"),
    flownM: flownAt(run, t),
    lost: row < 0 ? 0 : bus.lost[row],
    resent: row < 0 ? 0 : bus.resent[row],
    failed: happened("agent_failed") };
}

/** Mean time from the mission's start to the end of a task's sensing, over the tasks done; NaN without any. */
export function responseMs(run) {
  const times = run.tasks.map((task) => doneTime(run, task)).filter((t) => t !== null);
  return times.reduce((sum, t) => sum + t, 0) / times.length;
}
