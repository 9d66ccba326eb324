import { isSameScenario } from "../compare.js";
import { say } from "../language.js";
import { doneInOne } from "../rivalry.js";
import { theme } from "../theme.js";

const ID = "one-run";

/** An arrow head around the origin: up for what is done here alone, down for what is done there alone. */
function mark(c, up, r, colour) {
  const high = up ? -1 : 1;
  c.beginPath();
  c.moveTo(-r * 1.9, -high * r * 1.3);
  c.lineTo(r * 1.9, -high * r * 1.3);
  c.lineTo(0, high * r * 2.2);
  c.closePath();
  c.strokeStyle = theme.bg;
  c.lineWidth = 4;
  c.stroke();
  c.strokeStyle = colour;
  c.lineWidth = 1.8;
  c.setLineDash(up ? [] : [3, 2]);
  c.stroke();
  c.setLineDash([]);
}

const isCompared = (run, rival) => rival !== null && isSameScenario(run, rival);
const shows = (run, { extra, rival }) => extra.has(ID) && isCompared(run, rival);

/** Tasks that only one of the two compared runs has done by the chosen time. Found once for each time. */
export const oneRun = {
  id: ID,
  title: say("Done in one run only"),
  extra: true,
  offered: ({ run, rivalRun }) => isCompared(run, rivalRun),
  shows: ({ run, state }) => isCompared(run, state.rivalRun),
  legend: [
    { id: "here-only", mark: '<path d="M1 10.5H11L6 1Z" class="l-here"/>', words: say("done in this run only"), shows },
    { id: "there-only", mark: '<path d="M1 1.5H11L6 11Z" class="l-there"/>', words: say("done in the run compared only"), shows },
  ],
  draw(c, { run, state: { rivalRun, rival, current }, t, x, y, r, edges, sprites }) {
    const kept = run.once(`done in one run ${rival}`, () => ({ t: null, only: null }));
    if (kept.t !== t) Object.assign(kept, { t, only: doneInOne(run, rivalRun, t) });
    kept.only.forEach((tasks, of) => {
      const colour = theme.runs[(of === 0 ? current : rival) % theme.runs.length];
      for (const task of tasks) {
        const [px, py] = [x(task.x), y(task.y)];
        if (px < edges.left || px > edges.right || py < edges.top || py > edges.bottom) continue;
        sprites.stamp(c, `one run ${of} ${colour} ${r}`, r * 2.6 + 4, px, py, (s) => mark(s, of === 0, r, colour));
      }
    });
  },
};
