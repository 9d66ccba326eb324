import { planeOf } from "../place.js";
import { theme } from "../theme.js";

const FONT = "system-ui, sans-serif";

/** What a file says is there (`muster report --background`). */
export const background = {
  shows: ({ run }) => run.background,
  draw(c, map) {
    for (const shape of backgroundOf(map.run)) drawShape(c, shape, map);
  },
};

/** The background's shapes in the map's plane: { kind, name, rings: [[x, y, ...]] }. */
function backgroundOf(run) {
  if (!run.background) return [];
  return run.once("background", () => run.background.map(([kind, name, ...rings]) => ({ kind, name,
    rings: rings.map((ring) => {
      const flat = [];
      for (let i = 0; i < ring.length; i += 2) {
        const place = planeOf(run, ring[i], ring[i + 1]);
        flat.push(place.x, place.y);
      }
      return flat;
    }) })));
}

/** Kinds of shapes, as tools/report/background.h has them. */
const [POINTS, LINES, AREAS] = [0, 1, 2];

function drawShape(c, { kind, name, rings }, { x, y }) {
  c.beginPath();
  for (const ring of rings) {
    for (let i = 0; i < ring.length; i += 2) {
      if (kind === POINTS) c.rect(x(ring[i]) - 1.5, y(ring[i + 1]) - 1.5, 3, 3);
      else if (i === 0) c.moveTo(x(ring[0]), y(ring[1]));
      else c.lineTo(x(ring[i]), y(ring[i + 1]));
    }
    if (kind === AREAS) c.closePath();
  }
  c.strokeStyle = theme.muted;
  c.fillStyle = kind === POINTS ? theme.muted : theme.band;
  c.lineWidth = 1;
  if (kind !== LINES) c.fill("evenodd");
  if (kind !== POINTS) c.stroke();
  if (!name || rings.length === 0 || rings[0].length < 2) return;
  c.font = `italic 11px ${FONT}`;
  c.fillStyle = theme.muted;
  c.textAlign = "left";
  const [left, top] = kind === AREAS ? middleOf(rings[0]) : rings[0];
  c.fillText(name, x(left) + 5, y(top) - 4);
}

function middleOf(ring) {
  let [sumX, sumY] = [0, 0];
  for (let i = 0; i < ring.length; i += 2) {
    sumX += ring[i];
    sumY += ring[i + 1];
  }
  return [(2 * sumX) / ring.length, (2 * sumY) / ring.length];
}
