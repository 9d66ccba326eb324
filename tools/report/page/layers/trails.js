import { say } from "../language.js";
import { placeAt } from "../run.js";
import { theme } from "../theme.js";
import { rowAt } from "../time.js";

/** Traces the way that an agent has gone in a time. */
export function trace(c, { x, y }, agent, from, t) {
  const { stops } = agent;
  const start = placeAt(agent, Math.max(from, stops[0] ?? 0));
  const now = placeAt(agent, t);
  if (!start) return;
  c.moveTo(x(start.x), y(start.y));
  for (let i = (rowAt(stops, 4, from) + 1) * 4; i < stops.length && stops[i] < t; i += 4) {
    c.lineTo(x(stops[i + 1]), y(stops[i + 2]));
  }
  c.lineTo(x(now.x), y(now.y));
}

/** Where agents have been of late. */
export const trails = {
  legend: [{ mark: '<path d="M1 9 12 3 23 6" class="l-trail"/>', long: true, words: say("trail") }],
  shows: ({ state }) => state.trailMs > 0,
  draw(c, map) {
    const { run, state, t } = map;
    c.lineWidth = 1.3;
    c.globalAlpha = run.agents.length > 500 ? 0.3 : 0.5;
    for (let kind = 0; kind < 3; ++kind) {
      if (!state.classes[kind]) continue;
      c.strokeStyle = theme.kinds[kind];
      c.beginPath();
      for (const { agent } of map.ways) if (agent.kind === kind) trace(c, map, agent, t - state.trailMs, t);
      c.stroke();
    }
    c.globalAlpha = 1;
  },
};
