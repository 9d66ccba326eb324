import { say } from "../language.js";
import { theme } from "../theme.js";

/** The roads as paths in metres, by what they are drawn as: 0 for people alone, 1 slow, 2 fast roads. */
function pathsOf(run) {
  return run.once("roads", () => {
    const paths = [new Path2D(), new Path2D(), new Path2D()];
    const { classes, lines } = run.scenario.roads;
    for (const [kind, ...places] of lines) {
      const vehicles = classes[kind][2];
      const path = paths[vehicles === 0 ? 0 : vehicles < 70 ? 1 : 2];
      path.moveTo(places[0], places[1]);
      for (let i = 2; i < places.length; i += 2) path.lineTo(places[i], places[i + 1]);
    }
    return paths;
  });
}

/** What is closed at that time: [order, name, since_ms, roads] each, and of a zone its rings. */
export function closuresAt(run, t) {
  return run.roadChanges.filter(([at]) => at <= t).at(-1)?.[1] ?? [];
}

/** The same for the same closures. */
export const closuresKey = (closures) => closures.map(([order, , , { length }]) => `${order} ${length}`).join();

/** The closed roads as a path in metres. */
function closedPath(run, closures) {
  return run.once(`closed ${closuresKey(closures)}`, () => {
    const path = new Path2D();
    for (const road of new Set(closures.flatMap(([, , , roads]) => roads))) {
      const [, ...places] = run.scenario.roads.lines[road];
      path.moveTo(places[0], places[1]);
      for (let i = 2; i < places.length; i += 2) path.lineTo(places[i], places[i + 1]);
    }
    return path;
  });
}

/** The roads that are closed, as broken lines over their own. */
export const closed = {
  id: "closed",
  title: say("Closed roads"),
  legend: [{ id: "closed", mark: '<path d="M1 8 12 4 23 7" class="l-closed"/>', long: true, words: say("closed road"),
    shows: (run) => run.roadChanges.some(([, closures]) => closures.some(([, , , closedRoads]) => closedRoads.length > 0)) }],
  shows: ({ run }) => run.roadChanges.length > 0,
  draw(c, { run, x, y, t }) {
    const closures = closuresAt(run, t);
    if (closures.length === 0) return;
    const perM = x(1) - x(0);
    c.save();
    c.transform(perM, 0, 0, y(1) - y(0), x(0), y(0));
    c.strokeStyle = theme.failed;
    c.lineWidth = 3 / perM;
    c.setLineDash([2 / perM, 3 / perM]);
    c.stroke(closedPath(run, closures));
    c.restore();
  },
};

/** The roads that workers and vehicles travel by. */
export const roads = {
  id: "roads",
  title: say("Roads"),
  legend: [{ id: "roads", mark: '<path d="M1 8 12 4 23 7" class="l-road"/>', long: true, words: (run) => say("road ({source})", { source: run.scenario.roads?.source }),
    shows: (run) => run.scenario.roads !== undefined }],
  shows: ({ run }) => run.scenario.roads,
  draw(c, { run, x, y }) {
    if (!run.scenario.roads) return;
    const perM = x(1) - x(0);
    c.save();
    c.transform(perM, 0, 0, y(1) - y(0), x(0), y(0));
    c.strokeStyle = theme.road;
    pathsOf(run).forEach((path, wide) => {
      c.setLineDash(wide === 0 ? [3 / perM, 3 / perM] : []);
      c.lineWidth = (0.6 + 0.7 * wide) / perM;
      c.stroke(path);
    });
    c.restore();
  },
};
