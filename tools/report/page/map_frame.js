import { drawCoast } from "./coast.js";
import { degreesOf, latitudeWords, longitudeWords, planeOf } from "./place.js";
import { roundTicks } from "./scale.js";
import { theme } from "./theme.js";

const FONT = "system-ui, sans-serif";
const DEGREE_STEPS = [0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10];
const SCALES = [100000, 50000, 20000, 10000, 5000, 2000, 1000, 500, 200, 100, 50, 20, 10, 5]; // metres, of the bar
const BENDS = 8; // pieces of a line of latitude or longitude

/** The part of the area that is in view: pixels. */
export function frameOf({ x, y, width, height }, { width_m: w, height_m: h }) {
  const left = Math.max(0, x(0));
  const top = Math.max(0, y(h));
  return { left, top, right: Math.min(width, x(w)), bottom: Math.min(height, y(0)) };
}

/** Lines each so many kilometres with their numbers, and the area's border. */
export function drawGrid(c, run, { x, y, width, height }) {
  const { width_m: w, height_m: h } = run.scenario;
  const [left, right, top, bottom] = [Math.max(0, x(0)), Math.min(width, x(w)), Math.max(0, y(h)), Math.min(height, y(0))];
  const metres = (from, to, pixels) => roundTicks([Math.max(0, from), to], pixels / 55, [1, 2, 5]);
  const numbers = [];
  c.strokeStyle = theme.grid;
  c.lineWidth = 1;
  c.beginPath();
  for (const m of metres(x.invert(0), Math.min(w, x.invert(width)), right - left)) {
    const px = Math.round(x(m)) + 0.5;
    c.moveTo(px, top);
    c.lineTo(px, bottom);
    numbers.push([`${m / 1000}`, "center", px, Math.min(height - 5, y(0) + 13)]);
  }
  c.font = `10px ${FONT}`;
  for (const m of metres(y.invert(height), Math.min(h, y.invert(0)), bottom - top)) {
    const py = Math.round(y(m)) + 0.5;
    c.moveTo(left, py);
    c.lineTo(right, py);
    const text = `${m / 1000}`;
    numbers.push([text, "right", Math.max(c.measureText(text).width + 3, x(0) - 5), py + 3]);
  }
  c.stroke();
  c.strokeStyle = theme.line;
  c.strokeRect(x(0), y(h), x(w) - x(0), y(0) - y(h));
  // Numbers stand over the lines, the area's border too.
  c.save();
  c.strokeStyle = theme.bg;
  c.fillStyle = theme.muted;
  c.lineWidth = 3;
  c.lineJoin = "round";
  for (const [text, align, px, py] of numbers) {
    c.textAlign = align;
    c.strokeText(text, px, py);
    c.fillText(text, px, py);
  }
  c.restore();
}

/** The ground of the area, its water, and what a file says is there (`muster report --background`). */
export function drawGround(c, run, scales) {
  const { x, y } = scales;
  const { width_m: w, height_m: h } = run.scenario;
  c.fillStyle = theme.bg;
  c.fillRect(x(0), y(h), x(w) - x(0), y(0) - y(h));
  drawCoast(c, run, scales);
  for (const shape of backgroundOf(run)) drawShape(c, shape, scales);
}

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

function drawShape(c, { kind, name, rings }, { x, y }) {
  c.beginPath();
  for (const ring of rings) {
    for (let i = 0; i < ring.length; i += 2) {
      if (kind === 0) c.rect(x(ring[i]) - 1.5, y(ring[i + 1]) - 1.5, 3, 3);
      else if (i === 0) c.moveTo(x(ring[0]), y(ring[1]));
      else c.lineTo(x(ring[i]), y(ring[i + 1]));
    }
    if (kind === 2) c.closePath();
  }
  c.strokeStyle = theme.muted;
  c.fillStyle = kind === 0 ? theme.muted : theme.band;
  c.lineWidth = 1;
  if (kind !== 1) c.fill("evenodd");
  if (kind !== 0) c.stroke();
  if (!name || rings.length === 0 || rings[0].length < 2) return;
  c.font = `italic 11px ${FONT}`;
  c.fillStyle = theme.muted;
  c.textAlign = "left";
  const [left, top] = kind === 2 ? middleOf(rings[0]) : rings[0];
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

/** Lines of latitude and longitude, dotted, with their degrees inside the frame; nothing without an origin. */
export function drawDegrees(c, run, scales, frame) {
  const { x, y } = scales;
  const wide = frame.right - frame.left;
  const high = frame.bottom - frame.top;
  const corner = degreesOf(run, { x: x.invert(frame.left), y: y.invert(frame.bottom) });
  if (!corner || wide < 80 || high < 80) return;
  const other = degreesOf(run, { x: x.invert(frame.right), y: y.invert(frame.top) });
  const step = (from, to, pixels) => DEGREE_STEPS.find((s) => ((to - from) / s) * 100 <= pixels) ?? 20;
  c.save();
  c.beginPath();
  c.rect(frame.left, frame.top, wide, high);
  c.clip();
  c.strokeStyle = theme.muted;
  c.fillStyle = theme.muted;
  c.lineWidth = 1;
  c.font = `10px ${FONT}`;
  const trace = (place) => {
    c.globalAlpha = 0.45;
    c.setLineDash([1, 4]);
    c.beginPath();
    for (let i = 0; i <= BENDS; ++i) {
      const at = place(i / BENDS);
      c.lineTo(x(at.x), y(at.y));
    }
    c.stroke();
    c.globalAlpha = 1;
    c.setLineDash([]);
  };
  const mix = (from, to, share) => from + share * (to - from);
  const digits = (s) => (s < 0.01 ? 3 : s < 0.1 ? 2 : s < 1 ? 1 : 0);
  c.textAlign = "right";
  const north = step(corner[0], other[0], high);
  for (let i = Math.ceil(corner[0] / north); i * north <= other[0]; ++i) {
    trace((share) => planeOf(run, i * north, mix(corner[1], other[1], share)));
    const py = y(planeOf(run, i * north, corner[1]).y);
    if (py > frame.top + 56 && py < frame.bottom - 30) c.fillText(latitudeWords(i * north, digits(north)), frame.right - 6, py - 3);
  }
  c.textAlign = "left";
  const east = step(corner[1], other[1], wide);
  for (let i = Math.ceil(corner[1] / east); i * east <= other[1]; ++i) {
    trace((share) => planeOf(run, mix(corner[0], other[0], share), i * east));
    const px = x(planeOf(run, other[0], i * east).x);
    if (px > frame.left + 4 && px < frame.right - 90) c.fillText(longitudeWords(i * east, digits(east)), px + 3, frame.top + 11);
  }
  c.restore();
}

/** The longest round distance that fits. */
function scaleOf(perMetre, frame) {
  const room = Math.min(140, Math.max(40, (frame.right - frame.left) / 3));
  const metres = SCALES.find((m) => m * perMetre <= room) ?? SCALES.at(-1);
  return { metres, length: metres * perMetre, right: frame.right - 12, bottom: frame.bottom - 10 };
}

/** Where the scale and the arrow to the north stand: [{ left, top, wide, high }]. */
export function scaleBoxes(perMetre, frame) {
  const { length, right, bottom } = scaleOf(perMetre, frame);
  return [{ left: right - length - 6, top: bottom - 19, wide: length + 12, high: 25 }, { left: right - 22, top: frame.top + 6, wide: 26, high: 36 }];
}

/** How long a distance is, and where north is: inside the frame, at the right. */
export function drawScale(c, perMetre, frame) {
  const { metres, length, right, bottom } = scaleOf(perMetre, frame);
  const text = metres >= 1000 ? `${metres / 1000} km` : `${metres} m`;
  c.fillStyle = theme.bg;
  c.globalAlpha = 0.8;
  for (const box of scaleBoxes(perMetre, frame)) c.fillRect(box.left, box.top, box.wide, box.high);
  c.globalAlpha = 1;
  c.strokeStyle = theme.text;
  c.fillStyle = theme.text;
  c.lineWidth = 1.5;
  c.beginPath();
  c.moveTo(right - length, bottom - 4);
  c.lineTo(right - length, bottom);
  c.lineTo(right, bottom);
  c.lineTo(right, bottom - 4);
  c.stroke();
  c.font = `11px ${FONT}`;
  c.textAlign = "center";
  c.fillText(text, right - length / 2, bottom - 6);
  const top = frame.top + 9;
  c.beginPath();
  c.moveTo(right - 9, top);
  c.lineTo(right - 4, top + 15);
  c.lineTo(right - 9, top + 11);
  c.lineTo(right - 14, top + 15);
  c.closePath();
  c.fill();
  c.fillText("N", right - 9, top + 28);
}
