import { agents } from "./agents.js";
import { baseMap } from "./base_map.js";
import { BELOW } from "./below.js";
import { charging } from "./charging.js";
import { clusters } from "./clusters.js";
import { differences } from "./differences.js";
import { covered, openTasks, response } from "./heat.js";
import { labels } from "./labels.js";
import { marked } from "./marked.js";
import { oneRun } from "./one_run.js";
import { closed, roads } from "./roads.js";
import { scaleBar } from "./scale_bar.js";
import { selected } from "./selected.js";
import { tasks } from "./tasks.js";
import { trails } from "./trails.js";
import { water } from "./water.js";
import { ways } from "./ways.js";
import { zones } from "./zones.js";

/** Those over the ground that are the same wherever the map is moved to, the lowest first. */
export const PRESENT = [covered, openTasks, response, closed, zones, trails, ways, clusters, charging, tasks, agents, oneRun, differences];

/**
 * The map's layers, the lowest first: { draw(c, map), shows(map)?, legend?, extra? }. `map` is what MapView says is in view. A layer
 * without `shows` is always drawn, one that is `extra` when it is asked for. The menu has one with `offered(state)` where that holds.
 */
export const LAYERS = [...BELOW, ...PRESENT, selected, labels, marked, scaleBar];

/**
 * The layers that the legend tells of, in its order; each entry: { mark: SVG, long?, words: text or of a run, shows(run)?, id? }. Those of
 * layers that are shown when asked for are told { t, extra, rival }, too: the time, which of them are shown, and the run compared.
 */
const TOLD = [tasks, charging, agents, baseMap, water, roads, closed, zones, trails, ways, openTasks, response, covered, oneRun];

/** Fills the legend's box; returns what fits it to a run. */
export function makeLegend(box) {
  const entries = TOLD.flatMap((layer) => layer.legend);
  box.innerHTML = entries.map(({ mark, long }) => `<span><svg ${long ? 'viewBox="0 0 24 12" class="long"' : 'viewBox="0 0 12 12"'}>${mark}</svg></span>`).join("");
  const texts = entries.map(({ id, words }, i) => {
    const span = box.children[i];
    if (id) span.id = `legend-${id}`;
    return span.appendChild(document.createTextNode(typeof words === "string" ? words : ""));
  });
  return (run, now) => entries.forEach(({ words, shows }, i) => {
    if (shows) box.children[i].hidden = !shows(run, now);
    if (typeof words !== "string" && !box.children[i].hidden) texts[i].data = words(run, now);
  });
}
