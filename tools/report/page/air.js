// How high UAVs fly that are kept apart, and which come near each other.
import { placeAt, statusAt } from "./run.js";
import { rowAt } from "./time.js";
import { FAILED, OFFLINE } from "./words.js";

/** The plans of altitudes, by UAV: [{from, knots: [t, metres, ...]}], each until the next. */
export class Altitudes {
  #plans = new Map();

  /** A row: UAV, then times and metres of its plan. */
  take([uav, ...knots]) {
    if (!this.#plans.has(uav)) this.#plans.set(uav, []);
    const plans = this.#plans.get(uav);
    const place = plans.findIndex((plan) => plan.from >= knots[0]);
    const same = place >= 0 && plans[place].from === knots[0];
    plans.splice(place < 0 ? plans.length : place, same ? 1 : 0, { from: knots[0], knots });
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

/** The UAVs that are in the air: {agent, x, y, up}. */
export function inTheAir(run, t) {
  return run.agents.slice(0, run.scenario.uavs).flatMap((agent) => {
    const status = statusAt(agent, t);
    const up = run.altitudes.at(agent.id, t);
    const place = placeAt(agent, t);
    return up > 0 && place && status !== OFFLINE && status !== FAILED ? [{ agent, x: place.x, y: place.y, up }] : [];
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
