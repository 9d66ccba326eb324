import { say } from "../language.js";
import { theme } from "../theme.js";
import { rowAt } from "../time.js";
import { MOVING, UAV } from "../words.js";

/** Traces the rest of a way with corners, by road or around zones, as far as it is known: on a live page, to its next corner. */
function traceAhead(c, { x, y, t }, agent) {
  const { stops, spans } = agent;
  const end = spans[(rowAt(spans, 2, t) + 1) * 2] ?? Infinity;
  for (let i = (rowAt(stops, 4, t) + 1) * 4; i < stops.length && stops[i] <= end; i += 4) c.lineTo(x(stops[i + 1]), y(stops[i + 2]));
}

/** Where those who move are going. */
export const ways = {
  id: "ways",
  title: say("Ways ahead"),
  legend: [{ mark: '<path d="M1 6H23" class="l-dash"/>', long: true, words: say("on the way to") }],
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
        if (kind === UAV ? run.scenario.air : run.scenario.roads) traceAhead(c, map, agent);
        else c.lineTo(x(place.toX), y(place.toY));
      }
      c.stroke();
    }
    c.setLineDash([]);
    c.globalAlpha = 1;
  },
};
