import { ALL_FREE } from "./free_part.js";
import { placeAt } from "./run.js";
import { WHOLE } from "./zoom.js";

const AROUND = 1.15; // what is there, and some more
const LEAST = 1.1; // of the whole area's scale; less is not worth it: all of the area then
const MOST = 12;

/** The part of the map's plane where tasks, charging points, zones and agents at their start are: metres; null: nothing is. */
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
    if (box.west <= box.east) addZones(run, add);
    return box.west <= box.east ? box : null;
  });
}

/** Zones that were ever in force, as far as they are in the area. */
function addZones(run, add) {
  const { width_m: w, height_m: h } = run.scenario;
  const within = (value, most) => Math.min(most, Math.max(0, value));
  for (const [, closures] of run.roadChanges ?? []) {
    for (const ring of closures.flatMap(([, , , , rings]) => rings ?? [])) {
      for (let i = 0; i < ring.length; i += 2) add({ x: within(ring[i], w), y: within(ring[i + 1], h) });
    }
  }
}

/** The view in which a box of the plane, in pixels at scale 1, fills the map's free part. */
function fitted([left, right, top, bottom], around, { width, height, margin, free = ALL_FREE }) {
  const [wide, high] = [width - free.left - free.right, height - free.top - free.bottom];
  const scale = (room, size) => Math.max(1, room - 2 * margin) / Math.max(1, around * size);
  const k = Math.min(MOST, scale(wide, right - left), scale(high, bottom - top));
  return { k, left: free.left + wide / 2 - (k * (left + right)) / 2, top: free.top + high / 2 - (k * (top + bottom)) / 2 };
}

/** The view of all of the area. `map`: as homeView has it. */
export function wholeView(run, map) {
  const { free = ALL_FREE, x, y } = map;
  if (!free.left && !free.right && !free.top && !free.bottom) return WHOLE;
  const { width_m: w, height_m: h } = run.scenario;
  return fitted([x(0), x(w), y(h), y(0)], 1, map);
}

/**
 * The view of a map that opens on what is there. `map`: { x, y (metres to pixels with the whole area in view), width, height, margin,
 * free (what floats on the map leaves free) }.
 */
export function homeView(run, map) {
  const box = boundsOf(run);
  const whole = wholeView(run, map);
  if (!box) return whole;
  const { x, y } = map;
  const view = fitted([x(box.west), x(box.east), y(box.north), y(box.south)], AROUND, map);
  return view.k < LEAST * whole.k ? whole : view;
}
