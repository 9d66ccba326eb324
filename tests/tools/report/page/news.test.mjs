// What a live page says at once, without a browser: node --test news.test.mjs
import assert from "node:assert/strict";
import { test } from "node:test";
import { alarmsAt, newsWords } from "../../../../tools/report/page/news.js";
import { SCENARIO, begun } from "./small_run.mjs";

test("emergencies that are reported and agents that have failed are alarms", () => {
  const run = begun({ scenario: { ...SCENARIO, task_times: [[0, null, null, 1, ""], [60000, null, null, 3, "School"]] },
    tasks: [[1, 0, [0, 4, 60000, 0]]], spans: [[1, 0, [0, 1, 90000, 6, 150000, 1]]], now_ms: 200000 });
  assert.deepEqual(alarmsAt(run, 59999), []);
  assert.deepEqual(alarmsAt(run, 60000), ["task 1, School: emergency"]);
  assert.deepEqual(alarmsAt(run, 90000), ["task 1, School: emergency", "worker:0 has failed"]);
  assert.deepEqual(alarmsAt(run, 150000), ["task 1, School: emergency"]);
});

test("of much that is new some is named", () => {
  assert.equal(newsWords(["a", "b"]), "a; b");
  assert.equal(newsWords(["a", "b", "c", "d", "e"]), "a; b; c; and 2 more");
});
