import { faultBands } from "./run.js";
import { clockText } from "./time.js";

/**
 * The moment at which a page opens, and why: the first failure; without any, where progress slackens most, which is
 * where the tasks done are furthest above the straight line from start to end.
 */
export function tellingMoment(run) {
  const first = [...faultBands(run)].sort((a, b) => a.from - b.from)[0];
  if (first) return { t: first.from, why: `the first failure: ${first.label}` };
  const total = run.tasksTotal;
  if (total === 0) return { t: 0, why: "the mission has no task" };
  let best = null;
  for (let i = 0; i < run.done.length; i += 2) {
    const [t, done] = [run.done[i], run.done[i + 1]];
    const above = done - (run.tasksDone * t) / Math.max(1, run.nowMs);
    if (!best || above > best.above) best = { t, done, above };
  }
  if (!best || run.tasksDone === 0) return { t: run.nowMs, why: "no task was done" };
  if (run.tasksDone === total && best.done === total) return { t: best.t, why: "the last task is done" };
  return { t: best.t, why: `progress slackens from here: ${best.done} of ${total} tasks done, ${run.tasksDone} at ${clockText(run.nowMs, false)}` };
}
