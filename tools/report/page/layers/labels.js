import { say } from "../language.js";
import { drawLabels } from "../map_labels.js";
import { labelOf } from "../names.js";
import { theme } from "../theme.js";
import { CANCELLED, DONE } from "../words.js";
import { baseMapNames } from "./base_map.js";
import { badgeOf } from "./clusters.js";
import { scaleBoxes } from "./scale_bar.js";
import { placeOf } from "./selected.js";

const LABEL_PX = 6000; // of the map for each name

/** Names: of what is selected first; of agents, then tasks to do, while few enough are in view. */
export const labels = {
  id: "names",
  title: say("Names"),
  draw(c, map) {
    const { run, state: { selected }, t, x, y, r, k } = map;
    const found = [];
    const put = (text, px, py, colour) => map.inView(px, py) && found.push({ text, px, py, gap: r + 3, colour });
    if (selected) {
      const place = placeOf(run, selected, t);
      if (place) put(labelOf(run, selected), x(place.x), y(place.y), theme.text);
    }
    const room = (map.width * map.height) / LABEL_PX;
    const named = selected?.type === "agent" ? selected.index : -1;
    const agents = map.near.length > room + 1 ? map.near : map.near.filter(({ agent }) => agent.index !== named);
    const tasks = map.sites.filter(({ task, status }) => ![DONE, CANCELLED].includes(status) && !(selected?.type === "task" && selected.id === task.id));
    if (agents.length <= room) {
      for (const { agent, px, py } of agents) put(agent.label, px, py, theme.kinds[agent.kind]);
      if (k >= 1.5 && agents.length + tasks.length <= room) for (const { task, px, py } of tasks) put(`${task.id}`, px, py, theme.muted);
    }
    for (const { text, x: px, y: py } of baseMapNames(map)) put(text, x(px), y(py), theme.muted);
    drawLabels(c, found, map, theme.bg, [...scaleBoxes(map.perMetre, map.frame), ...map.clusters.map((cluster) => badgeOf(cluster, map))]);
  },
};
