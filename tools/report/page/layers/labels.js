import { say } from "../language.js";
import { drawLabels } from "../map_labels.js";
import { labelOf, shortName } from "../names.js";
import { theme } from "../theme.js";
import { CANCELLED, DONE, EXPIRED, IDLE, MOVING } from "../words.js";
import { PAIR, RING } from "./agents.js";
import { baseMapNames } from "./base_map.js";
import { badgeOf } from "./clusters.js";
import { pairsOf } from "./pairs.js";
import { scaleBoxes } from "./scale_bar.js";
import { placeOf } from "./selected.js";

const LABEL_PX = 6000; // of the map for each name
const REST_ZOOM = 1.5; // from that on those are named that do nothing, and tasks

/** Why something is named, what matters most first. */
const [ALERT, MOVES, WORKS, RESTS] = [0, 1, 2, 3];

/** How much the name of an agent matters: with an alert that stands out, on its way, at work, or none of these. */
export function rankOf({ loud, status }) {
  if (loud) return ALERT;
  return status === MOVING ? MOVES : status === IDLE ? RESTS : WORKS;
}

/** The names of agents and tasks in view, without what is selected, in the order in which they matter: { text, px, py, rank, wide (of a pair) }. */
export function namesInView({ near, sites, k, state }) {
  const chosen = (item) => state.isSelected(item);
  const { names: paired, partners } = pairsOf(near);
  const agents = near.filter(({ agent }) => !chosen({ type: "agent", index: agent.index }) && !partners.has(agent))
    .map((item) => ({ text: paired.get(item.agent) ?? shortName(item.agent), px: item.px, py: item.py, rank: rankOf(item), wide: paired.has(item.agent) }));
  const tasks = sites.filter(({ task, status, loud }) => (loud || k >= REST_ZOOM) && ![DONE, CANCELLED, EXPIRED].includes(status)
    && !chosen({ type: "task", id: task.id })).map(({ task, px, py, loud }) => ({ text: `${task.id}`, px, py, rank: loud ? ALERT : RESTS }));
  return [...agents, ...tasks].filter(({ rank }) => rank !== RESTS || k >= REST_ZOOM).sort((a, b) => a.rank - b.rank);
}

/** Names: of what is selected first, then of alerts that stand out, of who moves, who works, and near enough of the rest. */
export const labels = {
  id: "names",
  title: say("Names"),
  draw(c, map) {
    const { run, state: { allSelected }, t, x, y, r } = map;
    const found = [];
    const put = (text, px, py, colour, wide = false) => map.inView(px, py) && found.push({ text, px, py, gap: r * (wide ? PAIR : RING) + 3, colour });
    for (const item of allSelected) {
      const place = placeOf(run, item, t);
      if (place) put(labelOf(run, item), x(place.x), y(place.y), theme.text);
    }
    const room = (map.width * map.height) / LABEL_PX;
    const colour = (rank) => (rank === ALERT ? theme.failed : rank === RESTS ? theme.muted : theme.text);
    for (const { text, px, py, rank, wide } of namesInView(map).slice(0, room)) put(text, px, py, colour(rank), wide);
    for (const { text, x: px, y: py } of baseMapNames(map)) put(text, x(px), y(py), theme.muted);
    drawLabels(c, found, map, theme.bg, [...scaleBoxes(map.perMetre, map.frame), ...map.clusters.map((cluster) => badgeOf(cluster, map))]);
  },
};
