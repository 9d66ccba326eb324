// Symbols that would cover each other stand together as clusters. Squares of a grid that is fixed to the map's plane decide who
// stands with whom: that depends on places and on zoom, and never on which part of the map is in view.
import { number } from "./dom.js";
import { fill, say } from "./language.js";
import { CANCELLED, DONE, EXPIRED } from "./words.js";

const SQUARE_PX = 64; // a square's side is as long as this to twice as long
const SYMBOL_PX = 16; // the side of the room that a symbol needs
const OFFSET = 2 ** 20; // squares may lie west and south of the area

/** Classes that a cluster counts: agents' own, in the order of the wire's numbers, and these. */
export const TO_DO = 3;
export const OVER = 4;
export const CHARGING_POINT = 5;
const NAMES = [[say("{n} UAV"), say("{n} UAVs")], [say("{n} worker"), say("{n} workers")], [say("{n} vehicle"), say("{n} vehicles")],
  [say("{n} task to do"), say("{n} tasks to do")], [say("{n} task over"), say("{n} tasks over")], [say("{n} charging point"), say("{n} charging points")]];

const ALERTS = [say("{n} alert"), say("{n} alerts")];

export const classOfTask = (status) => ([DONE, EXPIRED, CANCELLED].includes(status) ? OVER : TO_DO);

/** The level of the grid whose squares have metres of 2 ** level at their sides, for a zoom in pixels a metre. */
export const levelOf = (perMetre) => Math.ceil(Math.log2(SQUARE_PX / perMetre));

/** How many symbols have room in a square. */
export const roomIn = (level, perMetre) => Math.floor((2 ** level * perMetre / SYMBOL_PX) ** 2);

/** Items { x, y in metres, of (its class), alone (never in a cluster) } by the squares that they are in. */
export class Squares {
  constructor(items, level) {
    this.side = 2 ** level;
    this.all = new Map();
    for (const item of items) {
      const column = Math.floor(item.x / this.side);
      const row = Math.floor(item.y / this.side);
      const key = (column + OFFSET) * 2 * OFFSET + row + OFFSET;
      let square = this.all.get(key);
      if (!square) this.all.set(key, square = { key, column, row, crowd: [], alone: [], cluster: null });
      (item.alone ? square.alone : square.crowd).push(item);
    }
  }

  /** The squares that have something and touch a box in metres. */
  within({ west, east, south, north }) {
    const [first, last, low, high] = [west, east, south, north].map((m) => Math.floor(m / this.side));
    const found = [];
    if ((last - first + 1) * (high - low + 1) > this.all.size) {
      for (const square of this.all.values()) {
        if (square.column >= first && square.column <= last && square.row >= low && square.row <= high) found.push(square);
      }
      return found;
    }
    for (let row = high; row >= low; --row) {
      for (let column = first; column <= last; ++column) {
        const square = this.all.get((column + OFFSET) * 2 * OFFSET + row + OFFSET);
        if (square) found.push(square);
      }
    }
    return found;
  }

  /** The agents of all squares that have room for everything. */
  roomyAgents(room) {
    if (this.found?.room !== room) this.found = { room, agents: agentsWithRoom([...this.all.values()], room) };
    return this.found.agents;
  }

  /** The cluster of a square's crowd: its number by class, that of alerts, the middle of its places and the box around them. */
  clusterOf(square) {
    square.cluster ??= makeCluster(square, this.side);
    return square.cluster;
  }
}

function makeCluster({ key, column, row, crowd }, side) {
  const box = { west: Infinity, east: -Infinity, south: Infinity, north: -Infinity };
  const counts = NAMES.map(() => 0);
  let alerts = 0;
  let [x, y] = [0, 0];
  for (const item of crowd) {
    ++counts[item.of];
    if (item.urgent) ++alerts;
    x += item.x / crowd.length;
    y += item.y / crowd.length;
    box.west = Math.min(box.west, item.x);
    box.east = Math.max(box.east, item.x);
    box.south = Math.min(box.south, item.y);
    box.north = Math.max(box.north, item.y);
  }
  return { key: `${key} ${side}`, x, y, counts, alerts, box, items: crowd, square: { west: column * side, south: row * side, side } };
}

/** The agents in those squares where nothing stands together. */
export const agentsWithRoom = (squares, room) => squares.filter(({ crowd }) => crowd.length <= room)
  .flatMap(({ crowd, alone }) => [...alone, ...crowd]).filter(({ agent }) => agent);

/** Those of a square that are drawn by themselves, where so many symbols have room. */
export const apart = ({ crowd, alone }, room) => (crowd.length > room ? alone : [...alone, ...crowd]);

/** "12 UAVs, 30 workers, 4 tasks to do, 2 alerts" */
export function clusterWords({ counts, alerts }) {
  const words = (n, [one, many]) => (n > 0 ? fill(n === 1 ? one : many, { n: number(n) }) : "");
  return [...counts.map((n, of) => words(n, NAMES[of])), words(alerts, ALERTS)].filter(Boolean).join(", ");
}
