// How high UAVs fly that are kept apart, and which come near each other.
import { say } from "./language.js";
import { placeAt, statusAt, velocityAt } from "./run.js";
import { rowAt } from "./time.js";
import { FAILED, IDLE, OFFLINE } from "./words.js";

const AHEAD_S = 120;

/** The plans of altitudes, by UAV: [{from, knots: [t, metres, ...]}], each until the next. */
export class Altitudes {
  #plans = new Map();
  #legs = new Map();
  highest = 0; // of all plans, in metres

  /** A row: UAV, then times and metres of its plan. */
  take([uav, ...knots]) {
    if (!this.#plans.has(uav)) this.#plans.set(uav, []);
    const plans = this.#plans.get(uav);
    const place = plans.findIndex((plan) => plan.from >= knots[0]);
    const same = place >= 0 && plans[place].from === knots[0];
    plans.splice(place < 0 ? plans.length : place, same ? 1 : 0, { from: knots[0], knots });
    this.#legs.delete(uav);
    this.highest = Math.max(this.highest, ...knots.filter((_, i) => i % 2 === 1));
  }

  /** What a UAV climbs, descends and keeps: [{ t, until, up, toUp }], each even; the last one is without end. Nothing: it has no plan. */
  legs(uav) {
    if (!this.#legs.has(uav)) this.#legs.set(uav, this.#legsOf(uav));
    return this.#legs.get(uav);
  }

  /** When a UAV may have waited before it set out, or before it climbed: [{ from, until }]. */
  waits(uav) {
    return (this.#plans.get(uav) ?? []).filter(({ knots: [t, up, until, then] }) => until > t && then === up)
      .map(({ from, knots }) => ({ from, until: knots[2] }));
  }

  #legsOf(uav) {
    const legs = [];
    const plans = this.#plans.get(uav) ?? [];
    plans.forEach(({ knots }, p) => {
      const next = plans[p + 1]?.from ?? Infinity;
      for (let i = 0; i < knots.length && knots[i] < next; i += 2) {
        const [t, up, end = Infinity, then = up] = knots.slice(i, i + 4);
        const until = Math.min(next, end);
        if (until > t) legs.push({ t, until, up, toUp: up === then ? up : up + ((until - t) / (end - t)) * (then - up) });
      }
    });
    return legs;
  }

  /** Metres above the ground; null: it has no plan by then. */
  at(uav, t) {
    const plan = this.#plans.get(uav)?.findLast(({ from }) => from <= t);
    if (!plan) return null;
    const { knots } = plan;
    const i = Math.max(0, rowAt(knots, 2, t)) * 2;
    if (i + 2 >= knots.length) return knots[i + 1];
    return knots[i + 1] + ((t - knots[i]) / (knots[i + 2] - knots[i])) * (knots[i + 3] - knots[i + 1]);
  }
}

const placeKey = (x, y) => `${Math.round(x)} ${Math.round(y)}`;

/** Whether a UAV stands on the ground whatever its plan: offline, failed, or idle at a charging point, where it has landed. */
export function isGrounded(run, agent, t) {
  const status = statusAt(agent, t);
  if (status === OFFLINE || status === FAILED) return true;
  if (status !== IDLE) return false;
  const place = placeAt(agent, t);
  const landing = run.once("landing places", () => new Set(run.charging.map(({ x, y }) => placeKey(x, y))));
  return place !== null && landing.has(placeKey(place.x, place.y));
}

/** Metres above the ground of a UAV; null: it has no plan by then. */
export function altitudeAt(run, agent, t) {
  const up = run.altitudes.at(agent.id, t);
  return up > 0 && isGrounded(run, agent, t) ? 0 : up;
}

/** The UAVs that are in the air: {agent, x, y, up}. */
export function inTheAir(run, t) {
  return run.agents.slice(0, run.scenario.uavs).flatMap((agent) => {
    const up = altitudeAt(run, agent, t);
    const place = up > 0 ? placeAt(agent, t) : null;
    return place ? [{ agent, x: place.x, y: place.y, up }] : [];
  });
}

/** The pairs of them that are nearest, in shares of the minima: {a, b, across, up, share}; below 1 they are too close. */
export function nearestPairs(flying, { horizontal_m, vertical_m }, most) {
  const pairs = [];
  flying.forEach((a, i) => flying.slice(0, i).forEach((b) => {
    const across = Math.hypot(a.x - b.x, a.y - b.y);
    const up = Math.abs(a.up - b.up);
    pairs.push({ a: b.agent, b: a.agent, across, up, share: Math.max(across / horizontal_m, up / vertical_m) });
  }));
  return pairs.sort((a, b) => a.across - b.across || a.up - b.up).slice(0, most);
}

/**
 * How close two UAVs, { x, y, up, vx, vy }, come within two minutes if both fly on as they do now: { inS, across, up }; null: one of
 * the minima is kept. The terminal has the same rule (ApproachOf in tools/top/approach.h).
 */
export function approachOf(a, b, { horizontal_m, vertical_m }) {
  const up = Math.abs(a.up - b.up);
  if (up >= vertical_m) return null;
  const [dx, dy, vx, vy] = [b.x - a.x, b.y - a.y, b.vx - a.vx, b.vy - a.vy];
  const speed2 = vx * vx + vy * vy;
  const inS = speed2 === 0 ? 0 : Math.min(AHEAD_S, Math.max(0, -(dx * vx + dy * vy) / speed2));
  const across = Math.hypot(dx + vx * inS, dy + vy * inS);
  return across < horizontal_m ? { inS, across, up } : null;
}

/** "40 m across and 0 m up from each other in 1:20" */
export function approachText({ inS, across, up }) {
  const seconds = Math.round(inS);
  const far = { across: across.toFixed(0), up: up.toFixed(0), time: `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, "0")}` };
  return say(seconds === 0 ? "{across} m across and {up} m up from each other now" : "{across} m across and {up} m up from each other in {time}", far);
}

/** The pairs of a measured UAV, which may stray, and any other that come too close: [{ a, b, ...approach }]. */
export function comingClose(run, t) {
  const { separation, measured = [] } = run.scenario?.air ?? {};
  if (!separation || measured.length === 0) return [];
  const strays = new Set(measured);
  const flying = inTheAir(run, t).map((one) => ({ ...one, ...velocityAt(one.agent, t) }));
  return flying.filter(({ agent }) => strays.has(agent.id)).flatMap((a) => flying.flatMap((b) => {
    if (a === b || (strays.has(b.agent.id) && b.agent.id < a.agent.id)) return [];
    const approach = approachOf(a, b, separation);
    return approach ? [{ a: a.agent, b: b.agent, ...approach }] : [];
  }));
}
