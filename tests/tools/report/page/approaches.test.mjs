// How near UAVs have come that are kept apart, with values computed by hand. Without a browser.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Altitudes, altitudeAt } from "../../../../tools/report/page/air.js";
import { conflictWords } from "../../../../tools/report/page/air_view.js";
import { Approaches, closestBetween, flightsOf, levelsOf, nearestApproaches, showingTime, stopsWithWaits, upOn } from "../../../../tools/report/page/approaches.js";
import { SCENARIO, begun } from "./small_run.mjs";

const [IDLE, MOVING, WAITING, SENSING, FAILED] = [1, 2, 3, 4, 6];
const MINIMA = { horizontal_m: 50, vertical_m: 10 };

/** A run of `uavs`, each { stops: [t, x, y, range, ...], spans, altitudes: [[t, up, ...], ...] }, until t. */
function flown(uavs, until = 100000, more = {}) {
  return begun({ scenario: { ...SCENARIO, uavs: uavs.length, range_full_m: uavs.map(() => 30000), air: { separation: MINIMA, measured: [] } }, now_ms: until, ended: true,
    stops: uavs.map(({ stops }, i) => [i, 0, stops]), spans: uavs.map(({ spans = [0, MOVING] }, i) => [i, 0, spans]),
    altitudes: [0, uavs.flatMap(({ altitudes }, i) => altitudes.map((row) => [i, ...row]))], ...more });
}
const level = (up) => [[0, up]];
const way = (x, y, toX, toY) => [0, x, y, 30000, 100000, toX, toY, 29000];
const east = (y, up) => ({ stops: way(0, y, 1000, y), altitudes: level(up) });
const closest = (...uavs) => nearestApproaches(flightsOf(flown(uavs)), MINIMA, 10);
const near = (actual, expected) => assert.ok(Math.abs(actual - expected) < 1e-6, `${actual}, not ${expected}`);

test("two that cross at one altitude", () => {
  // 10 m/s to the east from (0, 500), and to the north from (600, 0): at t the gap is (600 - 10 t, 10 t - 500), least at t = 55 s: (50, 50).
  const { pairs: [pair], conflicts } = closest(east(500, 40), { stops: way(600, 0, 600, 1000), altitudes: level(40) });
  near(pair.t, 55000);
  near(pair.across, 50 * Math.SQRT2);
  assert.deepEqual([pair.a.id, pair.b.id, pair.up, pair.conflict, conflicts], [0, 1, 0, false, 0]);
  near(pair.share, Math.SQRT2);
  // From (540, 0): (540 - 10 t, 10 t - 500), at 52 s (20, 20).
  const { pairs: [close], conflicts: n } = closest(east(500, 40), { stops: way(540, 0, 540, 1000), altitudes: level(40) });
  near(close.t, 52000);
  near(close.across, 20 * Math.SQRT2);
  assert.deepEqual([close.conflict, n], [true, 1]);
});

test("crossing at another altitude is no conflict, and told where they are above each other", () => {
  const { pairs: [pair], conflicts } = closest(east(500, 40), { stops: way(500, 0, 500, 1000), altitudes: level(50) });
  near(pair.t, 50000);
  near(pair.across, 0);
  assert.deepEqual([pair.up, pair.share, pair.conflict, conflicts], [10, 1, false, 0]);
});

test("side by side, and one behind the other", () => {
  const { pairs: [pair] } = closest(east(500, 40), east(560, 40));
  near(pair.share, 1.2);
  assert.deepEqual([pair.across, pair.up, pair.t, pair.conflict], [60, 0, 0, false]);
  // One that is twice as fast and starts 300 m behind passes 30 m beside the other, after 30 s.
  const { pairs: [passing] } = closest({ stops: way(300, 500, 1300, 500), altitudes: level(40) }, { stops: way(0, 530, 2000, 530), altitudes: level(40) });
  near(passing.t, 30000);
  near(passing.across, 30);
  assert.ok(passing.conflict);
});

test("who is on the ground does not count: before it sets out, idle at a charging point, failed, offline", () => {
  const stands = [0, 500, 500, 30000, 100000, 500, 500, 30000];
  const over = east(500, 40);
  assert.deepEqual(closest(over, { stops: stands, spans: [0, WAITING], altitudes: level(0) }).pairs, []);
  assert.deepEqual(closest(over, { stops: stands, spans: [0, IDLE], altitudes: [] }).pairs, [], "no plan yet");
  for (const status of [IDLE, FAILED, 0]) assert.deepEqual(closest(over, { stops: stands, spans: [0, status], altitudes: level(40) }).pairs, [], `status ${status}`);
  const { pairs: [pair] } = closest(over, { stops: stands, spans: [0, SENSING], altitudes: level(40) });
  assert.deepEqual([pair.t, pair.across, pair.conflict], [50000, 0, true], "one that hovers there does");
  const beside = stands.map((value, i) => (i % 4 === 1 ? 510 : value));
  assert.equal(closest(over, { stops: beside, spans: [0, IDLE], altitudes: level(40) }).conflicts, 1, "idle, but not at the charging point");
});

test("two that are nearest when one lands are shown just before", () => {
  // To the charging point, past one that hovers 60 m beyond it.
  const run = flown([{ stops: [0, 0, 500, 30000, 50000, 500, 500, 29000], spans: [0, MOVING, 50000, IDLE], altitudes: level(40) },
    { stops: [0, 560, 500, 30000], spans: [0, SENSING], altitudes: level(40) }]);
  const { pairs: [pair] } = nearestApproaches(flightsOf(run), MINIMA, 10);
  assert.equal(pair.t, 50000);
  near(pair.across, 60);
  assert.equal(showingTime(run, pair), 49999);
  assert.equal(altitudeAt(run, pair.a, showingTime(run, pair)), 40);
  assert.equal(showingTime(run, { ...pair, t: 30000 }), 30000);
});

test("climbing through another's level", () => {
  // Hovers at 40 m, 24 m beside one that climbs from 0 to 100 m in 40 s: 2.5 m/s, at its level at 16 s.
  const hovers = { stops: [0, 500, 524, 30000, 100000, 500, 524, 30000], spans: [0, SENSING], altitudes: level(40) };
  const climbs = { stops: [0, 500, 500, 30000, 100000, 500, 500, 30000], spans: [0, WAITING], altitudes: [[0, 0, 40000, 100]] };
  const { pairs: [pair], conflicts } = closest(hovers, climbs);
  near(pair.share, 24 / 50);
  near(pair.t, 16000);
  near(pair.up, 0);
  assert.equal(conflicts, 1);
  // Flying away at 10 m/s while it climbs from 20 m to the other's 40 m: the gap in shares of 50 m is t / 5, in shares of 10 m 2 - t / 4.
  const away = { stops: way(500, 524, 1500, 524), altitudes: [[0, 20, 8000, 40]] };
  const { pairs: [equal] } = closest(hovers, away);
  near(equal.t, 1000 * (2 / (1 / 5 + 1 / 4)));
  near(equal.share, 2 / (1 / 5 + 1 / 4) / 5);
  // From 50 m beside it, (30, 40), the gap in shares is 1 + t / 5.
  const { pairs: [beside] } = closest(hovers, { ...away, stops: way(530, 564, 1130, 1364) });
  near(beside.t, 1000 / (1 / 5 + 1 / 4));
  near(beside.share, 1 + 1 / (1 / 5 + 1 / 4) / 5);
  // At 12.5 m/s both change alike, t / 4 and 2 - t / 4: equal at 4 s, 50 m across and 10 m up.
  const { pairs: [alike] } = closest(hovers, { ...away, stops: way(500, 524, 1750, 524) });
  near(alike.t, 4000);
  near(alike.share, 1);
});

test("a new plan ends the old one", () => {
  const altitudes = new Altitudes();
  altitudes.take([0, 0, 0, 40000, 100]);
  altitudes.take([0, 20000, 50, 20000, 50, 30000, 50]);
  assert.deepEqual(altitudes.legs(0), [{ t: 0, until: 20000, up: 0, toUp: 50 }, { t: 20000, until: 30000, up: 50, toUp: 50 }, { t: 30000, until: Infinity, up: 50, toUp: 50 }]);
  altitudes.take([0, 10000, 25, 14000, 35]);
  assert.deepEqual(altitudes.legs(0).slice(0, 3), [{ t: 0, until: 10000, up: 0, toUp: 25 }, { t: 10000, until: 14000, up: 25, toUp: 35 },
    { t: 14000, until: 20000, up: 35, toUp: 35 }]);
  assert.deepEqual(altitudes.legs(1), []);
});

test("one that waits for its altitude sets out when the wait ends", () => {
  const stops = [0, 0, 0, 9, 30000, 250, 0, 8, 100000, 950, 0, 7];
  assert.deepEqual(stopsWithWaits(stops, [{ from: 0, until: 5000 }]), [0, 0, 0, 9, 5000, 0, 0, 9, 30000, 250, 0, 8, 100000, 950, 0, 7]);
  assert.deepEqual(stopsWithWaits(stops, [{ from: 0, until: 30000 }]), stops, "a plan's corner at a stop is no wait");
  assert.deepEqual(stopsWithWaits(stops, [{ from: 0, until: 40000 }]), stops, "it had set out");
  // Of a long wait there are stops at ticks: the leg after the last of them is cut.
  const long = [0, 0, 0, 9, 30000, 0, 0, 9, 60000, 250, 0, 8];
  assert.deepEqual(stopsWithWaits(long, [{ from: 0, until: 45000 }]), [0, 0, 0, 9, 30000, 0, 0, 9, 45000, 0, 0, 9, 60000, 250, 0, 8]);
  assert.deepEqual(stopsWithWaits(long, [{ from: 0, until: 60000 }, { from: 60000, until: 65000 }]), long, "nothing is known after it");
  const altitudes = new Altitudes();
  for (const row of [[0, 0, 0, 5000, 0, 17000, 30], [0, 60000, 30, 60000, 30, 90000, 30]]) altitudes.take(row);
  assert.deepEqual(altitudes.waits(0), [{ from: 0, until: 5000 }]);
});

test("pieces that do not meet in time; ties are told by both distances, then by time", () => {
  const piece = { t: 0, until: 10, x: 0, y: 0, up: 30, toX: 0, toY: 0, toUp: 30 };
  assert.equal(closestBetween(piece, { ...piece, t: 10, until: 20 }, MINIMA), null);
  // 10 m above it passes, never nearer by its share than 1, but nearest across at 5.
  const { t, across, share } = closestBetween(piece, { ...piece, up: 40, toUp: 40, x: -40, toX: 40 }, MINIMA);
  assert.deepEqual([t, across, share], [5, 0, 1]);
});

test("levels, climbs and descents, whatever legs are flown meanwhile", () => {
  const stops = [0, 0, 0, 1, 30000, 300, 0, 1, 60000, 300, 300, 1, 100000, 0, 0, 1];
  const [{ pieces }] = flightsOf(flown([{ stops, altitudes: [[0, 0, 40000, 100], [70000, 100, 90000, 70]] }]));
  assert.deepEqual(pieces.map(({ t }) => t), [0, 30000, 40000, 60000, 70000, 90000]);
  assert.deepEqual(levelsOf(pieces), [{ t: 0, until: 40000, up: 0, toUp: 100 }, { t: 40000, until: 70000, up: 100, toUp: 100 },
    { t: 70000, until: 90000, up: 100, toUp: 70 }, { t: 90000, until: 100000, up: 70, toUp: 70 }]);
  assert.deepEqual([0, 10000, 50000, 80000, 100000, 100001].map((t) => upOn(levelsOf(pieces), t)), [0, 25, 100, 85, 70, null]);
  assert.equal(upOn([{ t: 10, until: 20, up: 30, toUp: 30 }], 5), null);
});

test("how many are in conflict, in words", () => {
  const words = [[0, true], [0, false], [1, true], [3, false]].map(([n, ended]) => conflictWords(n, ended));
  assert.deepEqual(words, ["No conflict", "No conflict so far", "1 pair in conflict", "3 pairs in conflict"]);
});

test("pairs in order, at most so many; those far apart only when there is none nearer", () => {
  const at = (x, up = 40) => ({ stops: [0, x, 0, 1, 100000, x, 0, 1], spans: [0, SENSING], altitudes: level(up) });
  const ids = ({ pairs }) => pairs.map(({ a, b }) => `${a.id}-${b.id}`);
  const all = closest(at(0), at(100), at(160), at(100, 80), at(900000));
  assert.deepEqual(ids(all), ["1-2", "0-1", "0-2", "1-3", "2-3", "0-3"]);
  assert.deepEqual(ids(nearestApproaches(flightsOf(flown([at(0), at(100), at(160)])), MINIMA, 2)), ["1-2", "0-1"]);
  assert.deepEqual(ids(closest(at(0), at(900000))), ["0-1"]);
  assert.deepEqual(closest(), { pairs: [], conflicts: 0 });
  assert.deepEqual(closest(at(0)), { pairs: [], conflicts: 0 });
});

test("found as by trying all pairs, in a crowd", () => {
  let seed = 7;
  const draw = (n) => (seed = (seed * 1103515245 + 12345) % 2 ** 31) % n;
  const uavs = Array.from({ length: 30 }, () => {
    const stops = [];
    for (let t = 0; t <= 600000; t += 60000 + draw(60000)) stops.push(t, draw(2000), draw(2000), 1);
    return { stops, altitudes: [[0, 30, 4000 + draw(90000), 30 + 10 * draw(8)], [200000 + draw(9999), 40, 300000, 30 + 10 * draw(8)]] };
  });
  const flights = flightsOf(flown(uavs, 600000));
  const expected = [];
  flights.forEach((a, i) => flights.slice(i + 1).forEach((b) => {
    const shares = a.pieces.flatMap((p) => b.pieces.flatMap((q) => closestBetween(p, q, MINIMA)?.share ?? []));
    expected.push(Math.min(...shares));
  }));
  expected.sort((a, b) => a - b);
  const { pairs } = nearestApproaches(flights, MINIMA, 10);
  pairs.forEach(({ share }, i) => near(share, expected[i]));
  // And no sample of the flights is nearer than the exact value.
  for (const { a, b, share } of pairs) {
    const [p, q] = [a, b].map((agent) => flights.find((flight) => flight.agent === agent).pieces);
    const on = (pieces, t) => {
      const { t: from, until, ...piece } = pieces.find((one) => t >= one.t && t < one.until);
      const u = (t - from) / (until - from);
      return [piece.x + u * (piece.toX - piece.x), piece.y + u * (piece.toY - piece.y), piece.up + u * (piece.toUp - piece.up)];
    };
    let least = Infinity;
    for (let t = 0; t < 600000; t += 100) {
      const [[x, y, up], [x2, y2, up2]] = [on(p, t), on(q, t)];
      least = Math.min(least, Math.max(Math.hypot(x - x2, y - y2) / 50, Math.abs(up - up2) / 10));
    }
    assert.ok(least >= share - 1e-9 && least < share + 0.05, `${least} of ${share}, ${a.label} ${b.label}`);
  }
});

test("computed once for what is known, and on a live page at most every four seconds", () => {
  let now = 0;
  const approaches = new Approaches(10, () => now);
  const run = flown([east(500, 40), east(560, 40)], 50000, { ended: false });
  const first = approaches.of(run);
  assert.equal(first.pairs.length, 1);
  run.apply({ now_ms: 60000, epoch_ms: 0, ended: false });
  now = 3999;
  assert.equal(approaches.of(run), first);
  now = 4000;
  const second = approaches.of(run);
  assert.notEqual(second, first);
  now = 9000;
  assert.equal(approaches.of(run), second, "nothing is new");
  run.apply({ now_ms: 60000, epoch_ms: 0, ended: true });
  assert.notEqual(approaches.of(run), second, "the mission has ended");
  // One that takes a second is computed every 20 s.
  const slow = new Approaches(10, () => (now += 1000));
  const live = flown([east(500, 40), east(560, 40)], 50000, { ended: false });
  const [begin, known] = [now, slow.of(live)];
  live.apply({ now_ms: 60000, epoch_ms: 0, ended: false });
  while (slow.of(live) === known) assert.ok(now < begin + 30000);
  assert.ok(now >= begin + 21000, `${now - begin}`);
});

test("on a live page, one that moves is known until it last said where it is", () => {
  const uav = { stops: [0, 0, 500, 1, 40000, 400, 500, 1], altitudes: level(40) };
  const end = (status, ended) => flightsOf(flown([{ ...uav, spans: [0, MOVING, 30000, status] }], 60000, { ended }))[0].pieces.at(-1).until;
  assert.deepEqual([end(MOVING, false), end(SENSING, false), end(MOVING, true)], [40000, 60000, 60000]);
});
