import { say } from "../language.js";
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

/** The zones that UAVs keep out of. */
export const zones = {
  id: "zones",
  title: say("Zones"),
  legend: [{ id: "zones", mark: '<path d="M2 2H22V10H2Z" class="l-zone"/>', long: true, words: say("zone that UAVs keep out of"),
    shows: (run) => run.roadChanges.some(([, closures]) => closures.some(([, , , , rings]) => rings)) }],
  draw(c, { run, x, y, t }) {
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
