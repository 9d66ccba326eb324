// What the page says of tasks and directives of a mission, without a browser: node --test missions.test.mjs
import assert from "node:assert/strict";
import { test } from "node:test";
import { forecastAt } from "../../../../tools/report/page/attention.js";
import { figuresAt } from "../../../../tools/report/page/compare.js";
import { directiveWords, directivesAt, directivesOf } from "../../../../tools/report/page/directives.js";
import { orderWords } from "../../../../tools/report/page/orders.js";
import { matcherOf } from "../../../../tools/report/page/tasks.js";
import { SCENARIO, begun } from "./small_run.mjs";

test("of a live mission's tasks those count that have been reported", () => {
  const run = begun({ scenario: { ...SCENARIO, task_times: [[0, null, null, 1, ""], [60000, null, null, 1, ""]] },
    tasks: [[1, 0, [0, 4, 60000, 0]]], done: [0, [0, 0, 90000, 1]], now_ms: 120000 });
  assert.deepEqual([run.tasksKnownAt(30000), run.tasksKnownAt(60000)], [1, 2]);
  assert.deepEqual([figuresAt(run, 30000).tasksTotal, figuresAt(run, 120000).completion], [1, 0.5]);
  assert.equal(forecastAt(run, 30000).total, 1);
});

test("a number that ends what is looked for is whole", () => {
  const rows = [0, 7, 77, 770].map((n) => ({ id: n, who: `uav:${n}, worker:1`, name: `School ${n}+` }));
  const found = (text) => rows.filter(matcherOf(text)).map((row) => row.id);
  assert.deepEqual([found("77"), found("uav:77"), found("task:77"), found("school 7+"), found("SCHOOL"), found(""), found("uav:8")],
    [[77], [77], [77], [7], [0, 7, 77, 770], [0, 7, 77, 770], []]);
});

test("what the commander has decided is known for as long as it is in force", () => {
  const run = begun({ directives: [[60000, 120000, "p1", "chief", "pin", "pin: uav:0 to task 0", 0, -1, -1, 0], [90000, null, "g", "", "go_to", "go to: worker:0 to (1.000, 2.000) km", -1, 0, -1, -1]] });
  const at = (t) => directivesAt(run, t).map(({ order }) => order);
  assert.deepEqual([at(0), at(60000), at(100000), at(120000)], [[], ["p1"], ["p1", "g"], ["g"]]);
  const of = (selected, t) => directivesOf(run, selected, t).map(directiveWords);
  assert.deepEqual(of({ type: "task", id: 0 }, 60000), ["pin: uav:0 to task 0, by chief"]);
  assert.deepEqual(of({ type: "agent", index: run.agentIndex(1, 0) }, 100000), ["go to: worker:0 to (1.000, 2.000) km, by order g"]);
  assert.deepEqual([of({ type: "agent", index: 0 }, 0), of({ type: "charge", id: 0 }, 100000)], [[], []]);
  assert.equal(orderWords({ order: "pin", agents: ["uav:0"], task: 3 }), "let uav:0 do task 3 with the best partner");
});
