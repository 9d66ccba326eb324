import { say } from "../language.js";
import { theme } from "../theme.js";
import { BEING_SENSED, CANCELLED, DONE, EXPIRED, HELD, RESERVED } from "../words.js";

const isOver = (status) => [DONE, CANCELLED, EXPIRED].includes(status);

/** How loud a task is on the map. */
export const [QUIET, PLAIN, HIGH, LOUD] = [0, 1, 2, 3];

/** Emergencies and tasks that are late are loud, those of low priority quiet. */
export function loudnessOf({ priority, due }, status, t) {
  if (isOver(status)) return QUIET;
  if (priority >= 3 || (due !== null && due !== undefined && due < t && status !== BEING_SENSED)) return LOUD;
  return priority === 2 ? HIGH : priority === 0 ? QUIET : PLAIN;
}

/** A tick, or a cross: it is over, and recedes. */
function over(c, status, r) {
  c.globalAlpha = 0.75;
  c.beginPath();
  if (status === DONE) {
    c.moveTo(-r * 0.6, 0);
    c.lineTo(-r * 0.15, r * 0.5);
    c.lineTo(r * 0.65, -r * 0.6);
  } else {
    c.moveTo(-r * 0.6, -r * 0.6);
    c.lineTo(r * 0.6, r * 0.6);
    c.moveTo(-r * 0.6, r * 0.6);
    c.lineTo(r * 0.6, -r * 0.6);
  }
  c.strokeStyle = theme.done;
  c.lineWidth = 1.3;
  c.stroke();
}

/** open: hollow; reserved: hollow with a dot; being sensed: full; done: a small tick; held: two bars; cancelled: struck through */
function mark(c, status, r, loudness) {
  if (status === DONE || status === EXPIRED) return over(c, status, r);
  const size = status === BEING_SENSED ? r * 1.4 : r * [0.95, 1.15, 1.25, 1.4][loudness];
  c.beginPath();
  c.moveTo(0, -size);
  c.lineTo(size, 0);
  c.lineTo(0, size);
  c.lineTo(-size, 0);
  c.closePath();
  c.fillStyle = status === BEING_SENSED ? theme.sensing : loudness === LOUD ? theme.failed : theme.bg;
  c.fill();
  c.lineWidth = [1.2, 1.5, 2.3, 2][loudness];
  c.strokeStyle = status === CANCELLED ? theme.done : status === BEING_SENSED || loudness === LOUD ? theme.bg : theme.task;
  c.stroke();
  return inside(c, status, r, size, loudness);
}

function inside(c, status, r, size, loudness) {
  c.beginPath();
  if (status === RESERVED) c.rect(-1.5, -1.5, 3, 3);
  for (const x of status === HELD ? [-r * 0.28, r * 0.28] : []) {
    c.moveTo(x, -r * 0.45);
    c.lineTo(x, r * 0.45);
  }
  if (status === CANCELLED) {
    c.moveTo(-size * 1.3, 0);
    c.lineTo(size * 1.3, 0);
  }
  c.fillStyle = c.strokeStyle = loudness === LOUD ? theme.bg : status === CANCELLED ? theme.done : theme.task;
  c.lineWidth = 1.4;
  if (status === RESERVED) c.fill();
  else c.stroke();
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
    { id: "loud", mark: '<path d="M6 1 11 6 6 11 1 6Z" class="l-loud"/>', words: say("emergency or late"), shows: (run) => run.timed },
    { id: "expired", mark: '<path d="M2.5 2.5 9.5 9.5M2.5 9.5 9.5 2.5" class="l-done"/>', words: say("expired"), shows: (run) => run.timed },
    { id: "held", mark: '<path d="M6 1 11 6 6 11 1 6ZM5 4v4M7 4v4" class="l-task"/>', words: say("held"), shows: (run) => run.hasOrders },
    { id: "cancelled", mark: '<path d="M6 1 11 6 6 11 1 6ZM0 6H12" class="l-done"/>', words: say("cancelled"), shows: (run) => run.hasOrders },
  ],
  draw(c, { t, r, sites, sprites }) {
    const marks = sites.map(({ task, status, px, py }) => ({ status, px, py, loudness: loudnessOf(task, status, t) }));
    const rank = ({ status, loudness }) => (isOver(status) ? -1 : loudness);
    for (const { status, px, py, loudness } of marks.sort((a, b) => rank(a) - rank(b) || b.status - a.status)) {
      sprites.stamp(c, `task${status} ${loudness} ${r}`, r * 2 + 3, px, py, (s) => mark(s, status, r, loudness));
    }
  },
};
