import { say } from "../language.js";
import { widthsIn } from "../map_labels.js";
import { Sprites } from "../sprites.js";
import { theme } from "../theme.js";
import { boxOf } from "./base_map.js";

const FONT = "10px system-ui, sans-serif";
const HALO_PX = 2.5;
const MOST = 60;
/** Pixels a metre from which on those of a rank are named: main roads, streets, paths. */
const LEAST = new Map([[6, 0.04], [7, 0.1], [8, 0.25]]);
const ROOM_PX = 12; // between two names
const AGAIN_PX = 300; // between two of the same street
const TURN = Math.PI / 60; // between two pictures of a name
const pictures = new Sprites();

/**
 * The names of streets that have room along their streets, the most important first, none over another and none upside down.
 * `streets`: [{ from, to, rank, text }] in metres. Returns [{ text, px, py, angle }].
 */
export function placeStreets(streets, widthOf, { x, y, width, height }) {
  const perMetre = x(1) - x(0);
  const ends = streets.filter(({ rank }) => perMetre >= LEAST.get(rank)).map(({ from, to, rank, text }) => {
    const [dx, dy] = [x(to.x) - x(from.x), y(to.y) - y(from.y)];
    return { text, rank, px: x(from.x) + dx / 2, py: y(from.y) + dy / 2, long: Math.hypot(dx, dy), angle: Math.atan2(dy, dx) };
  });
  const placed = [];
  const taken = []; // places along the names so far
  for (const { text, px, py, long, angle } of ends.sort((a, b) => a.rank - b.rank || b.long - a.long)) {
    if (placed.length === MOST) break;
    if (px < 0 || py < 0 || px > width || py > height || widthOf(text) > long) continue;
    if (placed.some((other) => other.text === text && Math.hypot(other.px - px, other.py - py) < AGAIN_PX)) continue;
    const n = Math.ceil(widthOf(text) / ROOM_PX);
    const along = Array.from({ length: n + 1 }, (_, i) => (i / n - 0.5) * widthOf(text)).map((at) => [px + at * Math.cos(angle), py + at * Math.sin(angle)]);
    if (along.some(([ax, ay]) => taken.some(([bx, by]) => Math.hypot(ax - bx, ay - by) < ROOM_PX))) continue;
    taken.push(...along);
    const upright = Math.abs(angle) > Math.PI / 2 ? angle - Math.sign(angle) * Math.PI : angle;
    placed.push({ text, px, py, angle: upright });
  }
  return placed;
}

const measured = widthsIn(FONT);

function drawText(c, text, angle) {
  c.rotate(angle);
  Object.assign(c, { font: FONT, textAlign: "center", textBaseline: "middle", lineJoin: "round", lineWidth: HALO_PX, strokeStyle: theme.bg, fillStyle: theme.muted });
  c.strokeText(text, 0, 0);
  c.fillText(text, 0, 0);
}

/** The names of the base map's streets, along them. */
export const streetNames = {
  id: "streets",
  title: say("Street names"),
  shows: ({ run }) => run.baseMap?.info.vector,
  draw(c, map) {
    const { baseMap: base } = map.run;
    const perMetre = map.x(1) - map.x(0);
    if (!base?.info.vector || perMetre < Math.min(...LEAST.values())) return;
    const streets = base.within(boxOf(map), perMetre).flatMap((tile) => tile.streets);
    c.save();
    for (const { text, px, py, angle } of placeStreets(streets, (of) => measured(c, of), map)) {
      const turned = Math.round(angle / TURN) * TURN;
      pictures.stamp(c, `${theme.muted} ${theme.bg} ${turned} ${text}`, measured(c, text) / 2 + HALO_PX + 6, px, py, (s) => drawText(s, text, turned));
    }
    c.restore();
  },
};
