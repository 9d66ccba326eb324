// What the page finds by name, without a browser: node --test search.test.mjs
import assert from "node:assert/strict";
import { test } from "node:test";
import { find } from "../../../../tools/report/page/search.js";
import { SCENARIO, begun } from "./small_run.mjs";

const words = (run, text) => find(run, text).map((one) => one.words);

test("agents, tasks and charging points are found by their names", () => {
  const run = begun();
  assert.deepEqual(words(run, "uav:0"), ["uav:0"]);
  assert.deepEqual(words(run, "UAV 0"), ["uav:0"]);
  assert.deepEqual(words(run, "task 1"), ["task 1"]);
  assert.deepEqual(words(run, "0"), ["task 0", "uav:0", "worker:0", "vehicle:0", "charging point 0"]);
  assert.deepEqual(words(run, "charg"), ["charging point 0"]);
  assert.deepEqual(words(run, " "), []);
  assert.deepEqual(words(run, "(*"), []);
  assert.deepEqual(find(run, "vehicle")[0].item, { type: "agent", index: run.agentIndex(2, 0) });
});

test("a number that ends what is looked for is whole, and vacant places are not found", () => {
  const run = begun({ scenario: { ...SCENARIO, uavs: 12, range_full_m: Array(12).fill(30000), vacant: [2, 0, 0] } });
  assert.deepEqual(words(run, "uav:1"), ["uav:1"]);
  assert.deepEqual(words(run, "uav:11"), []);
  assert.equal(words(run, "uav").length, 8, "no more than fit");
});

test("names of tasks are found in any part, the best match first, then places of the base map", () => {
  const run = begun({ scenario: { ...SCENARIO, task_times: [[0, null, null, 1, "Old school, Port"], [0, null, null, 1, "Port 7"]] } });
  run.baseMap = { tiles: new Map([["a", { names: [{ text: "Portail", rank: 2, x: 3, y: 4 }] }], ["b", null], ["c", { names: [{ text: "Portail", rank: 2, x: 3, y: 4 }] }]]) };
  assert.deepEqual(words(run, "port"), ["task 1, Port 7", "Portail", "task 0, Old school, Port"]);
  assert.deepEqual(find(run, "portail"), [{ words: "Portail", place: { x: 3, y: 4 } }]);
  run.baseMap.tiles.set("d", { names: [], streets: [{ text: "Portail Lane", rank: 7, x: 5, y: 6, from: {}, to: {} }] });
  assert.deepEqual(words(run, "portail"), ["Portail", "Portail Lane"]);
  assert.deepEqual(find(run, "lane")[0].place, { x: 5, y: 6 }, "in its middle");
});
