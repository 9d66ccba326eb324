// How near each other UAVs have come that are kept apart: from their legs and altitudes, exactly.
import { isGrounded } from "./air.js";
import { placeAt, statusAt } from "./run.js";
import { rowAt } from "./time.js";
import { MOVING } from "./words.js";

const BUCKET_MS = 60_000;
/** Within so many times the minima the pairs that come nearest are looked for first, and at most. */
const NEAR = 2;
const FAR = 32;
/** The page has places in whole metres and altitudes in tenths: two may seem nearer than they are, by so much. */
const ROUNDED_ACROSS_M = 1.5;
const ROUNDED_UP_M = 0.15;
/** On a live page it is computed again after so long, and after so many times as long as it took. */
const AGAIN_MS = 4000;
const AGAIN_TIMES = 20;
const LEAST_MS = 1000;

/** Until when it is known where an agent is: one that moves on a live page, until it last said so. */
function knownUntil(run, agent) {
  const { stops } = agent;
  const moves = !run.ended && statusAt(agent, run.nowMs) === MOVING;
  return moves ? Math.min(run.nowMs, stops.at(-4)) : run.nowMs;
}

/**
 * Stops with those at which a UAV had waited for its altitude: a leg that began with the wait is flown from its end on. Until then the
 * page's stops have it on its way, as the next one is a tick later.
 */
export function stopsWithWaits(stops, waits) {
  const out = [...stops];
  for (const { from, until } of waits) {
    const i = rowAt(out, 4, until) * 4;
    if (i < 0 || i + 4 >= out.length || out[i] === until || out[i + 4] - until < LEAST_MS) continue;
    const then = placeAt({ stops: out }, from);
    if (then.x === out[i + 1] && then.y === out[i + 2]) out.splice(i + 4, 0, until, out[i + 1], out[i + 2], out[i + 3]);
  }
  return out;
}

/** A UAV in the air, as pieces { t, until, x, y, up, toX, toY, toUp }, over each of which it flies evenly. */
function piecesOf(run, agent) {
  const { spans } = agent;
  const legs = run.altitudes.legs(agent.id);
  if (agent.stops.length === 0 || spans.length === 0 || legs.length === 0) return [];
  const stops = stopsWithWaits(agent.stops, run.altitudes.waits(agent.id));
  const end = knownUntil(run, agent);
  const cuts = new Set([end]);
  for (let i = 0; i < stops.length; i += 4) cuts.add(stops[i]);
  for (let i = 0; i < spans.length; i += 2) cuts.add(spans[i]);
  for (const { t } of legs) cuts.add(t);
  const times = [...cuts].filter((t) => t >= legs[0].t && t <= end).sort((a, b) => a - b);
  const pieces = [];
  let leg = 0;
  for (let i = 1; i < times.length; ++i) {
    const [t, until] = [times[i - 1], times[i]];
    while (leg + 1 < legs.length && legs[leg].until <= t) ++leg;
    const [up, toUp] = [heightOn(legs[leg], t), heightOn(legs[leg], until)];
    if ((up <= 0 && toUp <= 0) || isGrounded(run, agent, t)) continue;
    const [from, to] = [placeAt({ stops }, t), placeAt({ stops }, until)];
    pieces.push({ t, until, x: from.x, y: from.y, up, toX: to.x, toY: to.y, toUp });
  }
  return pieces;
}

function heightOn({ t, until, up, toUp }, at) {
  return up === toUp ? up : up + ((at - t) / (until - t)) * (toUp - up);
}

/** The UAVs that have flown: [{ agent, pieces }]. */
export function flightsOf(run) {
  return run.once("flights", () => run.agents.slice(0, run.scenario.uavs).map((agent) => ({ agent, pieces: piecesOf(run, agent) }))
    .filter(({ pieces }) => pieces.length > 0));
}

/** What a UAV has flown, or will, between two times, by its agent's index: pieces. */
export function flownBetween(run, agent, from, to) {
  const pieces = run.once("pieces by agent", () => new Map(flightsOf(run).map((flight) => [flight.agent.index, flight.pieces]))).get(agent.index) ?? [];
  return pieces.filter(({ t, until }) => until > from && t < to).map((piece) => {
    const [t, until] = [Math.max(piece.t, from), Math.min(piece.until, to)];
    const [a, b] = [pointOf(piece, t), pointOf(piece, until)];
    return { t, until, ...a, toX: b.x, toY: b.y, toUp: b.up };
  });
}

/** The pieces of one UAV by altitude alone: [{ t, until, up, toUp }], a level, a climb or a descent each, whatever way it goes meanwhile. */
export function levelsOf(pieces) {
  const levels = [];
  for (const { t, until, up, toUp } of pieces) {
    const last = levels.at(-1);
    if (last && last.until === t && last.toUp === up && Math.sign(toUp - up) === Math.sign(last.toUp - last.up)) Object.assign(last, { until, toUp });
    else levels.push({ t, until, up, toUp });
  }
  return levels;
}

/** The altitude at t on levels that are told one after the other; null: on the ground. */
export function upOn(levels, t) {
  const level = levels.findLast((one) => one.t <= t);
  if (!level || t > level.until) return null;
  return level.up + ((t - level.t) / (level.until - level.t)) * (level.toUp - level.up);
}

/** What a piece is at a time within it. */
function pointOf(piece, t) {
  const share = (t - piece.t) / (piece.until - piece.t);
  return { x: piece.x + share * (piece.toX - piece.x), y: piece.y + share * (piece.toY - piece.y), up: piece.up + share * (piece.toUp - piece.up) };
}

/** Whether an approach is nearer than another: by its share of the minima, then by both distances together, then earlier. */
function isNearer(a, b) {
  if (Math.abs(a.share - b.share) > 1e-9) return a.share < b.share;
  return Math.abs(a.sum - b.sum) > 1e-9 ? a.sum < b.sum : a.t < b.t;
}

/**
 * Where two pieces come nearest: { t, across, up, share, sum }; null: they are not at the same time. The share is the larger of both
 * distances in shares of their minima. It is least at an end, where one distance is least, or where the two are equal, since both
 * change evenly in between (ClosestAt in model/separation.cc).
 */
export function closestBetween(a, b, { horizontal_m: apart, vertical_m: above }) {
  const from = Math.max(a.t, b.t);
  const length = Math.min(a.until, b.until) - from;
  if (!(length > 0)) return null;
  const [p, q, pTo, qTo] = [pointOf(a, from), pointOf(b, from), pointOf(a, from + length), pointOf(b, from + length)];
  const [x, y, z] = [(p.x - q.x) / apart, (p.y - q.y) / apart, (p.up - q.up) / above];
  const [vx, vy, vz] = [(pTo.x - qTo.x) / apart - x, (pTo.y - qTo.y) / apart - y, (pTo.up - qTo.up) / above - z];
  const tried = [0, 1];
  const c = vx * vx + vy * vy;
  const halfB = x * vx + y * vy;
  if (c > 0) tried.push(-halfB / c);
  if (vz !== 0) tried.push(-z / vz);
  // Where both distances are equal: k u^2 + 2 m u + n = 0.
  const [k, m, n] = [c - vz * vz, halfB - z * vz, x * x + y * y - z * z];
  const inside = m * m - k * n;
  if (k !== 0 && inside >= 0) tried.push((-m - Math.sqrt(inside)) / k, (-m + Math.sqrt(inside)) / k);
  else if (k === 0 && m !== 0) tried.push(-n / (2 * m));
  const best = { t: from, across: 0, up: 0, share: Infinity, sum: Infinity };
  for (const u of tried) {
    const at = Math.min(1, Math.max(0, u));
    const across = Math.sqrt((x + vx * at) ** 2 + (y + vy * at) ** 2); // hypot() is slow
    const up = Math.abs(z + vz * at);
    const one = { t: from + at * length, share: Math.max(across, up), sum: across + up };
    if (isNearer(one, best)) Object.assign(best, one, { across: across * apart, up: up * above });
  }
  return best;
}

/** Pieces cut at whole minutes, by minute, with the boxes around them. */
function bucketsOf(flights) {
  const buckets = new Map();
  flights.forEach(({ pieces }, uav) => {
    for (const piece of pieces) {
      for (let t = piece.t; t < piece.until;) {
        const bucket = Math.floor(t / BUCKET_MS);
        const until = Math.min(piece.until, (bucket + 1) * BUCKET_MS);
        const [from, to] = [pointOf(piece, t), pointOf(piece, until)];
        if (!buckets.has(bucket)) buckets.set(bucket, []);
        buckets.get(bucket).push({ uav, piece: { t, until, ...from, toX: to.x, toY: to.y, toUp: to.up },
          left: Math.min(from.x, to.x), right: Math.max(from.x, to.x), south: Math.min(from.y, to.y), north: Math.max(from.y, to.y),
          low: Math.min(from.up, to.up), high: Math.max(from.up, to.up) });
        t = until;
      }
    }
  });
  for (const bucket of buckets.values()) bucket.sort((a, b) => a.left - b.left);
  return buckets;
}

/** No two are further apart, in shares of the minima. */
function widestOf(flights, { horizontal_m: apart, vertical_m: above }) {
  let [left, right, south, north, high] = [Infinity, -Infinity, Infinity, -Infinity, 0];
  for (const { pieces } of flights) {
    for (const { x, y, up, toX, toY, toUp } of pieces) {
      [left, right] = [Math.min(left, x, toX), Math.max(right, x, toX)];
      [south, north] = [Math.min(south, y, toY), Math.max(north, y, toY)];
      high = Math.max(high, up, toUp);
    }
  }
  return Math.max(Math.hypot(right - left, north - south) / apart, high / above);
}

/** The nearest approach of each pair that comes within `share` of the minima. */
function within(flights, buckets, minima, share) {
  const [reach, above] = [share * minima.horizontal_m, share * minima.vertical_m];
  const found = new Map();
  for (const bucket of buckets.values()) {
    for (let i = 0; i < bucket.length; ++i) {
      const a = bucket[i];
      for (let j = i + 1; j < bucket.length && bucket[j].left <= a.right + reach; ++j) {
        const b = bucket[j];
        if (a.uav === b.uav || b.south > a.north + reach || a.south > b.north + reach || b.low > a.high + above || a.low > b.high + above) continue;
        if (a.piece.t >= b.piece.until || b.piece.t >= a.piece.until) continue;
        const one = closestBetween(a.piece, b.piece, minima);
        if (!one || one.share > share) continue;
        const [low, high] = a.uav < b.uav ? [a.uav, b.uav] : [b.uav, a.uav];
        const key = low * flights.length + high;
        const known = found.get(key);
        if (!known || isNearer(one, known)) found.set(key, { a: flights[low].agent, b: flights[high].agent, ...one });
      }
    }
  }
  return [...found.values()];
}

/**
 * The `most` pairs that come nearest to each other, nearest first, and how many are in conflict: { pairs: [{ a, b, t, across, up,
 * share, conflict }], conflicts }. Pairs further than 32 times the minima are left out, but for the nearest one.
 */
export function nearestApproaches(flights, minima, most) {
  if (flights.length < 2) return { pairs: [], conflicts: 0 };
  const slack = Math.max(ROUNDED_ACROSS_M / minima.horizontal_m, ROUNDED_UP_M / minima.vertical_m);
  const buckets = bucketsOf(flights);
  const widest = widestOf(flights, minima);
  let share = NEAR;
  let pairs = within(flights, buckets, minima, share);
  while (share < widest && (pairs.length === 0 || (pairs.length < most && share < FAR))) {
    share *= 4;
    pairs = within(flights, buckets, minima, share);
  }
  pairs = pairs.map((pair) => ({ ...pair, conflict: pair.share < 1 - slack })).sort((a, b) => (isNearer(a, b) ? -1 : isNearer(b, a) ? 1 : 0));
  return { pairs: pairs.slice(0, most), conflicts: pairs.filter(({ conflict }) => conflict).length };
}

/** The time at which the page shows an approach: just before one of the two has landed, or gone, if it is nearest then. */
export function showingTime(run, { a, b, t }) {
  return isGrounded(run, a, t) || isGrounded(run, b, t) ? t - 1 : t;
}

/** The approaches of a run, computed once for what is known, and on a live page at most every few seconds. */
export class Approaches {
  constructor(most, clock = () => performance.now()) {
    Object.assign(this, { most, clock, run: null, nowMs: -1, next: 0, ended: false });
  }

  /** { flights, pairs, conflicts }: the same object while nothing is new. */
  of(run) {
    const isNew = run !== this.run || run.ended !== this.ended;
    const began = this.clock();
    if (!isNew && (run.nowMs === this.nowMs || began < this.next)) return this.known;
    Object.assign(this, { run, nowMs: run.nowMs, ended: run.ended });
    const flights = flightsOf(run);
    this.known = { flights, ...nearestApproaches(flights, run.scenario.air.separation, this.most) };
    this.next = began + Math.max(AGAIN_MS, AGAIN_TIMES * (this.clock() - began));
    return this.known;
  }
}
