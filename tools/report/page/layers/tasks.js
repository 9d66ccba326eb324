import { say } from "../language.js";
import { theme } from "../theme.js";
import { BEING_SENSED, CANCELLED, DONE, EXPIRED, HELD, RESERVED } from "../words.js";

/** open: hollow; reserved: hollow with a dot; being sensed: full; done: a small tick; held: two bars; cancelled: struck through */
function mark(c, status, r) {
  c.beginPath();
  if (status === DONE) {
    c.moveTo(-r * 0.7, 0);
    c.lineTo(-r * 0.15, r * 0.6);
    c.lineTo(r * 0.8, -r * 0.7);
  } else if (status === EXPIRED) {
    c.moveTo(-r * 0.7, -r * 0.7);
    c.lineTo(r * 0.7, r * 0.7);
    c.moveTo(-r * 0.7, r * 0.7);
    c.lineTo(r * 0.7, -r * 0.7);
  } else {
    const size = status === BEING_SENSED ? r * 1.5 : r * 1.15;
    c.moveTo(0, -size);
    c.lineTo(size, 0);
    c.lineTo(0, size);
    c.lineTo(-size, 0);
    c.closePath();
    if (status === RESERVED) c.rect(-1, -1, 2, 2);
    for (const x of status === HELD ? [-r * 0.28, r * 0.28] : []) {
      c.moveTo(x, -r * 0.45);
      c.lineTo(x, r * 0.45);
    }
    if (status === CANCELLED) {
      c.moveTo(-size * 1.3, 0);
      c.lineTo(size * 1.3, 0);
    }
  }
  c.strokeStyle = status === DONE || status === CANCELLED ? theme.done : status === BEING_SENSED ? theme.sensing : theme.task;
  c.lineWidth = status === DONE ? 1.6 : 1.4;
  if (status === BEING_SENSED) {
    c.fillStyle = theme.sensing;
    c.fill();
  }
  c.stroke();
}

/** Tasks. */
export const tasks = {
  id: "tasks",
  title: say("Tasks"),
  legend: [
    { mark: '<path d="M6 1 11 6 6 11 1 6Z" class="l-task"/>', words: say("open") },
    { mark: '<path d="M6 1 11 6 6 11 1 6Z" class="l-task"/><path d="M5 5h2v2H5Z" class="l-dot"/>', words: say("reserved") },
    { mark: '<path d="M6 1 11 6 6 11 1 6Z" class="l-sensing"/>', words: say("being sensed") },
    { mark: '<path d="m2 6 3 3 5-6" class="l-done"/>', words: say("done") },
    { id: "expired", mark: '<path d="M2.5 2.5 9.5 9.5M2.5 9.5 9.5 2.5" class="l-task"/>', words: say("expired"), shows: (run) => run.timed },
    { id: "held", mark: '<path d="M6 1 11 6 6 11 1 6ZM5 4v4M7 4v4" class="l-task"/>', words: say("held"), shows: (run) => run.hasOrders },
    { id: "cancelled", mark: '<path d="M6 1 11 6 6 11 1 6ZM0 6H12" class="l-done"/>', words: say("cancelled"), shows: (run) => run.hasOrders },
  ],
  draw(c, { r, sites, sprites }) {
    for (const { status, px, py } of [...sites].sort((a, b) => b.status - a.status)) {
      sprites.stamp(c, `task${status} ${r}`, r * 2 + 3, px, py, (s) => mark(s, status, r));
    }
  },
};
