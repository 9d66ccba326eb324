import { levelOf } from "../clusters.js";
import { number, percent } from "../dom.js";
import { coverage, coverageSide, coveredShare, openHeat, responseHeat } from "../heat.js";
import { say } from "../language.js";
import { theme } from "../theme.js";

const FONT = "9px system-ui, sans-serif";
const PALE = 0.08; // of the least heat, as alpha
const DARK = 0.55; // of the most

/** Squares, the darker the more, with their numbers in a lower corner. */
function drawHeat(c, { x, y, perMetre, edges }, { side, squares, least, most }, colour, right) {
  const px = side * perMetre;
  c.save();
  c.font = FONT;
  c.textAlign = right ? "right" : "left";
  for (const { west, south, value } of squares) {
    const [left, bottom] = [x(west), y(south)];
    if (left + px < edges.left || left > edges.right || bottom < edges.top || bottom - px > edges.bottom) continue;
    c.globalAlpha = PALE + (DARK - PALE) * (most > least ? (value - least) / (most - least) : 1);
    c.fillStyle = colour;
    c.fillRect(left, bottom - px, px, px);
    c.globalAlpha = 1;
    c.fillStyle = theme.text;
    c.fillText(number(value), right ? left + px - 3 : left + 3, bottom - 3);
  }
  c.restore();
}

const mark = (of) => `<path d="M.5 .5h11v11H.5Z" class="l-${of}"/>`;

/** Where tasks are that nobody is sent to. */
export const openTasks = {
  id: "open-heat",
  title: say("Heat: open tasks"),
  extra: true,
  legend: [{ id: "open-heat", mark: mark("open-heat"), words: say("heat: open tasks in a square, the darker the more"), shows: (run, { extra }) => extra.has("open-heat") }],
  draw(c, map) {
    drawHeat(c, map, openHeat(map.run, map.t, levelOf(map.perMetre)), theme.openHeat, false);
  },
};

/** How long tasks took to be done. */
export const response = {
  id: "response-heat",
  title: say("Heat: response time"),
  extra: true,
  legend: [{ id: "response-heat", mark: mark("response-heat"), shows: (run, { extra }) => extra.has("response-heat"),
    words: (run) => say(run.timed ? "heat: minutes from report to done, mean of a square, the darker the longer"
    : "heat: minutes from the mission's start to done, mean of a square, the darker the longer") }],
  draw(c, map) {
    drawHeat(c, map, responseHeat(map.run, map.t, levelOf(map.perMetre)), theme.responseHeat, true);
  },
};

const sideWords = (side) => (side >= 1000 ? `${side / 1000} km` : `${side} m`);

/** Where UAVs have been. */
export const covered = {
  id: "coverage",
  title: say("Coverage"),
  extra: true,
  legend: [{ id: "coverage", mark: mark("coverage"), shows: (run, { extra }) => extra.has("coverage"),
    words: (run, { t }) => say("covered: a UAV has been in this square of {side}; {share} of the area", {
      side: sideWords(coverageSide(run.scenario)), share: percent(coveredShare(run, t)) }) }],
  draw(c, { run, t, x, y }) {
    const { side, columns, rows } = coverage(run);
    c.save();
    c.imageSmoothingEnabled = false;
    c.globalAlpha = 0.35;
    c.drawImage(picture(run, t), x(0), y(rows * side), x(columns * side) - x(0), y(0) - y(rows * side));
    c.restore();
  },
};

/** A pixel for each square, the northernmost row first. */
function picture(run, t) {
  const { columns, rows, first } = coverage(run);
  const made = run.once("coverage picture", () => ({ canvas: new OffscreenCanvas(columns, rows) }));
  if (made.t === t && made.colour === theme.coverage) return made.canvas;
  Object.assign(made, { t, colour: theme.coverage });
  const c = made.canvas.getContext("2d");
  const pixels = c.createImageData(columns, rows);
  for (let i = 0; i < first.length; ++i) {
    const row = rows - 1 - Math.floor(i / columns);
    if (first[i] <= t) pixels.data[4 * (row * columns + (i % columns)) + 3] = 255;
  }
  c.putImageData(pixels, 0, 0);
  c.globalCompositeOperation = "source-in";
  c.fillStyle = theme.coverage;
  c.fillRect(0, 0, columns, rows);
  c.globalCompositeOperation = "source-over";
  return made.canvas;
}
