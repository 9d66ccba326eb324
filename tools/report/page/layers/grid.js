import { roundTicks } from "../scale.js";
import { say } from "../language.js";
import { theme } from "../theme.js";

const FONT = "system-ui, sans-serif";

/** Lines each so many kilometres with their numbers, and the area's border. */
function draw(c, { run, x, y, width, height }) {
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

export const grid = { id: "grid", title: say("Grid"), draw };
