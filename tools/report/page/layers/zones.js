import { say } from "../language.js";
import { number } from "../dom.js";
import { theme } from "../theme.js";
import { closuresAt, closuresKey } from "./roads.js";

/** The zones in force at that time: { order, name, rings: [[x, y, x, y, ...], ...] in metres } each. */
export const zonesAt = (run, t) => closuresAt(run, t).filter(([, , , , rings]) => rings).map(([order, name, , , rings]) => ({ order, name, rings }));

function pathOf(rings) {
  const path = new Path2D();
  for (const places of rings) {
    path.moveTo(places[0], places[1]);
    for (let i = 2; i < places.length; i += 2) path.lineTo(places[i], places[i + 1]);
    path.closePath();
  }
  return path;
}

/** The zone that the place lies in, by the even-odd rule, the last that was added; undefined: none. */
export function zoneAt(run, t, { x, y }) {
  const crosses = (places) => {
    let n = 0;
    for (let i = 0, j = places.length - 2; i < places.length; j = i, i += 2) {
      const [ax, ay, bx, by] = [places[j], places[j + 1], places[i], places[i + 1]];
      if ((ay > y) !== (by > y) && x < ax + ((bx - ax) * (y - ay)) / (by - ay)) ++n;
    }
    return n;
  };
  return zonesAt(run, t).findLast(({ rings }) => rings.reduce((n, places) => n + crosses(places), 0) % 2 === 1);
}

/** Those that UAVs fly below at that time: [name, where it begins in m, until when or null, rings] each. */
const highZonesAt = (run, t) => (run.scenario.air?.high_zones ?? []).filter(([, , until]) => until === null || t < until);

const TEXT_PX = 11;

/** Dashed outlines, with the height where each begins in its middle, if there is room. */
function drawHigh(c, high, { x, y }) {
  c.save();
  c.strokeStyle = c.fillStyle = theme.failed;
  c.globalAlpha = 0.8;
  c.setLineDash([6, 4]);
  c.font = `${TEXT_PX}px system-ui, sans-serif`;
  c.textAlign = "center";
  for (const [name, from_m, , rings] of high) {
    c.beginPath();
    for (const places of rings) {
      for (let i = 0; i < places.length; i += 2) c.lineTo(x(places[i]), y(places[i + 1]));
      c.closePath();
    }
    c.stroke();
    const xs = rings[0].filter((_, i) => i % 2 === 0).map(x), ys = rings[0].filter((_, i) => i % 2 === 1).map(y);
    const [left, right, top, bottom] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    const words = say("from {m} m up", { m: number(from_m) }), text = name ? `${name}: ${words}` : words;
    if (c.measureText(text).width < right - left && TEXT_PX * 2 < bottom - top) c.fillText(text, (left + right) / 2, (top + bottom) / 2);
  }
  c.restore();
}

/** The zones that UAVs keep out of, and those that they fly below. */
export const zones = {
  id: "zones",
  title: say("Zones"),
  legend: [{ id: "zones", mark: '<path d="M2 2H22V10H2Z" class="l-zone"/>', long: true, words: say("zone that UAVs keep out of"),
    shows: (run) => run.roadChanges.some(([, closures]) => closures.some(([, , , , rings]) => rings)) },
  { id: "high-zones", mark: '<path d="M2 2H22V10H2Z" class="l-high-zone"/>', long: true, words: say("zone that UAVs fly below"),
    shows: (run) => (run.scenario.air?.high_zones ?? []).length > 0 }],
  draw(c, { run, x, y, t }) {
    drawHigh(c, highZonesAt(run, t), { x, y });
    const shown = zonesAt(run, t);
    if (shown.length === 0) return;
    const path = run.once(`zones ${closuresKey(closuresAt(run, t))}`, () => {
      const all = new Path2D();
      for (const { rings } of shown) all.addPath(pathOf(rings));
      return all;
    });
    const perM = x(1) - x(0);
    c.save();
    c.transform(perM, 0, 0, y(1) - y(0), x(0), y(0));
    c.fillStyle = c.strokeStyle = theme.failed;
    c.globalAlpha = 0.1;
    c.fill(path, "evenodd");
    c.globalAlpha = 0.8;
    c.lineWidth = 1.2 / perM;
    c.stroke(path);
    c.restore();
  },
};
