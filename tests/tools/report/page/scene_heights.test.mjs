// How high UAVs are drawn in the scene, with values computed by hand. Without a browser.
import assert from "node:assert/strict";
import { test } from "node:test";
import { flownBetween } from "../../../../tools/report/page/approaches.js";
import { AIR, drawnHeight, heightAt, heightWords, timesAsHigh } from "../../../../tools/report/page/scene/heights.js";
import { Plane } from "../../../../tools/report/page/scene/plane.js";
import { SCENARIO, begun } from "./small_run.mjs";

const [IDLE, MOVING, FAILED] = [1, 2, 6];
const UNIT = 100 / 30000; // of the scene for a metre, on a map 30 km wide

/** A UAV that flies 1 km to the east in 100 s, climbing for the first 40 s, in a mission with these altitudes. */
const run = (separation, altitudes = [[0, 0, 0, 40000, 100]], spans = [0, MOVING]) => begun({ scenario: { ...SCENARIO, air: separation ? { separation } : undefined },
  now_ms: 100000, ended: true, stops: [[0, 0, [0, 0, 500, 30000, 100000, 1000, 500, 29000]]], spans: [[0, 0, spans]], altitudes: [0, altitudes] });
const MINIMA = { horizontal_m: 50, vertical_m: 10 };

test("altitudes 10 m apart are a unit of the scene apart, at most 25 units for the highest, never lower than they are", () => {
  assert.equal(new Plane({ width_m: 30000, height_m: 20000 }).unit, UNIT);
  // 10 m are 1/30 of a unit there.
  assert.equal(timesAsHigh(run(MINIMA), UNIT, 1), 30);
  assert.equal(timesAsHigh(run(MINIMA), UNIT, 0.5), 15, "in a crowd, where bodies have half the size");
  assert.equal(timesAsHigh(run({ ...MINIMA, vertical_m: 20 }), UNIT, 1), 15);
  assert.equal(timesAsHigh(run(MINIMA, [[0, 0, 500]]), UNIT, 1), 15, "500 m are 25 units");
  assert.equal(timesAsHigh(run(MINIMA), 100 / 6000, 1), 6, "6 km");
  assert.equal(timesAsHigh(run(MINIMA), 100 / 6500, 1), 7, "6.5, in whole numbers");
  assert.equal(timesAsHigh(run(MINIMA), 100 / 500, 1), 1, "500 m");
  assert.deepEqual([100 / 27000, 100 / 28000, 100 / 123000].map((unit) => timesAsHigh(run(MINIMA), unit, 1)), [25, 30, 120]);
});

test("without altitudes heights are for the eye", () => {
  assert.equal(timesAsHigh(run(null), UNIT, 1), null);
  assert.equal(timesAsHigh(run(MINIMA, []), UNIT, 1), null, "a log that lacks them");
  const plain = run(null);
  assert.equal(heightAt(plain.agents[0], 90000), AIR);
  assert.equal(drawnHeight(plain, plain.agents[0], 90000, { times: null, unit: UNIT, lift: 0.5 }), AIR / 2);
  assert.equal(heightWords(null), "Heights and sizes are for the eye.");
});

test("with altitudes a UAV is drawn at its own: on the ground before its plan, and when it failed", () => {
  const shown = { times: 30, unit: UNIT, lift: 0.5 };
  const heights = (one, ...times) => times.map((t) => Number(drawnHeight(one, one.agents[0], t, shown).toFixed(9)));
  assert.deepEqual(heights(run(MINIMA), 0, 20000, 40000, 90000), [0, 5, 10, 10]); // 2.5 m/s, 0.1 units a metre
  assert.deepEqual(heights(run(MINIMA, [[0, 50000, 40]]), 40000, 60000), [0, 4]);
  assert.deepEqual(heights(run(MINIMA, [[0, 0, 40]], [0, MOVING, 50000, FAILED]), 40000, 60000), [4, 0]);
  const agents = run(MINIMA).agents;
  assert.deepEqual(agents.slice(1).map((agent) => drawnHeight(run(MINIMA), agent, 50000, shown)), [0, 0], "others are on the ground");
});

test("trails and ways ahead are what is flown, climbs included", () => {
  const one = run(MINIMA);
  const [agent] = one.agents;
  assert.deepEqual(flownBetween(one, agent, 20000, 70000), [{ t: 20000, until: 40000, x: 200, y: 500, up: 50, toX: 400, toY: 500, toUp: 100 },
    { t: 40000, until: 70000, x: 400, y: 500, up: 100, toX: 700, toY: 500, toUp: 100 }]);
  assert.deepEqual(flownBetween(one, agent, -Infinity, 0), []);
  assert.deepEqual(flownBetween(one, agent, 100000, 200000), []);
  const landed = run(MINIMA, [[0, 0, 40]], [0, MOVING, 50000, FAILED, 80000, IDLE]);
  assert.deepEqual(flownBetween(landed, landed.agents[0], 0, 80000).map(({ t, until }) => [t, until]), [[0, 50000]]);
});

test("what the heights mean is said in words", () => {
  assert.match(heightWords(30), /^UAVs are drawn 30 times as high above the ground as they fly/);
  assert.match(heightWords(1), /^UAVs are drawn as high above the ground as they fly/);
});
