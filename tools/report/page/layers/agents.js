import { agentShape, cross } from "../canvas.js";
import { say } from "../language.js";
import { theme } from "../theme.js";
import { FAILED, IDLE, MOVING, UAV, WAITING, WORKER } from "../words.js";
import { pairsOf } from "./pairs.js";

const TURNS = 32;
const BATTERY_STEPS = 12; // of the arc around a UAV
const LOW_STEPS = 2; // of them, and fewer: hardly any range is left
export const PAIR = 2.5; // radii of a symbol: half of the frame of a pair
export const RING = 1.85; // radii of a symbol: the ring around it
const ARC_R = 3.8; // of smaller symbols the arc would be a blot
const DOT_PX = 2;
const [NONE, QUIET, LOUD] = [0, 1, 2]; // alerts

/** The way that a UAV flies as one of TURNS directions; up when it stands. */
function turnOf(status, place) {
  if (status !== MOVING || (place.dx === 0 && place.dy === 0)) return TURNS / 4;
  return (Math.round((Math.atan2(place.dy, place.dx) / (2 * Math.PI)) * TURNS) + TURNS) % TURNS;
}

/** The range that a UAV has left, in steps of a full arc. */
const batteryOf = ({ agent, place }) => Math.max(0, Math.min(BATTERY_STEPS, Math.ceil((BATTERY_STEPS * place.range) / agent.fullRange)));

function body(c, kind, x, r, heading, hollow) {
  c.beginPath();
  agentShape(c, kind, x, 0, r, heading);
  c.lineWidth = hollow ? 1.6 : 2.5;
  c.fillStyle = hollow ? theme.bg : theme.kinds[kind];
  c.strokeStyle = hollow ? theme.kinds[kind] : theme.bg;
  if (hollow) c.fill();
  c.stroke();
  if (!hollow) c.fill();
}

function arc(c, r, share, colour, wide, dash = []) {
  c.beginPath();
  c.arc(0, 0, r, -Math.PI / 2, -Math.PI / 2 + 2 * Math.PI * share);
  c.strokeStyle = colour;
  c.lineWidth = wide;
  c.setLineDash(dash);
  c.stroke();
}

/** An alert that does not stand out. */
export function alertDot(c, x, y) {
  c.beginPath();
  c.arc(x, y, DOT_PX, 0, 2 * Math.PI);
  c.fillStyle = theme.failed;
  c.fill();
}

/** Idle ones are hollow, failed ones a cross; a ring while working, a dotted one while waiting. The ring of a UAV is as long as its range left. */
function mark(c, { kind, status, turn, r, battery, alert }) {
  if (status === FAILED) {
    c.beginPath();
    cross(c, 0, 0, r * 1.1);
    c.strokeStyle = theme.failed;
    c.lineWidth = alert === QUIET ? 1.4 : 3;
    c.stroke();
    return;
  }
  body(c, kind, 0, kind === UAV ? r * 1.05 : r, (-turn * 2 * Math.PI) / TURNS, status === IDLE);
  const works = status !== IDLE && status !== MOVING;
  const ring = r * RING;
  if (alert === LOUD) arc(c, r < ARC_R ? ring : ring + 2.5, 1, theme.failed, r < ARC_R ? 1.3 : 2);
  if (battery !== null) {
    arc(c, ring, 1, theme.line, 1.4);
    arc(c, ring, battery / BATTERY_STEPS, battery <= LOW_STEPS ? theme.failed : works ? theme.status[status] : theme.kinds[kind], 2.2);
  } else if (works) arc(c, ring, 1, theme.status[status], 1.8, status === WAITING ? [2, 3] : []);
  if (alert === QUIET) alertDot(c, ring * 0.75, -ring * 0.75);
}

/** A UAV and who works with it: both in one frame, in the colour of what they do. */
function badge(c, { kind, status, r }) {
  const [wide, high] = [r * 2 * PAIR, r * 3];
  c.beginPath();
  c.roundRect(-wide / 2, -high / 2, wide, high, high / 2);
  c.fillStyle = theme.panel;
  c.fill();
  c.strokeStyle = theme.status[status];
  c.lineWidth = 2;
  c.stroke();
  body(c, UAV, -r * 1.05, r * 0.85, -Math.PI / 2, false);
  body(c, kind, r * 1.15, r * 0.8, 0, false);
}

/** Agents: vehicles lowest, UAVs on top, and of all the pairs that work together. */
export const agents = {
  legend: [
    { mark: '<path d="M6 2 10 10H2Z" class="l-idle"/>', words: say("hollow: idle") },
    { mark: '<circle cx="6" cy="6" r="5" class="l-ring"/><circle cx="6" cy="6" r="2" class="l-dot"/>', words: say("ring: sensing or charging") },
    { mark: '<circle cx="6" cy="6" r="5" class="l-dots"/><circle cx="6" cy="6" r="2" class="l-dot"/>', words: say("dots: waiting") },
    { mark: '<path d="M6 1A5 5 0 1 1 1 6" class="l-idle"/>', words: say("arc: a UAV’s range left") },
    { mark: '<path d="M2 2 10 10M2 10 10 2" class="l-failed"/>', words: say("failed") },
    { mark: '<circle cx="6" cy="6" r="5" class="l-alert"/><circle cx="6" cy="6" r="2" class="l-loud"/>', words: say("red ring or dot: needs attention") },
  ],
  draw(c, { near, r, sprites }) {
    const { pairs, partners } = pairsOf(near);
    const paired = new Set(pairs.map(({ uav }) => uav.agent));
    for (const kind of [2, WORKER, UAV]) {
      for (const item of near) {
        const { agent, status, place, urgent, loud, px, py } = item;
        const alert = loud ? LOUD : urgent ? QUIET : NONE;
        if (agent.kind !== kind || partners.has(agent) || paired.has(agent)) continue;
        const turn = kind === UAV ? turnOf(status, place) : 0;
        const battery = kind === UAV && r >= ARC_R && status !== FAILED ? batteryOf(item) : null;
        sprites.stamp(c, `agent ${kind} ${status} ${turn} ${r} ${battery} ${alert}`, r * 2 + 5, px, py, (s) => mark(s, { kind, status, turn, r, battery, alert }));
      }
    }
    for (const { uav: { status, px, py }, partner: { agent: { kind } } } of pairs) {
      sprites.stamp(c, `pair ${kind} ${status} ${r}`, r * PAIR + 3, px, py, (s) => badge(s, { kind, status, r }));
    }
  },
};
