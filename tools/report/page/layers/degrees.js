import { degreesOf, latitudeWords, longitudeWords, planeOf } from "../place.js";
import { theme } from "../theme.js";

const FONT = "system-ui, sans-serif";
const DEGREE_STEPS = [0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10];
const BENDS = 8; // pieces of a line of latitude or longitude

/** Lines of latitude and longitude, dotted, with their degrees inside the frame; nothing without an origin. */
function draw(c, { run, x, y, frame }) {
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

export const degrees = { draw };
