import { theme } from "../theme.js";
import { MOVING } from "../words.js";

/** Where those who move are going. */
export const ways = {
  legend: [{ mark: '<path d="M1 6H23" class="l-dash"/>', long: true, words: "on the way to" }],
  shows: ({ cells }) => !cells,
  draw(c, map) {
    const { run, x, y } = map;
    const crowded = run.agents.length > 500;
    if (!crowded) c.setLineDash([3, 4]);
    c.lineWidth = 1;
    c.globalAlpha = crowded ? 0.25 : 0.6;
    for (let kind = 0; kind < 3; ++kind) {
      c.strokeStyle = theme.kinds[kind];
      c.beginPath();
      for (const { agent, status, place, px, py } of map.ways) {
        if (agent.kind !== kind || status !== MOVING) continue;
        c.moveTo(px, py);
        c.lineTo(x(place.toX), y(place.toY));
      }
      c.stroke();
    }
    c.setLineDash([]);
    c.globalAlpha = 1;
  },
};
