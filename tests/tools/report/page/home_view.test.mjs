// What part of its area a map opens on, without a browser: node --test home_view.test.mjs
import assert from "node:assert/strict";
import { test } from "node:test";
import { boundsOf, homeView } from "../../../../tools/report/page/home_view.js";
import { linear } from "../../../../tools/report/page/scale.js";
import { WHOLE } from "../../../../tools/report/page/zoom.js";
import { SCENARIO, begun } from "./small_run.mjs";

// 1,000 m by 1,000 m in a map of 500 by 500 pixels without a margin.
const MAP = { x: linear([0, 1000], [0, 500]), y: linear([0, 1000], [500, 0]), width: 500, height: 500, margin: 0 };
const near = { ...SCENARIO, tasks: [400, 500, 50, 600, 600, 60], charging_points: [500, 550, null] };

test("a map opens on tasks, charging points and where agents start", () => {
  assert.deepEqual(boundsOf(begun({ scenario: near })), { west: 400, east: 600, south: 500, north: 600 });
  const { k, left, top } = homeView(begun({ scenario: near }), MAP);
  assert.ok(Math.abs(k - 500 / 115) < 1e-9, "100 pixels wide, and 15 % more");
  assert.deepEqual([left + k * 250, top + k * 225].map(Math.round), [250, 250], "the middle is in the middle");
});

test("it opens on all of the area where that is full, or nothing is there", () => {
  assert.equal(homeView(begun(), MAP), WHOLE);
  const empty = begun({ scenario: { ...SCENARIO, tasks: [], charging_points: [] } });
  assert.equal(boundsOf(empty), null);
  assert.equal(homeView(empty, MAP), WHOLE);
});

test("places that nobody has taken do not count, one place is not shown from too near", () => {
  const run = begun({ scenario: { ...near, task_times: [[0, null, null, 1, ""], [null, null, null, 1, ""]], charging_points: [] } });
  assert.deepEqual(boundsOf(run), { west: 400, east: 400, south: 500, north: 500 });
  assert.equal(homeView(run, MAP).k, 12);
});
