// The page's logic, without a browser: node --test run.test.mjs
import assert from "node:assert/strict";
import { test } from "node:test";
import { Clock } from "../../../../tools/report/page/clock.js";
import { firstDifference, numbersOf } from "../../../../tools/report/page/compare.js";
import { Run, actionsOf, busOverTime, busyMs, decisionAt, doneAt, faultBands, placeAt, statusAt, taskStatusAt,
} from "../../../../tools/report/page/run.js";
import { nearest } from "../../../../tools/report/page/plot.js";
import { linear, roundTicks } from "../../../../tools/report/page/scale.js";
import { clockText, rowAt, timeTicks } from "../../../../tools/report/page/time.js";
import { WHOLE, gripped, zoomed } from "../../../../tools/report/page/zoom.js";

const SCENARIO = {
  name: "two", seed: 1, width_m: 1000, height_m: 1000, interval_ms: 600000, limit_ms: 3600000, tick_ms: 30000,
  uavs: 1, workers: 1, vehicles: 1, tasks: [100, 100, 50, 900, 900, 60], charging_points: [500, 500, null], range_full_m: [30000],
};

const WORDS = {
  agents: ["uav", "worker", "vehicle"], statuses: ["offline", "idle", "moving"], tasks: ["open"],
  actions: ["Ui", "Wj", "Vk", "UiTx", "WjTx", "UiCy", "VkCy", "UiTxWj", "UiCyVk", "go"],
};

function begun(more = {}) {
  const run = new Run();
  run.apply({ version: 1, name: "r", scenario: SCENARIO, words: WORDS, now_ms: 0, epoch_ms: 0, ended: false, ...more });
  return run;
}

test("times are told as people tell them", () => {
  assert.equal(clockText(0), "0:00:00");
  assert.equal(clockText(3 * 3600e3 + 5 * 60e3 + 9999), "3:05:09");
  assert.equal(clockText(65 * 60e3, false), "1:05");
});

test("an axis has round times, and not more than asked for", () => {
  for (const [from, to, most] of [[0, 10800e3, 7], [0, 600e3, 3], [1234567, 9876543, 5], [0, 200 * 3600e3, 6]]) {
    const ticks = timeTicks(from, to, most);
    assert.ok(ticks.length >= 1 && ticks.length <= most + 1, `${ticks}`);
    for (const t of ticks) assert.ok(t >= from && t <= to && t % 60000 === 0);
  }
});

test("the row of a time is found as a plain walk finds it", () => {
  let seed = 7;
  const random = (n) => (seed = (seed * 48271) % 2147483647) % n;
  for (let round = 0; round < 300; ++round) {
    const times = [];
    for (let i = random(12); i > 0; --i) times.push((times.at(-1) ?? 0) + random(3));
    const rows = times.flatMap((t) => [t, 0, 0]);
    const t = random(30) - 2;
    assert.equal(rowAt(rows, 3, t), times.filter((other) => other <= t).length - 1, `${times} at ${t}`);
  }
});

test("an agent is on the straight line between its stops", () => {
  const run = begun({ stops: [[0, 0, [0, 0, 0, 1000, 10000, 300, 400, 500, 20000, 300, 400, 500]]] });
  const at = placeAt(run.agents[0], 5000);
  assert.deepEqual([at.x, at.y, at.range, at.toX, at.toY], [150, 200, 750, 300, 400]);
  assert.equal(placeAt(run.agents[0], -5).x, 0);
  assert.equal(placeAt(run.agents[0], 99999).x, 300);
  assert.equal(placeAt(run.agents[1], 0), null);
});

test("chunks add to a run, and a row said again replaces what was there", () => {
  const run = begun({ spans: [[1, 0, [0, 0, 60000, 1]]], stops: [[1, 0, [0, 1, 1, 0, 60000, 2, 2, 0]]], done: [0, [0, 0]] });
  run.apply({ now_ms: 90000, epoch_ms: 0, ended: false, stops: [[1, 1, [90000, 3, 3, 0]]], spans: [[1, 1, [60000, 1, 70000, 2]]], done: [0, [0, 0, 60000, 1]] });
  assert.deepEqual(run.agents[1].stops, [0, 1, 1, 0, 90000, 3, 3, 0]);
  assert.deepEqual(run.agents[1].spans, [0, 0, 60000, 1, 70000, 2]);
  assert.equal(run.agents[1].label, "worker:0");
  assert.equal(statusAt(run.agents[1], 69999), 1);
  assert.equal(statusAt(run.agents[1], 70000), 2);
  assert.equal(statusAt(run.agents[0], 70000), 0);
  assert.equal(doneAt(run, 59999), 0);
  assert.equal(doneAt(run, 60000), 1);
  assert.equal(run.nowMs, 90000);
});

test("tasks are open until the log says otherwise", () => {
  const run = begun({ tasks: [[1, 0, [30000, 1, 60000, 3]]] });
  assert.deepEqual([0, 30000, 60000].map((t) => taskStatusAt(run.tasks[1], t)), [0, 1, 3]);
  assert.equal(taskStatusAt(run.tasks[0], 60000), 0);
});

test("decisions are in order however they come, each once", () => {
  const row = (index, weight) => [index, index * 600000, weight, null, 9, 1500, "mpq", [7, 0, 0, -1, 1, -1, 900, 900, weight]];
  const run = begun({ decisions: [0, [row(0, 1), row(2, 3)]] });
  run.apply({ now_ms: 0, epoch_ms: 0, ended: false, decisions: [1, [row(2, 4), row(1, 2)]] });
  assert.deepEqual(run.decisions.map((d) => [d.index, d.weight]), [[0, 1], [1, 2], [2, 4]]);
  assert.equal(decisionAt(run, 1199999).index, 1);
  assert.equal(decisionAt(run, -1), null);
  const [action] = actionsOf(run, run.decisions[0]);
  assert.deepEqual([action.symbol, action.uav, action.worker, action.task, action.weight], ["UiTxWj", 0, 0, 1, 1]);
});

test("a decision that never was in force goes when that is known", () => {
  const row = (index) => [index, index * 600000, 1, null, 9, 1500, "mpq", []];
  const run = begun({ decisions: [0, [row(0), row(1), row(2)]] });
  run.apply({ now_ms: 0, epoch_ms: 0, ended: true, report: { skipped_decisions: [1] } });
  assert.deepEqual(run.decisions.map((d) => d.index), [0, 2]);
});

test("bus counters are summed over processes and their starts", () => {
  const sample = (t, start, lost, resent) => [t, 0, start, 0, lost, 0, resent, 0, 0, 2];
  const run = begun({ processes: [["uav", 0, [...sample(0, 0, 0, 0), ...sample(10, 0, 5, 2), ...sample(30, 1, 1, 0)]],
    ["world", 0, [...sample(20, 0, 3, 0)]]] });
  assert.deepEqual(busOverTime(run), { t: [0, 10, 20, 30], lost: [0, 5, 8, 9], rejected: [0, 0, 0, 0], resent: [0, 2, 2, 2] });
});

test("a fault is one band, from the first who felt it to the last", () => {
  const event = (kind, t, fault, detail = "") => [kind, t, -1, -1, -1, -1, -1, fault, detail];
  const run = begun({ now_ms: 1000, faults: [["f", "disk_full", "lcm-logger", 10, 20, 0], ["k", "process_killed", "uav", 40, null, 0]], events: [0, [
    event("fault_applied", 10, "f"), event("fault_applied", 12, "f"), event("fault_ended", 30, "f"), event("fault_ended", 31, "f"),
    event("fault_applied", 40, "k"), event("process_lost", 40, "", "uav was killed"), event("process_back", 55, "", "uav, start 1"),
    event("fault_ended", 1000, "k"), event("process_lost", 900, "", "world ended")]] });
  assert.deepEqual(faultBands(run).map((b) => [b.kind, b.from, b.to]),
    [["fault", 10, 31], ["fault", 40, 40], ["process", 40, 55], ["process", 900, 1000]]);
  assert.equal(faultBands(run)[0].label, "f: disk full lcm-logger");
});

test("a process that launcher and world miss is one band, until the last has it back", () => {
  const event = (kind, t, detail) => [kind, t, -1, -1, -1, -1, -1, "", detail];
  const run = begun({ now_ms: 1000, events: [0, [
    event("process_lost", 55, "scheduler was killed by signal 9"), event("process_lost", 60, "scheduler"),
    event("process_back", 78, "scheduler, start 1"), event("process_back", 80, "scheduler"),
    event("process_lost", 90, "scheduler"), event("process_lost", 95, "uav exited")]] });
  assert.deepEqual(faultBands(run).map((b) => [b.from, b.to]), [[55, 80], [90, 1000], [95, 1000]]);
});

test("busy is moving, waiting, sensing, charging", () => {
  const run = begun({ spans: [[0, 0, [0, 1, 100, 2, 200, 4, 300, 1, 400, 5, 500, 6]]] });
  assert.equal(busyMs(run.agents[0], 1000), 300);
  assert.equal(busyMs(run.agents[0], 450), 250);
});

test("the first difference is that of the actions, not of times or weights of nothing", () => {
  const decision = (index, solve, uav) => [index, 0, 1, null, 9, solve, "p", [7, uav, 0, -1, 1, -1, 9, 9, 1]];
  const report = { scenario: { sha256: "a" } };
  const one = begun({ report, decisions: [0, [decision(0, 5, 0), decision(1, 5, 0)]] });
  const same = begun({ report, decisions: [0, [decision(0, 9, 0), decision(1, 1, 0)]] });
  const other = begun({ report, decisions: [0, [decision(0, 5, 0), decision(1, 5, 2)]] });
  const shorter = begun({ report, decisions: [0, [decision(0, 5, 0)]] });
  const elsewhere = begun({ report: { scenario: { sha256: "b" } } });
  assert.deepEqual([same, other, shorter, elsewhere].map((run) => firstDifference(one, run)),
    ["none", "decision 1", "decision 1", "other scenario"]);
});

test("a run that goes on is told by what is known, one that ended by its report", () => {
  const report = { tasks_done: 2, completion_rate: 1, charges: 3, flown_m: 10, decision_time: { median_s: 1, max_s: 2 }, processes: [], log: { complete: true } };
  const run = begun({ report, done: [0, [0, 1]] });
  assert.deepEqual([numbersOf(run).tasksDone, numbersOf(run).completion], [1, 0.5]);
  run.apply({ now_ms: 9, epoch_ms: 0, ended: true });
  assert.deepEqual([numbersOf(run).tasksDone, numbersOf(run).completion, numbersOf(run).charges], [2, 1, 3]);
});

test("the clock stays within the mission and tells everyone", () => {
  const clock = new Clock();
  clock.max = 100;
  const heard = [];
  clock.subscribe((t) => heard.push(t));
  clock.seek(50);
  clock.seek(-3);
  clock.seek(1000);
  assert.deepEqual(heard, [50, 0, 100]);
  clock.faster(100);
  assert.equal(clock.speed, 3600);
});

test("what a run derives is derived anew when it learns something", () => {
  const event = (kind, t) => [kind, t, 0, -1, -1, -1, -1, "", ""];
  const run = begun({ events: [0, [event("agent_failed", 5)]] });
  assert.equal(faultBands(run).length, 1);
  assert.equal(faultBands(run), faultBands(run));
  run.apply({ now_ms: 9, epoch_ms: 0, ended: false, events: [0, [event("agent_failed", 5), event("agent_failed", 7)]] });
  assert.equal(faultBands(run).length, 2);
});

test("at its newest place an agent looks the way it came", () => {
  const run = begun({ stops: [[0, 0, [0, 0, 0, 9, 10000, 30, 40, 9]]] });
  const { dx, dy, toX } = placeAt(run.agents[0], 20000);
  assert.deepEqual([dx, dy, toX], [30, 40, 30]);
});

test("a scale goes there and back, upside down too", () => {
  const y = linear([0, 200], [80, 0]);
  assert.deepEqual([y(0), y(50), y(200), y.invert(60)], [80, 60, 0, 50]);
});

test("ticks are round numbers, and no more than asked for", () => {
  assert.deepEqual(roundTicks([0, 1000], 4), [0, 250, 500, 750, 1000]);
  assert.deepEqual(roundTicks([0, 1], 3.1), [0, 0.5, 1]);
  assert.deepEqual(roundTicks([0.05, 0.42], 4), [0.1, 0.2, 0.3, 0.4]);
  assert.deepEqual(roundTicks([900, 14100], 6, [1, 2, 5]), [5000, 10000]);
  assert.deepEqual(roundTicks([3, 3], 5), []);
});

test("zooming keeps what is under the pointer, within bounds", () => {
  const view = zoomed(zoomed(WHOLE, 4, 100, 50), 0.5, 300, 20);
  const onScreen = ({ k, left, top }, x, y) => [left + k * x, top + k * y];
  assert.deepEqual(onScreen(zoomed(WHOLE, 4, 100, 50), 100, 50), [100, 50]);
  assert.equal(view.k, 2);
  assert.equal(zoomed(view, 1000, 0, 0).k, 60);
  assert.equal(zoomed(view, 0.001, 0, 0).k, 0.8);
});

test("one finger moves, two zoom by how far apart they are", () => {
  assert.deepEqual(gripped(WHOLE, [{ x: 5, y: 5 }], [{ x: 8, y: 1 }]), { k: 1, left: 3, top: -4 });
  const view = gripped(WHOLE, [{ x: 10, y: 0 }, { x: 20, y: 0 }], [{ x: 10, y: 0 }, { x: 40, y: 0 }]);
  assert.deepEqual([view.k, view.left + 3 * 10, view.left + 3 * 20], [3, 10, 40]);
});

test("the point nearest to the pointer", () => {
  assert.deepEqual([-1, 0, 4, 6, 99].map((x) => nearest([0, 5, 10], x)), [0, 0, 1, 1, 2]);
  assert.equal(nearest([], 1), -1);
});
