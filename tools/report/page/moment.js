import { say } from "./language.js";
import { faultBands } from "./run.js";
import { clockText } from "./time.js";

/**
 * The moment at which a page opens, and why: the first failure; without any, where progress slackens most, which is
 * where the tasks done are furthest above the straight line from start to end.
 */
export function tellingMoment(run) {
  const first = [...faultBands(run)].sort((a, b) => a.from - b.from)[0];
  if (first) return { t: first.from, why: say("the first failure: {what}", { what: first.label }) };
  const total = run.tasksTotal;
  if (total === 0) return { t: 0, why: say("the mission has no task") };
  let best = null;
  for (let i = 0; i < run.done.length; i += 2) {
    const [t, done] = [run.done[i], run.done[i + 1]];
    const above = done - (run.tasksDone * t) / Math.max(1, run.nowMs);
    if (!best || above > best.above) best = { t, done, above };
  }
  if (!best || run.tasksDone === 0) return { t: run.nowMs, why: say("no task was done") };
  if (run.tasksDone === total && best.done === total) return { t: best.t, why: say("the last task is done") };
  return { t: best.t, why: say("progress slackens from here: {n} of {total} tasks done, {end} at {time}", {
    n: best.done, total, end: run.tasksDone, time: clockText(run.nowMs, false) }) };
}
