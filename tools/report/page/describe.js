import { placeAt, statusAt, taskStatusAt } from "./run.js";
import { UAV } from "./words.js";

/** One line about an agent, a task or a charging point at t. */
export function describe(run, item, t) {
  if (item.type === "agent") {
    const agent = run.agents[item.index];
    const place = placeAt(agent, t);
    const range = agent.kind === UAV && place
      ? `, ${(place.range / 1000).toFixed(1)} of ${(agent.fullRange / 1000).toFixed(0)} km left` : "";
    return `${agent.label}: ${run.words.statuses[statusAt(agent, t)]}${range}`;
  }
  if (item.type === "task") {
    const task = run.tasks[item.id];
    return `task ${item.id}: ${run.words.tasks[taskStatusAt(task, t)]}, takes ${(task.cost / 1000).toFixed(1)} km of range`;
  }
  const point = run.charging[item.id];
  return `charging point ${item.id}: ${point.capacity === null ? "any number of" : point.capacity} UAV${point.capacity === 1 ? "" : "s"} at a time`;
}
