// Which symbols stand together on the map, in numbers; which names stand beside them, and how loud they are.
import assert from "node:assert/strict";
import { test } from "node:test";
import { CHARGING_POINT, OVER, Squares, TO_DO, apart, classOfTask, clusterWords, levelOf, roomIn } from "../../../../tools/report/page/clusters.js";
import { badgeOf, short } from "../../../../tools/report/page/layers/clusters.js";
import { namesInView } from "../../../../tools/report/page/layers/labels.js";
import { HIGH, LOUD, PLAIN, QUIET, loudnessOf } from "../../../../tools/report/page/layers/tasks.js";
import { Present } from "../../../../tools/report/page/present.js";
import { State } from "../../../../tools/report/page/state.js";
import { CANCELLED, DONE, EXPIRED, FAILED, HELD, IDLE, OPEN, UAV, VEHICLE, WORKER } from "../../../../tools/report/page/words.js";
import { SCENARIO, begun } from "./small_run.mjs";

begun(); // from here on classes and statuses have their numbers
const EVERYWHERE = { west: -1e6, east: 1e6, south: -1e6, north: 1e6 };
const at = (x, y, of = UAV) => ({ x, y, of, alone: false });

test("squares are 64 to 128 pixels wide, and hold what has 16 pixels each way", () => {
  for (const perMetre of [0.001, 0.0064, 0.5, 1, 3, 100]) {
    const px = 2 ** levelOf(perMetre) * perMetre;
    assert.ok(px >= 64 && px < 128, `${px} at ${perMetre}`);
  }
  assert.deepEqual([1, 1.5, 1.99].map((perMetre) => roomIn(6, perMetre)), [16, 36, 63]);
});

test("a square's crowd is counted by class, wherever the view is", () => {
  const items = [at(10, 10, UAV), at(20, 30, UAV), at(30, 20, WORKER), at(63, 1, VEHICLE), at(1, 1, TO_DO), at(2, 2, OVER), at(3, 3, CHARGING_POINT), at(64, 10, UAV), at(-1, 10, UAV)];
  const squares = new Squares(items, 6);
  const found = squares.within(EVERYWHERE);
  assert.equal(found.length, 3);
  const [square] = squares.within({ west: 5, east: 6, south: 5, north: 6 });
  assert.equal(squares.within({ west: 5, east: 6, south: 5, north: 6 }).length, 1);
  items[0].urgent = items[2].urgent = true;
  const cluster = squares.clusterOf(square);
  assert.deepEqual(cluster.counts, [2, 1, 1, 1, 1, 1]);
  assert.deepEqual(cluster.box, { west: 1, east: 63, south: 1, north: 30 });
  assert.equal(clusterWords(cluster), "2 UAVs, 1 worker, 1 vehicle, 1 task to do, 1 task over, 1 charging point, 2 alerts");
  assert.equal(squares.clusterOf(found.find((other) => other.crowd.length === 1)).alerts, 0);
  assert.equal(found.find((other) => squares.clusterOf(other).key === cluster.key), square);
});

test("what has no room stands together, what must not be hidden never", () => {
  const items = Array.from({ length: 5 }, (_, i) => at(i, i));
  items[2].alone = true;
  const [square] = new Squares(items, 6).within(EVERYWHERE);
  assert.deepEqual(apart(square, 3), [items[2]]);
  assert.equal(apart(square, 4).length, 5);
});

test("badges lie within their squares, so that none covers another", () => {
  const random = (() => { // seed 7
    let state = 7;
    return () => (state = (state * 48271) % 2147483647) / 2147483647;
  })();
  const squares = new Squares(Array.from({ length: 5000 }, () => at(random() * 1000, random() * 1000, Math.floor(random() * 6))), 7);
  const scales = { x: (m) => m * 0.5 + 3.3, y: (m) => 600 - m * 0.5 };
  const badges = squares.within(EVERYWHERE).map((square) => badgeOf(squares.clusterOf(square), scales));
  assert.ok(badges.length > 50);
  for (const [i, a] of badges.entries()) {
    for (const b of badges.slice(i + 1)) {
      assert.ok(a.left + a.wide <= b.left || b.left + b.wide <= a.left || a.top + a.high <= b.top || b.top + b.high <= a.top, `${JSON.stringify([a, b])}, seed 7`);
    }
  }
  assert.deepEqual([7, 999, 1234, 9960, 48000].map(short), ["7", "999", "1.2k", "10k", "48k"]);
});

test("tasks are to do or over", () => {
  assert.deepEqual([OPEN, HELD, DONE, EXPIRED, CANCELLED].map(classOfTask), [TO_DO, TO_DO, OVER, OVER, OVER]);
});

test("what is selected, agents with alerts and emergencies stand alone", () => {
  const low = SCENARIO.range_full_m[0] * 0.1;
  const run = begun({ scenario: { ...SCENARIO, task_times: [[0, null, null, 3, ""], [0, null, null, 1, ""]] }, now_ms: 600000,
    stops: [[0, 0, [0, 500, 500, low]], [1, 0, [0, 100, 100, 0]], [2, 0, [0, 200, 200, 0]]], spans: [[0, 0, [0, IDLE]], [1, 0, [0, FAILED]], [2, 0, [0, IDLE]]] });
  const state = new State();
  state.runs = [run];
  const present = new Present(state);
  const alone = () => present.squares(6) && present.items.filter((item) => item.alone).map(({ agent, task, point }) => agent?.label ?? (task ? `task:${task.id}` : `charge:${point.id}`));
  assert.equal(present.look(1000), true);
  assert.equal(present.look(1000), false, "nothing has changed");
  assert.equal(present.items.length, 6);
  assert.deepEqual(alone(), ["uav:0", "worker:0", "task:0"]);
  state.select({ type: "agent", index: 2 });
  assert.deepEqual(alone(), ["uav:0", "worker:0", "vehicle:0", "task:0"]);
  state.select({ type: "charge", id: 0 });
  assert.deepEqual(alone(), ["uav:0", "worker:0", "task:0", "charge:0"]);
  run.apply({ version: 1, now_ms: 700000, epoch_ms: 0, ended: false, tasks: [[0, 0, [500, DONE]]] });
  state.emit("data");
  assert.equal(present.look(1000), true);
  assert.deepEqual(alone(), ["uav:0", "worker:0", "charge:0"], "the emergency is over");
  state.toggleLayer({ id: "tasks" });
  present.look(1000);
  assert.ok(!present.items.some(({ task }) => task));
});

test("of a cluster that cannot part, members are selected in turn", () => {
  const run = begun({ now_ms: 600000, stops: [0, 1, 2].map((i) => [i, 0, [0, 5, 5, 30000]]), spans: [0, 1, 2].map((i) => [i, 0, [0, IDLE]]) });
  const state = new State();
  state.runs = [run];
  const present = new Present(state);
  present.look(1000);
  const chosen = [];
  for (let i = 0; i < 4; ++i) {
    const { crowd } = present.squares(6).within({ west: 5, east: 5, south: 5, north: 5 })[0];
    const { agent } = present.after(crowd);
    chosen.push(agent.label);
    state.select({ type: "agent", index: agent.index });
  }
  assert.deepEqual(chosen, ["uav:0", "worker:0", "vehicle:0", "uav:0"]);
});

test("names on the map are short, and those that matter come first", () => {
  const agent = (index, kind, status, more = {}) => ({ agent: { index, id: index, kind }, status, px: 10 * index, py: 0, place: { x: index, y: 0 }, ...more });
  const site = (id, priority, loud) => ({ task: { id, priority }, status: 0, px: 0, py: 50, loud });
  const { statuses } = begun().words;
  const [idle, moving, sensing] = ["idle", "moving", "sensing"].map((name) => statuses.indexOf(name));
  const near = [agent(1, 0, idle), agent(2, 1, moving), agent(3, 2, idle, { urgent: true, loud: true }), agent(4, 0, sensing), agent(5, 1, sensing, { px: 40, place: { x: 4, y: 0 } }), agent(6, 2, idle, { urgent: true, loud: false })];
  const state = { isSelected: ({ index }) => index === 9 };
  const names = (k) => namesInView({ near, sites: [site(17, 3, true), site(18, 1, false)], k, state }).map(({ text }) => text);
  assert.deepEqual(names(1), ["V3", "17", "W2", "U4 W5"]);
  assert.deepEqual(names(2), ["V3", "17", "W2", "U4 W5", "U1", "V6", "18"], "nearer, all");
  assert.deepEqual(namesInView({ near, sites: [], k: 1, state: { isSelected: ({ index }) => index === 2 } }).map(({ text }) => text), ["V3", "U4 W5"],
    "what is selected has its full name");
});

test("emergencies and late tasks are loud, those of low priority quiet, and so is what is over", () => {
  const { tasks } = begun().words;
  const [open, done] = ["open", "done"].map((name) => tasks.indexOf(name));
  const of = (priority, due, status = open) => loudnessOf({ priority, due }, status, 1000);
  assert.deepEqual([of(3, null), of(1, 900), of(1, 1100), of(2, null), of(0, null), of(3, 900, done), of(undefined, undefined)], [LOUD, LOUD, PLAIN, HIGH, QUIET, QUIET, PLAIN]);
});
