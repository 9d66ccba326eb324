import { coastOf, drawCoast } from "../coast.js";
import { say } from "../language.js";

/** The area's water and its shore. */
export const water = {
  id: "water",
  title: say("Water"),
  shows: ({ run }) => coastOf(run)?.water,
  draw: (c, map) => drawCoast(c, map.run, map),
  legend: [{ id: "water", mark: '<path d="M.5 .5h11v11H.5Z" class="l-water"/>', words: (run) => say("water ({source})", { source: run.coast?.source }),
    shows: (run) => coastOf(run)?.water }],
};
