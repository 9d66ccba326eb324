import { altitudeAt } from "../air.js";
import { say } from "../language.js";
import { rowAt } from "../time.js";
import { MOVING, SENSING, UAV, WAITING } from "../words.js";

/** How high UAVs fly, in the scene's units: for the eye, where a mission has no altitudes. */
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

const LAYER = 1; // the scene's units between two altitudes, where bodies have their full size: a body is lower
const TALLEST = 25; // of the highest altitude

const rounded = (times) => (times < 10 ? Math.round(times) : times < 100 ? 5 * Math.round(times / 5) : 10 * Math.round(times / 10));

/**
 * How many times as high as they fly UAVs are drawn, so that altitudes which are vertical_m apart can be told apart; null: the mission has no
 * altitudes. `unit`: of a metre of the plane; `lift`: how large bodies are drawn, at most 1.
 */
export function timesAsHigh(run, unit, lift) {
  const minima = run.scenario.air?.separation;
  if (!minima || run.altitudes.highest === 0) return null;
  const perMetre = lift * Math.min(LAYER / minima.vertical_m, TALLEST / run.altitudes.highest);
  return Math.max(1, rounded(perMetre / unit));
}

/** How high an agent is drawn at t: at its altitude, so many times as high as it is, or else as for the eye. */
export function drawnHeight(run, agent, t, { times, unit, lift }) {
  if (agent.kind !== UAV) return 0;
  return times === null ? lift * heightAt(agent, t) : times * unit * (altitudeAt(run, agent, t) ?? 0);
}

/** What the heights of the scene mean, in words. */
export function heightWords(times) {
  if (times === null) return say("Heights and sizes are for the eye.");
  if (times === 1) return say("UAVs are drawn as high above the ground as they fly; sizes are for the eye.");
  return say("UAVs are drawn {n} times as high above the ground as they fly, so that altitudes can be told apart; sizes are for the eye.", { n: times });
}
