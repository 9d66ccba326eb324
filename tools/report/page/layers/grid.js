import { roundTicks } from "../scale.js";
import { say } from "../language.js";
import { theme } from "../theme.js";

const FONT = "system-ui, sans-serif";

const stepOf = ([first, second]) => second - first;

/** The same lines over all of the map, pale: it goes on outside the area. */
function drawOutside(c, { x, y, width, height, step }) {
  if (!(step > 0)) return;
  c.globalAlpha = 0.55;
  c.fillStyle = theme.line;
  for (let i = Math.ceil(x.invert(0) / step); i * step <= x.invert(width); ++i) c.fillRect(Math.round(x(i * step)), 0, 1, height);
  for (let i = Math.ceil(y.invert(height) / step); i * step <= y.invert(0); ++i) c.fillRect(0, Math.round(y(i * step)), width, 1);
  c.globalAlpha = 1;
}

/** Lines each so many kilometres, with their numbers in the area, paler outside where that is the map's, and the area's border. */
function draw(c, { run, x, y, width, height, free = null }) {
  const { width_m: w, height_m: h } = run.scenario;
  const [left, right, top, bottom] = [Math.max(0, x(0)), Math.min(width, x(w)), Math.max(0, y(h)), Math.min(height, y(0))];
  const metres = (from, to, pixels) => roundTicks([Math.max(0, from), to], pixels / 55, [1, 2, 5]);
  if (free) drawOutside(c, { x, y, width, height, step: stepOf(metres(x.invert(0), Math.min(w, x.invert(width)), right - left)) });
  const numbers = [];
  c.fillStyle = theme.grid; // rectangles: a path of all lines takes several times as long
  for (const m of metres(x.invert(0), Math.min(w, x.invert(width)), right - left)) {
    const px = Math.round(x(m)) + 0.5;
    c.fillRect(px - 0.5, top, 1, bottom - top);
    numbers.push([`${m / 1000}`, "center", px, Math.min(height - (free?.bottom ?? 0) - 5, y(0) + 13)]);
  }
  c.font = `10px ${FONT}`;
  for (const m of metres(y.invert(height), Math.min(h, y.invert(0)), bottom - top)) {
    const py = Math.round(y(m)) + 0.5;
    c.fillRect(left, py - 0.5, right - left, 1);
    const text = `${m / 1000}`;
    numbers.push([text, "right", Math.max((free?.left ?? 0) + c.measureText(text).width + 5, x(0) - 5), py + 3]);
  }
  c.lineWidth = 1;
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

export const grid = { id: "grid", title: say("Grid"), draw };
