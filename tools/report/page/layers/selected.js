import { placeAt } from "../run.js";
import { theme } from "../theme.js";
import { trace } from "./trails.js";

/** Where something is at t; null when that is not known. */
export function placeOf(run, item, t) {
  if (item.type === "agent") return placeAt(run.agents[item.index], t);
  return (item.type === "task" ? run.tasks : run.charging)[item.id] ?? null;
}

/** What is selected: a ring around each, and all of an agent's way so far. */
export const selected = {
  shows: ({ state }) => state.selected,
  draw(c, map) {
    for (const item of map.state.allSelected) drawOne(c, map, item);
  },
};

function drawOne(c, map, item) {
  const { run, t, x, y, r } = map;
  const place = placeOf(run, item, t);
  if (!place) return;
  const agent = item.type === "agent" ? run.agents[item.index] : null;
  if (agent) {
    c.strokeStyle = theme.kinds[agent.kind];
    c.lineWidth = 2.2;
    c.beginPath();
    trace(c, map, agent, 0, t);
    c.stroke();
  }
  c.strokeStyle = theme.cursor;
  c.lineWidth = 2;
  c.beginPath();
  c.arc(x(place.x), y(place.y), r * 2.8, 0, 2 * Math.PI);
  c.stroke();
}
