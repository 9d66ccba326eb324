// Heat of the map: tasks counted, or their times averaged, in the squares of the clusters' grid; and what UAVs have been over.
import { Squares } from "./clusters.js";
import { taskStatusAt } from "./run.js";
import { doneTime } from "./story.js";
import { OPEN, UAV } from "./words.js";

const COVERED_M = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000]; // sides of the squares of the coverage
const MOST_SQUARES = 200; // along the area, unless squares of the largest side are more

/** Kept for one time and one level of the grid. */
function kept(run, key, t, level, make) {
  const last = run.once(key, () => ({}));
  if (last.t !== t || last.level !== level) Object.assign(last, { t, level, found: make() });
  return last.found;
}

/** Squares with what `number` says of their items: { side, least, most, squares: [{ west, south, value }] }. */
function heatOf(items, level, number) {
  const { all, side } = new Squares(items, level);
  const squares = [...all.values()].map(({ column, row, crowd }) => ({ west: column * side, south: row * side, value: number(crowd) }));
  return { side, squares, least: squares.reduce((least, { value }) => Math.min(least, value), Infinity),
    most: squares.reduce((most, { value }) => Math.max(most, value), 0) };
}

/** How many tasks are open at t, that is, nobody is sent to them. */
export function openHeat(run, t, level) {
  return kept(run, "heat of open tasks", t, level, () =>
    heatOf(run.tasks.filter((task) => !task.vacant && taskStatusAt(task, t) === OPEN), level, (tasks) => tasks.length));
}

/** Mean time, in minutes, from report to done of the tasks done by t; where tasks have no report, from the mission's start. */
export function responseHeat(run, t, level) {
  return kept(run, "heat of response", t, level, () => {
    const done = run.tasks.map((task) => ({ x: task.x, y: task.y, end: doneTime(run, task), from: task.reported ?? 0 }))
      .filter(({ end }) => end !== null && end <= t);
    return heatOf(done, level, (tasks) => tasks.reduce((sum, { end, from }) => sum + (end - from) / 60000, 0) / tasks.length);
  });
}

/** The side, in metres, of the squares of the coverage. */
export function coverageSide({ width_m: w, height_m: h }) {
  return COVERED_M.find((side) => Math.max(w, h) / side <= MOST_SQUARES) ?? COVERED_M.at(-1);
}

/** When a UAV was first in each square of the area: { side, columns, rows, first: ms by row and column, Infinity: never }. */
export function coverage(run) {
  return run.once("coverage", () => {
    const { width_m: w, height_m: h } = run.scenario;
    const side = coverageSide(run.scenario);
    const [columns, rows] = [Math.ceil(w / side), Math.ceil(h / side)];
    const map = { side, columns, rows, first: new Float64Array(columns * rows).fill(Infinity) };
    for (const { kind, stops } of run.agents) {
      if (kind !== UAV) continue;
      for (let i = 0; i < stops.length; i += 4) fly(map, stops, i);
    }
    return map;
  });
}

/** Marks the squares from the stop at row `i` up to the next one. */
function fly({ side, columns, rows, first }, stops, i) {
  const [t, x, y] = stops.slice(i, i + 3);
  const [end, toX, toY] = i + 4 < stops.length ? stops.slice(i + 4, i + 7) : [t, x, y];
  const steps = Math.max(1, Math.ceil(Math.hypot(toX - x, toY - y) / (side / 4)));
  for (let step = 0; step <= steps; ++step) {
    const share = step / steps;
    const column = Math.floor((x + share * (toX - x)) / side);
    const row = Math.floor((y + share * (toY - y)) / side);
    if (column < 0 || row < 0 || column >= columns || row >= rows) continue;
    const at = row * columns + column;
    first[at] = Math.min(first[at], t + share * (end - t));
  }
}

/** The share of the area's squares that a UAV has been in by t. */
export function coveredShare(run, t) {
  const { first } = coverage(run);
  return first.reduce((n, at) => n + (at <= t), 0) / first.length;
}
