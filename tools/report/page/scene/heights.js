import { rowAt } from "../time.js";
import { MOVING, SENSING, UAV, WAITING } from "../words.js";

/** How high UAVs fly, in the scene's units: for the eye, as a scenario says no height. */
export const AIR = 7;
const SENSING_HEIGHT = 4.2;
const CLIMB_MS = 60_000; // of mission time

const heightOf = (status) => (status === MOVING || status === WAITING ? AIR : status === SENSING ? SENSING_HEIGHT : 0);

/** How high an agent is at t: UAVs fly while they move or wait, stand lower to sense, and are on the ground else. */
export function heightAt(agent, t) {
  if (agent.kind !== UAV) return 0;
  const { spans } = agent;
  const i = rowAt(spans, 2, t);
  if (i < 0) return 0;
  const now = heightOf(spans[2 * i + 1]);
  if (i === 0) return now;
  const share = Math.min(1, (t - spans[2 * i]) / CLIMB_MS);
  const before = heightOf(spans[2 * i - 1]);
  return before + (now - before) * share * share * (3 - 2 * share);
}
