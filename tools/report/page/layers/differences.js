import { differencesAt } from "../differences.js";
import { theme } from "../theme.js";

/** Who is commanded otherwise in another run: a ring, and a line to where that run sends it, in that run's colour. */
export const differences = {
  shows: ({ state }) => state.other !== null,
  draw(c, map) {
    const { run, state: { runs, other }, t, x, y, r } = map;
    c.strokeStyle = theme.runs[other % theme.runs.length];
    c.lineWidth = 1.6;
    const there = new Map(differencesAt(run, runs[other], t).map((pair) => [pair.agent, pair.there]));
    for (const { agent, px, py } of map.ways) {
      if (!there.has(agent)) continue;
      c.beginPath();
      c.arc(px, py, r * 1.8, 0, 2 * Math.PI);
      c.stroke();
      const command = there.get(agent);
      if (!command) continue;
      c.beginPath();
      c.setLineDash([7, 3]);
      c.moveTo(px, py);
      c.lineTo(x(command.x), y(command.y));
      c.stroke();
      c.setLineDash([]);
    }
  },
};
