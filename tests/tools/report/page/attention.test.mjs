// What needs attention, by the same tables as the terminal's (tests/tools/top).
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { approachOf, approachText } from "../../../../tools/report/page/air.js";
import { agentsWithAlerts, attentionAt, dueWords, isLoud, timeRisk, troubleOf } from "../../../../tools/report/page/attention.js";
import { alarmsAt } from "../../../../tools/report/page/news.js";
import { Run, decidingMs, faultBands } from "../../../../tools/report/page/run.js";
import { readWords } from "../../../../tools/report/page/words.js";
import { begun } from "./small_run.mjs";

const CLASSES = ["uav", "worker", "vehicle"];
const STATUSES = ["offline", "idle", "moving", "waiting", "sensing", "charging", "failed", "not ready"];
const TASKS = ["open", "reserved", "sensing", "done", "unreported", "expired", "cancelled", "held"];
readWords({ agents: CLASSES, statuses: STATUSES, tasks: TASKS, actions: [], activities: [],
  processes: ["starting", "ready", "running", "degraded", "ended", "deciding"] });

test("the trouble of an agent is that of the terminal", () => {
  const ms = (minutes) => minutes * 60_000;
  const cases = JSON.parse(readFileSync(new URL("../../top/agent_troubles.json", import.meta.url)));
  for (const one of cases) {
    const agent = { kind: CLASSES.indexOf(one.class), range: one.range_km * 1000, fullRange: one.full_km * 1000,
      status: STATUSES.indexOf(one.status) };
    const trouble = troubleOf(agent, ms(one.now_min), () => ms(one.since_min),
      () => (one.nearest_km === undefined ? null : one.nearest_km * 1000));
    assert.equal(trouble?.kind, one.trouble, JSON.stringify(one));
    assert.equal(trouble?.note, one.note, JSON.stringify(one));
    if (trouble) assert.ok(Math.abs(trouble.harm - one.harm) < 1e-9, JSON.stringify(one));
  }
});

test("how close two UAVs come is that of the terminal", () => {
  const cases = JSON.parse(readFileSync(new URL("../../top/approaches.json", import.meta.url)));
  const flying = ([x, y, up, vx, vy]) => ({ x, y, up, vx, vy });
  for (const one of cases) {
    const approach = approachOf(flying(one.a), flying(one.b), { horizontal_m: 50, vertical_m: 10 });
    assert.equal(approach ? approachText(approach) : undefined, one.note, one.what);
    if (approach) assert.ok(Math.abs(approach.inS - one.in_s) < 1e-9 && Math.abs(approach.across - one.across_m) < 1e-9, one.what);
  }
});

test("a measured UAV that comes near another needs attention, one that is computed does not", () => {
  const run = new Run({});
  const uav = (id, stops) => ({ id, index: id, kind: 0, label: `uav:${id}`, stops, spans: [0, STATUSES.indexOf("moving")], fullRange: 1e5 });
  run.agents = [uav(0, [0, 0, 0, 1e5, 60000, 900, 0, 1e5]), uav(1, [0, 3000, 0, 1e5, 60000, 2100, 0, 1e5])];
  const altitudes = { at: () => 40 };
  Object.assign(run, { nowMs: 60000, tickMs: 30000, tasks: [], faults: [], events: [], charging: [], altitudes,
    scenario: { uavs: 2, air: { separation: { horizontal_m: 50, vertical_m: 10 }, measured: [1] } } });
  const found = (t) => attentionAt(run, t).map(({ kind, text, note }) => [kind, text, note]);
  assert.deepEqual(found(60000), [["near", "uav:1 and uav:0", "0 m across and 0 m up from each other in 0:40"]]);
  assert.deepEqual(found(30000), [["near", "uav:1 and uav:0", "0 m across and 0 m up from each other in 1:10"]]);
  run.scenario.air.measured = [];
  assert.deepEqual(found(60000), []);
  run.scenario.air.measured = [0, 1];
  assert.equal(found(60000).length, 1);
});

test("a fault in force and a lost process need attention at the newest time of a live page", () => {
  const run = new Run({});
  run.nowMs = 60000;
  run.tickMs = 30000;
  run.faults = [{ id: "f", kind: "loss", target: "*" }, { id: "k", kind: "process_killed", target: "uav" }];
  const event = (t, kind, fault, detail = "") => ({ t, kind, fault, detail, uav: -1, worker: -1, vehicle: -1 });
  run.events = [event(1000, "fault_applied", "f"), event(2000, "fault_applied", "k"), event(3000, "process_lost", "", "uav is lost")];
  const kinds = () => faultBands(run).filter((band) => band.open).map((band) => [band.kind, band.from]);
  assert.deepEqual(kinds(), [["fault", 1000], ["process", 3000]]);
});

test("the risk of a task is that of the terminal", () => {
  const ms = (minutes) => (minutes === undefined ? null : minutes * 60_000);
  const cases = JSON.parse(readFileSync(new URL("../../top/task_risks.json", import.meta.url)));
  for (const one of cases) {
    const now = { status: TASKS.indexOf(one.status), activity: one.start_min === undefined ? null : { start: ms(one.start_min) } };
    const risk = timeRisk({ intervalMs: ms(one.interval_min) }, { due: ms(one.due_min), expires: ms(one.expires_min) }, now, ms(one.now_min));
    assert.equal(risk?.note, one.note, JSON.stringify(one));
    if (risk) assert.ok(Math.abs(risk.harm - one.harm) < 1e-9, JSON.stringify(one));
  }
});

test("a process that decides says for how long, until it has decided", () => {
  const row = (wallMs, state) => [0, wallMs, 0, 0, 0, 0, 0, 0, 0, state];
  assert.equal(decidingMs([]), 0);
  assert.equal(decidingMs([...row(1000, 2), ...row(2000, 2)]), 0);
  assert.equal(decidingMs([...row(1000, 5), ...row(2000, 2), ...row(3000, 5), ...row(3150, 5), ...row(6200, 5)]), 3200);
  assert.equal(decidingMs([...row(3000, 5), ...row(6200, 5), ...row(6300, 2)]), 0);
});

test("schedulers that disagree need attention from then on, with their newest words", () => {
  const run = new Run({});
  Object.assign(run, { nowMs: 60000, tickMs: 30000, faults: [], agents: [], tasks: [] });
  const event = (t, detail) => ({ t, kind: "decisions_differ", fault: "", detail, uav: -1, worker: -1, vehicle: -1 });
  run.events = [event(0, "decision 0: one"), event(30000, "decision 1: two")];
  const found = (t) => attentionAt(run, t).map(({ kind, text, note }) => [kind, text, note]);
  assert.deepEqual(found(0), [["differ", "once", "decision 0: one"]]);
  assert.deepEqual(found(45000), [["differ", "2 times", "decision 1: two"]]);
});

test("an agent that is not ready: with what its driver waits for by then", () => {
  const run = begun();
  Object.assign(run, { nowMs: 90000, ended: false });
  const [uav, worker] = run.agents;
  uav.spans = [0, 7, 80000, 1];
  worker.spans = [30000, 7];
  const event = (t, detail) => ({ t, kind: "driver_waits", fault: "", detail, uav: 0, worker: -1, vehicle: -1 });
  run.events = [event(0, "a word of its autopilot"), event(60000, "a fix (4 satellites)")];
  const found = (t) => attentionAt(run, t).filter(({ kind }) => kind === "ready").map(({ text, note }) => `${text} ${note}`);
  assert.deepEqual(found(10000), ["uav:0 waits for a word of its autopilot"]);
  assert.deepEqual(found(70000), ["uav:0 waits for a fix (4 satellites)", "worker:0 since 0:00:30"]);
  assert.deepEqual(found(85000), ["worker:0 since 0:00:30"]);
});

test("a call for help stands until its agent says something else, a message for ten minutes", () => {
  const run = begun();
  Object.assign(run, { nowMs: 3000000, ended: false });
  const event = (t, kind, detail, ids = {}) => ({ t, kind, fault: "", detail, uav: -1, worker: -1, vehicle: -1, ...ids });
  run.events = [event(10000, "driver_calls", "trapped", { worker: 0 }), event(20000, "driver_says", "low clouds", { uav: 0 }), event(900000, "driver_says", "all right again", { worker: 0 })];
  const found = (t) => attentionAt(run, t).filter(({ kind }) => ["help", "says"].includes(kind)).map(({ kind, text, note }) => `${kind} ${text} ${note}`);
  assert.deepEqual(found(5000), []);
  assert.deepEqual(found(30000), ["help worker:0 trapped", "says uav:0 low clouds"]);
  assert.deepEqual(found(630000), ["help worker:0 trapped"]);
  assert.deepEqual(found(910000), ["says worker:0 all right again"]);
  assert.deepEqual([...agentsWithAlerts(run, 630000).keys()].map(({ label }) => label), ["worker:0"]);
  assert.ok(alarmsAt(run, 630000).includes("worker:0 calls for help: trapped"));
  assert.deepEqual(alarmsAt(run, 910000), []);
  Object.assign(run, { ended: true });
  assert.deepEqual(found(3000000), [], "it is over");
});

test("a row tells how long its task has, or how late it is", () => {
  const run = { tasks: [{ due: 600000, expires: 1200000, priority: 1 }, { due: null, expires: null, priority: 3 }] };
  const row = (id, kind = "risk") => ({ kind, item: { type: "task", id } });
  assert.deepEqual([0, 900000, 1300000].map((t) => dueWords(run, row(0), t)), ["10 min", "5 min", "12 min late"]);
  assert.equal(dueWords(run, row(1), 0), "");
  assert.equal(dueWords(run, { kind: "failed", item: { type: "agent", index: 0 } }, 0), "");
  assert.deepEqual([isLoud(run, row(0), 0), isLoud(run, row(0), 700000), isLoud(run, row(1), 0)], [false, true, true]);
});
