// How high UAVs fly that are kept apart, and which are near each other. Without a browser.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Altitudes, altitudeAt, inTheAir, nearestPairs } from "../../../../tools/report/page/air.js";
import { begun } from "./small_run.mjs";

test("a UAV's altitude is that of its last plan, and pairs are told by how near they are", () => {
  const altitudes = new Altitudes();
  altitudes.take([3, 0, 0, 5000, 0, 17000, 30]);
  altitudes.take([3, 600000, 30, 620000, 80]);
  assert.deepEqual([5000, 11000, 599999, 610000, 9000000].map((t) => altitudes.at(3, t)), [0, 15, 30, 55, 80]);
  assert.equal(altitudes.at(2, 0), null);
  altitudes.take([3, 600000, 30, 620000, 50]);  // said again
  assert.equal(altitudes.at(3, 9000000), 50);
  const flying = [[0, 0, 30], [30, 40, 40], [30, 0, 35]].map(([x, y, up], id) => ({ agent: { id }, x, y, up }));
  const pairs = nearestPairs(flying, { horizontal_m: 50, vertical_m: 10 }, 2);
  assert.deepEqual(pairs.map(({ a, b, across, up, share }) => [a.id, b.id, across, up, share]), [[0, 2, 30, 5, 0.6], [1, 2, 40, 5, 0.8]]);
});

test("a UAV that is idle at a charging point has landed, whatever its plan", () => {
  const [idle, sensing, failed] = [1, 4, 6];
  const heights = (x, ...spans) => {
    const run = begun({ now_ms: 90000, stops: [[0, 0, [0, x, 500, 30000]]], spans: [[0, 0, spans]], altitudes: [0, [[0, 0, 40]]] });
    assert.deepEqual(inTheAir(run, 60000).length, altitudeAt(run, run.agents[0], 60000) > 0 ? 1 : 0);
    return [30000, 60000].map((t) => altitudeAt(run, run.agents[0], t));
  };
  assert.deepEqual(heights(500, 0, sensing, 50000, idle), [40, 0]);
  assert.deepEqual(heights(510, 0, sensing, 50000, idle), [40, 40], "elsewhere it hovers");
  assert.deepEqual(heights(510, 0, idle, 50000, failed), [40, 0]);
});
