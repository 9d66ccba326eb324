import { agentShape, cross } from "../canvas.js";
import { say } from "../language.js";
import { theme } from "../theme.js";
import { FAILED, IDLE, MOVING, UAV, WAITING } from "../words.js";

const TURNS = 32;

/** The way that a UAV flies as one of TURNS directions; up when it stands. */
function turnOf(status, place) {
  if (status !== MOVING || (place.dx === 0 && place.dy === 0)) return TURNS / 4;
  return (Math.round((Math.atan2(place.dy, place.dx) / (2 * Math.PI)) * TURNS) + TURNS) % TURNS;
}

/** Idle ones are hollow, failed ones a cross; a ring while working, a dotted one while waiting. */
function mark(c, kind, status, turn, r) {
  c.beginPath();
  if (status === FAILED) {
    cross(c, 0, 0, r);
    c.strokeStyle = theme.failed;
    c.lineWidth = 2.4;
    c.stroke();
    return;
  }
  const idle = status === IDLE;
  agentShape(c, kind, 0, 0, r, (-turn * 2 * Math.PI) / TURNS);
  c.lineWidth = idle ? 1.5 : 1;
  c.fillStyle = idle ? theme.bg : theme.kinds[kind];
  c.strokeStyle = idle ? theme.kinds[kind] : theme.bg;
  c.fill();
  c.stroke();
  if (idle || status === MOVING) return;
  c.beginPath();
  c.arc(0, 0, r * 2.1, 0, 2 * Math.PI);
  c.strokeStyle = theme.status[status];
  c.lineWidth = 1.8;
  c.setLineDash(status === WAITING ? [2, 3] : []);
  c.stroke();
}

/** Agents: vehicles lowest, UAVs on top. */
export const agents = {
  legend: [
    { mark: '<path d="M6 2 10 10H2Z" class="l-idle"/>', words: say("hollow: idle") },
    { mark: '<circle cx="6" cy="6" r="5" class="l-ring"/><circle cx="6" cy="6" r="2" class="l-dot"/>', words: say("ring: sensing or charging") },
    { mark: '<circle cx="6" cy="6" r="5" class="l-dots"/><circle cx="6" cy="6" r="2" class="l-dot"/>', words: say("dots: waiting") },
    { mark: '<path d="M2 2 10 10M2 10 10 2" class="l-failed"/>', words: say("failed") },
  ],
  draw(c, { near, r, sprites }) {
    for (const kind of [2, 1, 0]) {
      for (const { agent, status, place, px, py } of near) {
        if (agent.kind !== kind) continue;
        const turn = kind === UAV ? turnOf(status, place) : 0;
        sprites.stamp(c, `agent ${kind} ${status} ${turn} ${r}`, r * 2.1 + 3, px, py, (s) => mark(s, kind, status, turn, r));
      }
    }
  },
};
