import { say } from "./language.js";
import { pointName, taskName } from "./names.js";
import { placeAt, statusAt, taskStatusAt } from "./run.js";
import { UAV } from "./words.js";

/** One line about an agent, a task or a charging point at t. */
export function describe(run, item, t) {
  if (item.type === "agent") {
    const agent = run.agents[item.index];
    const place = placeAt(agent, t);
    const range = agent.kind === UAV && place
      ? `, ${rangeWords(agent, place)}` : "";
    return `${agent.label}: ${say(run.words.statuses[statusAt(agent, t)])}${range}`;
  }
  if (item.type === "task") {
    const task = run.tasks[item.id];
    return say("{task}: {status}, takes {km} km of range", {
      task: taskName(item.id), status: say(run.words.tasks[taskStatusAt(task, t)]), km: (task.cost / 1000).toFixed(1) });
  }
  return `${pointName(item.id)}: ${roomWords(run.charging[item.id])}`;
}

/** "12.3 of 30 km left" */
export const rangeWords = (agent, place) =>
  say("{left} of {full} km left", { left: (place.range / 1000).toFixed(1), full: (agent.fullRange / 1000).toFixed(0) });

/** "2 UAVs at a time" */
export function roomWords({ capacity }) {
  if (capacity === null) return say("any number of UAVs at a time");
  return say(capacity === 1 ? "{n} UAV at a time" : "{n} UAVs at a time", { n: capacity });
}
