import { placeAt } from "./run.js";
import { WHOLE } from "./zoom.js";

const AROUND = 1.15; // what is there, and some more
const LEAST = 1.2; // less is not worth it: all of the area then
const MOST = 12;

/** The part of the map's plane where tasks, charging points and agents at their start are: metres; null: nothing is. */
export function boundsOf(run) {
  return run.once("bounds", () => {
    const box = { west: Infinity, east: -Infinity, south: Infinity, north: -Infinity };
    const add = ({ x, y }) => {
      box.west = Math.min(box.west, x);
      box.east = Math.max(box.east, x);
      box.south = Math.min(box.south, y);
      box.north = Math.max(box.north, y);
    };
    for (const task of run.tasks) if (!task.vacant) add(task);
    for (const point of run.charging) add(point);
    for (const agent of run.agents) {
      const place = agent.vacant ? null : placeAt(agent, agent.stops[0] ?? 0);
      if (place) add(place);
    }
    return box.west <= box.east ? box : null;
  });
}

/** The view of a map that opens on what is there. `x` and `y`: metres to pixels with the whole area in view. */
export function homeView(run, { x, y, width, height, margin }) {
  const box = boundsOf(run);
  if (!box) return WHOLE;
  const [left, right, top, bottom] = [x(box.west), x(box.east), y(box.north), y(box.south)];
  const k = Math.min(MOST, (width - 2 * margin) / Math.max(1, AROUND * (right - left)), (height - 2 * margin) / Math.max(1, AROUND * (bottom - top)));
  if (k < LEAST) return WHOLE;
  return { k, left: width / 2 - (k * (left + right)) / 2, top: height / 2 - (k * (top + bottom)) / 2 };
}
