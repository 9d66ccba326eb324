// The page's logic, without a browser: node --test run.test.mjs
import assert from "node:assert/strict";
import { test } from "node:test";
import { Clock } from "../../../../tools/report/page/clock.js";
import { coastOf, isWater } from "../../../../tools/report/page/coast.js";
import { attentionAt, forecastAt } from "../../../../tools/report/page/attention.js";
import { firstDifference, numbersOf } from "../../../../tools/report/page/compare.js";
import { closuresAt } from "../../../../tools/report/page/layers/roads.js";
import { Orders, orderWords, tokenOf } from "../../../../tools/report/page/orders.js";
import { placeLabels } from "../../../../tools/report/page/map_labels.js";
import { itemOf, nameOf, namesOf, readLink, writeLink } from "../../../../tools/report/page/link.js";
import { tellingMoment } from "../../../../tools/report/page/moment.js";
import { eventRows } from "../../../../tools/report/page/panels.js";
import { degreesOf, placeWords, planeOf } from "../../../../tools/report/page/place.js";
import { reasonAt, shortReason, storyOf } from "../../../../tools/report/page/reasons.js";
import { Run, actionsOf, busOverTime, busyMs, decisionAt, doneAt, faultBands, placeAt, statusAt, taskStatusAt,
} from "../../../../tools/report/page/run.js";
import { nearest } from "../../../../tools/report/page/plot.js";
import { linear, roundTicks } from "../../../../tools/report/page/scale.js";
import { agentNext, agentNow, doneTime, flownAt, taskNow, waitedMs } from "../../../../tools/report/page/story.js";
import { clockText, localWords, rowAt, timeText, timeTicks, wallTime } from "../../../../tools/report/page/time.js";
import { WHOLE, gripped, zoomed } from "../../../../tools/report/page/zoom.js";
import { SCENARIO, begun } from "./small_run.mjs";

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

test("a link says a moment, a selection and a run, and what it has not is null", () => {
  assert.deepEqual(readLink("#t=4800&sel=uav:2"), { tMs: 4800000, sel: "uav:2", run: null, look: null, off: null, on: null, against: null, wall: false, fold: null });
  assert.deepEqual(readLink("#t=-1&run=1&look=nowhere"), { tMs: null, sel: null, run: 1, look: null, off: null, on: null, against: null, wall: false, fold: null });
  assert.equal(readLink("#look=time").look, "time");
  assert.equal(writeLink({ tMs: 4800499, sel: "task:17", run: 0, look: "map" }), "#t=4800&sel=task:17");
  assert.equal(writeLink({ tMs: 0, sel: null, run: 0, look: "scene" }), "#t=0&look=scene");
  assert.equal(writeLink({ tMs: null, sel: null, run: 0, look: "map", off: "roads,tasks" }), "#off=roads,tasks");
  assert.equal(readLink("#off=roads,tasks").off, "roads,tasks");
  assert.equal(writeLink({ tMs: null, sel: null, run: 0, look: "map", off: "roads", on: "coverage" }), "#off=roads&on=coverage");
  assert.equal(readLink("#on=coverage").on, "coverage");
  assert.equal(writeLink({ tMs: null, sel: null, run: 0, look: "map", fold: "legend,tools" }), "#fold=legend,tools");
  assert.equal(readLink("#fold=none").fold, "none");
  const run = begun();
  assert.deepEqual([itemOf(run, "vehicle:0"), itemOf(run, "task:1"), itemOf(run, "charge:0")],
    [{ type: "agent", index: 2 }, { type: "task", id: 1 }, { type: "charge", id: 0 }]);
  assert.deepEqual(["uav:1", "task:2", "car:0", "uav:", null].map((name) => itemOf(run, name)), [null, null, null, null, null]);
  assert.equal(nameOf(run, { type: "agent", index: 2 }), "vehicle:0");
  assert.equal(namesOf({ run, allSelected: [{ type: "agent", index: 2 }, { type: "task", id: 1 }] }), "vehicle:0,task:1");
  assert.equal(namesOf({ run, allSelected: [] }), null);
});

const sensing = (more = {}) => begun({ now_ms: 3600000, ended: true,
  decisions: [0, [[1, 600000, 1, null, 9, 1500, "mpq", [7, 0, 0, -1, 1, -1, 900, 900, 0.5]]]],
  activities: [0, [0, 0, 0, 1, 720000, 900000]],
  stops: [[0, 0, [0, 100, 100, 30000, 600000, 100, 100, 30000, 690000, 900, 900, 29000, 900000, 900, 900, 28940, 3600000, 900, 900, 28940]]],
  spans: [[0, 0, [0, 1, 600000, 2, 690000, 3, 720000, 4, 900000, 1]]],
  tasks: [[1, 0, [600000, 1, 720000, 2, 900000, 3]]], done: [0, [0, 0, 900000, 1]], ...more });

test("an agent's story: where to, with whom, arrival, and what comes next", () => {
  const run = sensing();
  const now = agentNow(run, run.agents[0], 645000);
  assert.deepEqual([now.site.site, now.partner, now.arrival.t, now.arrival.known], [1, "worker:0", 690000, true]);
  assert.deepEqual([now.since, now.until, now.activity.end], [600000, 690000, 900000]);
  const before = agentNow(run, run.agents[0], 300000);
  assert.deepEqual([before.site, before.partner, before.activity], [null, null, null], "what is decided later is not known yet");
  assert.equal(agentNext(run, run.agents[0], before, 300000).command.decision.index, 1);
  assert.equal(agentNow(run, run.agents[0], 1000000).partner, null);
});

test("a live agent's arrival is told by its speed", () => {
  const run = sensing({ now_ms: 630000, ended: false, stops: [[0, 0, [0, 100, 100, 30000, 600000, 100, 100, 30000, 630000, 400, 400, 29600]]] });
  const { arrival } = agentNow(run, run.agents[0], 630000);
  assert.ok(!arrival.known && Math.abs(arrival.t - 680000) < 1, `${arrival.t}`);
});

test("a task's story, and that of one broken off", () => {
  const run = sensing();
  assert.deepEqual([taskNow(run, run.tasks[1], 800000).status, taskNow(run, run.tasks[1], 800000).activity.uav, doneTime(run, run.tasks[1])], [2, 0, 900000]);
  assert.deepEqual([doneTime(run, run.tasks[0]), taskNow(run, run.tasks[0], 0).activity], [null, null]);
  const broken = sensing({ tasks: [[1, 0, [600000, 1, 720000, 2, 800000, 0]]], events: [0, [["sensing_aborted", 790000, 0, 0, -1, 1, -1, "", ""]]] });
  assert.equal(taskNow(broken, broken.tasks[1], 750000).activity.aborted, 790000);
  assert.equal(taskNow(broken, broken.tasks[1], 800000).activity, null);
});

test("metres flown at a time are those of the ways until then", () => {
  const run = sensing();
  const way = Math.hypot(800, 800);
  assert.equal(flownAt(run, 0), 0);
  assert.ok(Math.abs(flownAt(run, 645000) - way / 2) < 0.01 * way);
  assert.ok(Math.abs(flownAt(run, 3600000) - way) < 1e-6);
  assert.equal(waitedMs(run, 700000), 10000);
});

test("attention: failures, then tasks, then waiting, then range, each by its harm", () => {
  const late = sensing({ spans: [[0, 0, [0, 1, 600000, 3]], [1, 0, [0, 1, 700000, 6]]], stops: [[0, 0, [0, 100, 100, 100, 3600000, 100, 100, 100]]],
    tasks: [[1, 0, [600000, 1, 720000, 2, 900000, 3]]] });
  const kinds = (t) => attentionAt(late, t).map((f) => [f.kind, f.text]);
  assert.deepEqual(kinds(650000), [["risk", "task 0"]]);
  assert.deepEqual(kinds(1000000), [["failed", "worker:0"], ["risk", "task 0"], ["wait", "uav:0"]]);
  assert.deepEqual(kinds(3600000)[1], ["undone", "task 0"]);
  assert.deepEqual(attentionAt(late, 300000).map((f) => f.kind), ["stranded", "risk"]);
  assert.equal(attentionAt(sensing({ ended: false }), 3600000, 9000)[0].kind, "log");
});

test("a task is at risk by its due time, its expiry and its priority, and no longer once it begins", () => {
  // [reported, due, expires, priority, name] of the two tasks; task 1 is reserved from minute 10 and begins at minute 12.
  const timed = (first, second, more = {}) => sensing({ ended: false, ...more,
    scenario: { ...SCENARIO, task_times: [[0, null, null, 1, ""], [0, null, null, 1, ""]].map((row, i) => Object.assign([...row], [first, second][i])) } });
  const risks = (run, t) => attentionAt(run, t).filter(({ kind }) => kind === "risk").map(({ text, note }) => `${text}: ${note}`);
  const due = (ms, priority = 1) => [0, ms, null, priority, ""];
  const expires = (ms) => [0, null, ms, 1, ""];
  assert.deepEqual(risks(timed(due(2400000), due(720000)), 660000), [], "in time, and not soon");
  assert.deepEqual(risks(timed(due(null), due(600000)), 660000), ["task 1: starts at 0:12:00, 2 min too late"]);
  assert.deepEqual(risks(timed(due(1800000), due(600000)), 660000), ["task 0: due in 19 min, nobody is on the way", "task 1: starts at 0:12:00, 2 min too late"]);
  assert.deepEqual(risks(timed(due(1800000), due(600000, 3)), 660000), ["task 1, emergency: starts at 0:12:00, 2 min too late", "task 0: due in 19 min, nobody is on the way"]);
  assert.deepEqual(risks(timed(due(600000, 2), due(600000)), 800000), ["task 0, high: was due 3 min ago, nobody is on the way"], "task 1 has begun");
  assert.deepEqual(risks(timed(expires(1500000), expires(710000)), 660000), ["task 1: starts at 0:12:00, expires at 0:11:50", "task 0: expires in 14 min, nobody is on the way"]);
  const held = timed(due(1500000), due(null), { tasks: [[0, 0, [600000, 7]]] });
  assert.deepEqual(risks(held, 900000), ["task 0: due in 10 min, held by an order"]);
  const cancelled = timed(due(1500000), due(null), { tasks: [[0, 0, [600000, 6]], [1, 0, [900000, 3]]], ended: true });
  assert.deepEqual(attentionAt(cancelled, 3600000).filter(({ item }) => item?.type === "task"), []);
});

test("the forecast goes on at the rate so far, and is exact at the end", () => {
  const run = begun({ now_ms: 3600000, done: [0, [0, 0, 1800000, 1]] });
  assert.deepEqual(forecastAt(run, 1800000), { done: 2, total: 2 }); // half of the open one, rounded
  assert.equal(forecastAt(run, 3600000).done, 1);
});

test("the most telling moment is the first failure, else where progress slackens", () => {
  const slack = begun({ now_ms: 3600000, ended: true, done: [0, [0, 0, 600000, 1]] });
  assert.equal(tellingMoment(slack).t, 600000);
  assert.match(tellingMoment(slack).why, /1 of 2 tasks/);
  assert.match(tellingMoment(begun({ now_ms: 9, done: [0, [0, 0]] })).why, /no task was done/);
  const failed = begun({ now_ms: 3600000, events: [0, [["agent_failed", 7, 0, -1, -1, -1, -1, "", ""]]] });
  assert.deepEqual(tellingMoment(failed), { t: 7, why: "the first failure: uav:0 failed" });
});

test("what all processes say of one fault is one row with its kind", () => {
  const event = (kind, t, fault) => [kind, t, -1, -1, -1, -1, -1, fault, ""];
  const run = begun({ faults: [["f", "packet_loss", "*", 10, 20, 0.3]], events: [0, [event("fault_applied", 10, "f"), event("fault_applied", 11, "f"), event("fault_ended", 30, "f")]] });
  assert.deepEqual(eventRows(run).map((row) => [row.t, row.what, row.processes]), [[10, "packet loss applied", 2], [30, "packet loss ended", 1]]);
});

test("degrees and metres of the map's plane agree", () => {
  const run = begun();
  assert.equal(degreesOf(run, { x: 1, y: 1 }), null);
  run.scenario.origin = [18.41, -72.47];
  const [latitude, longitude] = degreesOf(run, { x: 12345, y: 23456 });
  assert.ok(Math.abs(latitude - 18.6218) < 0.001 && Math.abs(longitude + 72.353) < 0.001, `${latitude} ${longitude}`);
  const back = planeOf(run, latitude, longitude);
  // The plane leaves the ground by d²/2R: 55 m at 26 km, and 0.2 m sideways.
  assert.ok(Math.hypot(back.x - 12345, back.y - 23456) < 0.5, JSON.stringify(back));
});

test("orders are told in words, and a token is in the address or is not", () => {
  const words = (order) => orderWords(order);
  assert.equal(words({ order: "task_add", task: { x_km: 12.34, y_km: 4, cost_km: 3, priority: 3, due_min: 90, name: "school" } }),
    "add a task at 12.3, 4.0 km: 3.0 km of range, priority emergency, due 1:30:00, name school");
  assert.equal(words({ order: "task_change", task: 7, priority: 0, expires_min: 61.5 }), "change task 7: priority low, expires 1:01:30");
  assert.deepEqual(["task_cancel", "task_hold", "task_resume"].map((order) => words({ order, task: 7 })), ["cancel task 7", "hold task 7", "resume task 7"]);
  assert.deepEqual(["agent_leave", "agent_recall"].map((order) => words({ order, agent: "uav:3" })), ["let uav:3 leave", "recall uav:3"]);
  assert.equal(words({ order: "road_close", circle_km: [3.25, 4, 0.1], until_in_min: 60, name: "flood" }), "close the roads within 0.10 km of 3.3, 4.0 km for 60 min (flood)");
  assert.equal(words({ order: "road_open", circle_km: [3, 4, 0.1] }), "open the closed roads within 0.10 km of 3.0, 4.0 km");
  assert.deepEqual(["#token=ab&t=5", "#t=5&token=ab", "#t=5", "", "#token="].map(tokenOf), ["ab", "ab", null, null, null]);
});

test("what is closed at a time is what the last change of roads left closed", () => {
  const run = begun();
  assert.deepEqual(closuresAt(run, 0), []);
  const flood = ["c1", "flood", 60000, [3, 4]], fire = ["c2", "", 90000, [5]];
  run.apply({ now_ms: 200000, road_changes: [[60000, [flood]], [90000, [flood, fire]], [120000, []]] });
  assert.deepEqual([59999, 60000, 89999, 90000, 120000].map((t) => closuresAt(run, t)), [[], [flood], [flood], [flood, fire], []]);
});

test("an order is sent with its token and an id of its own, and what became of it is kept", async () => {
  const answers = [[200, { taken: { tick: 3, sim_s: 90, task: 60 } }], [409, { refused: "task 1 is done" }], [400, { error: "no order" }], null, [200, { taken: { tick: 4, sim_s: 120 } }], [403, {}]];
  const asked = [];
  const orders = new Orders("secret", () => {}, async (address, options) => {
    asked.push({ address, ...options, body: JSON.parse(options.body) });
    const answer = answers.shift();
    if (!answer) throw new TypeError("no connection");
    return { status: answer[0], json: async () => answer[1] };
  });
  for (let i = 0; i < 4; ++i) await orders.give({ order: "task_cancel", task: i }, 1000 * i);
  assert.deepEqual(orders.list.map(({ state, note }) => `${state}: ${note}`), ["unanswered: no connection", "refused: no order", "refused: task 1 is done", "taken: taken at 0:01:30"]);
  assert.equal(orders.list[3].task, 60);
  await orders.send(orders.list[0]);
  assert.equal(orders.list[0].state, "taken");
  assert.equal(asked[4].body.id, asked[3].body.id, "once more it is the same order");
  assert.equal(new Set(asked.map(({ body }) => body.id)).size, 4);
  assert.ok(asked.every(({ address, headers }) => address === "/orders" && headers.Authorization === "Bearer secret"));
  assert.ok(orders.allowed);
  await orders.give({ order: "task_hold", task: 1 }, 0);
  assert.ok(!orders.allowed, "who is refused gives no orders any more");
  assert.ok(!new Orders(null, () => {}).allowed);
});

test("an order that waits for its tick is taken back", async () => {
  let decide;
  const tick = new Promise((resolve) => { decide = resolve; });
  const asked = [];
  const orders = new Orders("secret", () => {}, async (_, options) => {
    const body = JSON.parse(options.body);
    asked.push(body);
    if (body.order === "withdraw") return { status: 200, json: async () => ({ taken: { tick: 3, sim_s: 90 } }) };
    return { status: 409, json: () => tick };
  });
  const given = orders.give({ order: "task_hold", task: 1 }, 0);
  const [entry] = orders.list;
  await orders.withdraw(entry);
  assert.deepEqual(asked[1], { id: `${entry.id}-withdraw`, order: "withdraw", withdraws: entry.id });
  assert.equal(entry.state, "pending", "until the mission says so");
  decide({ refused: `withdrawn by order ${entry.id}-withdraw` });
  await given;
  assert.deepEqual([entry.state, orders.list.length], ["withdrawn", 1]);
});

test("tasks and agents that orders bring are known from then on", () => {
  const run = begun({ scenario: { ...SCENARIO, uavs: 2, range_full_m: [30000, 1], vacant: [1, 0, 0],
    task_times: [[0, null, null, 1, ""], [null, null, null, 1, ""]] }, tasks: [[1, 0, [0, 4]]] });
  assert.deepEqual([run.tasksTotal, run.crew, itemOf(run, "task:1"), itemOf(run, "uav:1")], [1, [1, 1, 1], null, null]);
  run.apply({ now_ms: 90000, epoch_ms: 0, ended: false, task_rows: [[1, 300, 400, 70, 60000, 1200000, null, 3, "school"]], agent_rows: [[1, 12000]], tasks: [[1, 1, [60000, 0]]] });
  const { id, x, y, cost, due, priority, name } = run.tasks[1];
  assert.deepEqual([id, x, y, cost, due, priority, name], [1, 300, 400, 70, 1200000, 3, "school"]);
  assert.deepEqual([run.tasksTotal, run.crew, run.agents[1].fullRange, itemOf(run, "uav:1").index], [2, [2, 1, 1], 12000, 1]);
  run.apply({ now_ms: 120000, epoch_ms: 0, ended: false, tasks: [[1, 2, [120000, 6]]] });
  assert.deepEqual([run.tasksTotal, run.hasOrders], [1, true], "what is cancelled is not to be done");
});

test("a coast is rings of differences, and its shore is not the box around it", () => {
  const run = begun({ scenario: { ...SCENARIO, origin: [18.4, -72.4] },
    coast: { source: "made up", box: [1830000, -7250000, 1850000, -7230000], rings: [[1830000, -7250000, 0, 10000, 20000, 0, 0, -10000]] } });
  const { edges, water } = coastOf(run);
  assert.equal(coastOf(run), coastOf(run), "it is found once");
  assert.ok(water && edges.length === 1 && edges[0].length === 4, "one line, upwards along 72.4 W");
  assert.deepEqual([isWater(run, -5000, 100), isWater(run, 5000, 100)], [false, true]);
  const land = begun({ scenario: { ...SCENARIO, origin: [18.4, -72.4] },
    coast: { source: "made up", box: [1830000, -7250000, 1850000, -7230000], rings: [[1830000, -7250000, 0, 20000, 20000, 0, 0, -20000]] } });
  assert.ok(!coastOf(land).water && !isWater(land, 5000, 100));
  assert.ok(!isWater(begun(), 5000, 100) && coastOf(begun()) === null);
});

const STORY = `task:1 at (0.90, 0.90) km takes 0.06 km of range to sense, 0.40 km from there to charge: not done
In horizon's own terms: what a pair is worth to its matching, in tasks (1: done before the next decision).

decision   0  0:00:00  impossible, no UAV is idle or free within 2 decisions (0 under way for longer)
decision   2  0:20:00  outbid: uav:0 and worker:0 could sense it by 0:37:08 (0.611), the best of 4 pairs
                       by:   uav:0 and worker:0 for task:0 by 0:31:29 (0.671)

Of 3 decisions: outbid in 1, impossible in 1.
`;

test("what explain says of a task is told by decision", () => {
  const run = sensing({ tasks: [], reasons: { undone: 2, tasks: [[1, STORY]] },
    decisions: [0, [[0, 0, 1, null, 9, 1, "p", []], [1, 600000, 1, null, 9, 1, "p", []], [2, 1200000, 1, null, 9, 1, "p", []]]] });
  const story = storyOf(run, 1);
  assert.equal(storyOf(run, 0), null);
  assert.deepEqual(story.decisions.map((d) => [d.index, d.lines.length]), [[0, 1], [2, 2]]);
  assert.deepEqual([story.head.length, story.tail], [2, ["Of 3 decisions: outbid in 1, impossible in 1."]]);
  assert.equal(reasonAt(story, decisionAt(run, 1200000)).lines[1], "by:   uav:0 and worker:0 for task:0 by 0:31:29 (0.671)");
  assert.equal(reasonAt(story, decisionAt(run, 700000)).index, 0);
  assert.equal(reasonAt(story, null), null);
  assert.equal(shortReason(story.decisions[1]), "outbid");
  assert.equal(shortReason(story.decisions[0]), "impossible, no UAV is idle or free within 2 …");
  assert.deepEqual(attentionAt(run, 1300000).filter((f) => f.kind === "risk").map((f) => f.note), ["nobody is sent: it will not be done", "outbid"]);
});

test("labels keep apart: another side where one is taken, none where all are", () => {
  const at = (text, px, py) => ({ text, px, py, gap: 5, colour: "" });
  const placed = placeLabels([at("one", 100, 100), at("two", 100, 100), at("far", 300, 100), at("gone", 3000, 100)], () => 30, { width: 400, height: 200 });
  assert.deepEqual(placed.map((label) => label.text), ["one", "two", "far"]);
  const boxes = placed.map(({ left, bottom }) => [left, bottom - 10, left + 30, bottom + 2]);
  for (const [i, a] of boxes.entries()) for (const b of boxes.slice(i + 1)) assert.ok(a[2] < b[0] || b[2] < a[0] || a[3] < b[1] || b[3] < a[1], `${a} ${b}`);
  const crowd = placeLabels(Array.from({ length: 9 }, (_, i) => at(`${i}`, 100, 100)), () => 30, { width: 400, height: 200 });
  assert.equal(crowd.length, 4);
});

test("the wall's time is told where the mission kept step with it", () => {
  const run = new Run();
  run.epochMs = Date.UTC(2026, 0, 31, 9, 30);
  assert.equal(wallTime(run, 60000), null, "nobody has said anything");
  run.processes.set("world", [600000, run.epochMs + 600400, 0, 0, 0, 0, 0, 0, 0, 0]);
  const { text, date } = wallTime(run, 90000);
  assert.match(text, /^09:31:30 UTC, \d\d:\d\d:\d\d here$/);
  assert.equal(date, "2026-01-31");
  run.processes.set("world", [600000, run.epochMs + 10000, 0, 0, 0, 0, 0, 0, 0, 0]);
  assert.equal(wallTime(run, 60000), null, "sixty times as fast");
});

test("local time is that of the scenario's start and offset, at any rate", () => {
  const run = new Run();
  run.scenario = { start: [Date.UTC(2010, 0, 16, 14), -300] };
  assert.equal(timeText(run, 83 * 60000), "1:23:00 (10:23:00 local)");
  assert.equal(localWords(run, 83 * 60000), "10:23:00 UTC-05:00, 15:23:00 UTC");
  assert.deepEqual(wallTime(run, 90000), { text: "09:01:30 UTC-05:00, 14:01:30 UTC", date: "2010-01-16" });
  run.scenario.start = [Date.UTC(2010, 0, 16, 18), 345];
  assert.equal(localWords(run, 0), "23:45:00 UTC+05:45, 18:00:00 UTC");
  assert.equal(localWords(run, 20 * 60000), "00:05:00 +1 d UTC+05:45, 18:20:00 UTC");
  assert.equal(wallTime(run, 20 * 60000).date, "2010-01-17");
  run.scenario.start = [Date.UTC(2010, 0, 16, 18), 0];
  assert.equal(localWords(run, 0), "18:00:00 UTC");
  run.scenario.start = undefined;
  assert.equal(timeText(run, 83 * 60000), "1:23:00");
  assert.equal(localWords(run, 0), "");
});

test("names keep away from what is taken, and places of a small area are told to the metre", () => {
  const label = { text: "one", px: 100, py: 100, gap: 5, colour: "" };
  const place = (taken) => placeLabels([label], () => 30, { width: 400, height: 200 }, taken)[0];
  assert.equal(place([]).left, 105);
  assert.equal(place([{ left: 100, top: 60, wide: 40, high: 80 }]).left, 65);
  assert.equal(place([{ left: 0, top: 60, wide: 400, high: 80 }]), undefined);
  assert.equal(placeWords({ scenario: { width_m: 100, height_m: 100 } }, { x: 12, y: 99 }), "0.012, 0.099 km");
  assert.equal(placeWords({ scenario: { width_m: 30000, height_m: 100 } }, { x: 12, y: 99 }), "0.0, 0.1 km");
});

// attention_test.cc holds `muster top` to the same cases.
