// What part of its area a map opens on, and what floats on it, without a browser: node --test home_view.test.mjs
import assert from "node:assert/strict";
import { test } from "node:test";
import { foldIds, foldText } from "../../../../tools/report/page/folding.js";
import { freeWithin } from "../../../../tools/report/page/free_part.js";
import { boundsOf, homeView, wholeView } from "../../../../tools/report/page/home_view.js";
import { linear } from "../../../../tools/report/page/scale.js";
import { nearestHeight } from "../../../../tools/report/page/sheet.js";
import { aheadText } from "../../../../tools/report/page/transport.js";
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

test("what floats on the map covers none of what it opens on, nor of the whole area", () => {
  const free = { left: 200, top: 50, right: 0, bottom: 30 };
  const run = begun({ scenario: near });
  for (const [of, box] of [[homeView, [400, 600, 500, 600]], [wholeView, [0, 1000, 0, 1000]]]) {
    const { k, left, top } = of(run, { ...MAP, free });
    const [west, east, south, north] = box;
    const [x0, x1, y0, y1] = [left + k * MAP.x(west), left + k * MAP.x(east), top + k * MAP.y(north), top + k * MAP.y(south)];
    assert.ok(x0 >= 200 - 1e-9 && x1 <= 500 + 1e-9 && y0 >= 50 - 1e-9 && y1 <= 470 + 1e-9, `${[x0, x1, y0, y1]}`);
  }
});

test("on a desktop panels cover the left, above and below, on a phone the sheet covers below", () => {
  const map = { left: 0, top: 48, right: 1000, bottom: 848, height: 800 };
  const covers = { side: { right: 340, top: 58 }, tools: { bottom: 90 }, legend: { top: 800 } };
  assert.deepEqual(freeWithin(map, covers, false), { left: 340, top: 42, right: 0, bottom: 48 });
  assert.deepEqual(freeWithin(map, { ...covers, side: null }, false), { left: 0, top: 42, right: 0, bottom: 48 });
  assert.deepEqual(freeWithin(map, { ...covers, side: { top: 748 } }, true), { left: 0, top: 42, right: 0, bottom: 100 });
  assert.equal(freeWithin(map, covers, true).bottom, 480, "of a full sheet not all");
});

test("zones belong to what a map opens on, as far as they are in the area", () => {
  const run = begun({ scenario: near });
  run.roadChanges = [[0, [["z", "", 0, 0, [[300, 450, 700, 450, 700, 1400]]]]]];
  assert.deepEqual(boundsOf(run), { west: 300, east: 700, south: 450, north: 1000 });
});

test("how far the present is ahead, what is folded, and where a sheet comes to rest", () => {
  assert.deepEqual([aheadText(12000), aheadText(12 * 60000)], ["+12 s", "+12 min"]);
  assert.equal(foldText(new Set(["tools", "attention"]), new Set()), "attention,tools");
  assert.deepEqual([foldText(new Set(), new Set()), foldText(new Set(["legend"]), new Set(["legend"])), foldText(new Set(), new Set(["legend"]))], [null, null, "none"]);
  assert.deepEqual(foldIds("legend,nothing,card"), ["legend", "card"]);
  assert.deepEqual([90, 230, 500].map((px) => nearestHeight([100, 350, 700], px)), ["peek", "half", "half"]);
});
