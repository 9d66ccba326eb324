import { planeOf } from "./place.js";
import { theme } from "./theme.js";

const UNIT = 1e-5; // degrees

/**
 * The coast of a run in the map's plane: { box, rings: [[x, y, ...]], edges } in metres. What lies within an odd number of
 * rings is land; `edges` are their shores, without what runs along the box. Null: the page has none.
 */
export function coastOf(run) {
  const { coast } = run;
  if (!coast) return null;
  coast.plane ??= inPlane(run, coast);
  return coast.plane;
}

function inPlane(run, { box: [south, west, north, east], rings }) {
  const place = (latitude, longitude) => {
    const { x, y } = planeOf(run, latitude * UNIT, longitude * UNIT);
    return [x, y];
  };
  const onSide = (a, b) => (a[0] === b[0] && (a[0] === south || a[0] === north)) || (a[1] === b[1] && (a[1] === west || a[1] === east));
  const plane = { box: [[south, west], [south, east], [north, east], [north, west]].flatMap((corner) => place(...corner)), rings: [], edges: [] };
  for (const ring of rings) {
    const degrees = [];
    let [latitude, longitude] = [0, 0];
    for (let i = 0; i < ring.length; i += 2) degrees.push([latitude += ring[i], longitude += ring[i + 1]]);
    plane.rings.push(degrees.flatMap((each) => place(...each)));
    let line = [];
    for (let i = 0; i < degrees.length; ++i) {
      const next = degrees[(i + 1) % degrees.length];
      if (onSide(degrees[i], next)) {
        if (line.length) plane.edges.push(line);
        line = [];
      } else {
        if (!line.length) line.push(...place(...degrees[i]));
        line.push(...place(...next));
      }
    }
    if (line.length) plane.edges.push(line);
  }
  plane.water = plane.edges.length > 0 || rings.length === 0;
  return plane;
}

/** Whether a place of the map's plane is in water; false where no coast is known. */
export function isWater(run, x, y) {
  const coast = coastOf(run);
  if (!coast?.water) return false;
  let land = false;
  for (const ring of coast.rings) {
    for (let i = 0, j = ring.length - 2; i < ring.length; j = i, i += 2) {
      const [x1, y1, x2, y2] = [ring[i], ring[i + 1], ring[j], ring[j + 1]];
      if (y1 > y !== y2 > y && x < ((x2 - x1) * (y - y1)) / (y2 - y1) + x1) land = !land;
    }
  }
  return !land;
}

function trace(c, line, { x, y }) {
  c.moveTo(x(line[0]), y(line[1]));
  for (let i = 2; i < line.length; i += 2) c.lineTo(x(line[i]), y(line[i + 1]));
}

/** Water, filled, and the shore. */
export function drawCoast(c, run, scales) {
  const coast = coastOf(run);
  if (!coast?.water) return;
  c.beginPath();
  for (const ring of [coast.box, ...coast.rings]) {
    trace(c, ring, scales);
    c.closePath();
  }
  c.fillStyle = theme.water;
  c.fill("evenodd");
  c.beginPath();
  for (const line of coast.edges) trace(c, line, scales);
  c.strokeStyle = theme.shore;
  c.lineWidth = 1;
  c.stroke();
}
