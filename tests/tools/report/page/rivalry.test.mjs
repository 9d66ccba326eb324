// Two runs of a scenario as a story: who won, where, from when on. Runs are small enough to count by hand.
import assert from "node:assert/strict";
import { test } from "node:test";
import { isSameScenario } from "../../../../tools/report/page/compare.js";
import { readLink, writeLink } from "../../../../tools/report/page/link.js";
import { PARTS, doneInOne, readLead, rivalry } from "../../../../tools/report/page/rivalry.js";
import { SCENARIO, begun } from "./small_run.mjs";

const DONE = 3, EXPIRED = 5;
const SENSE = 7, GO_UAV = 3; // kinds of actions
// Tasks 0 and 1 in the south-west, 2 in the centre, 3 in the north-east.
const FOUR = { ...SCENARIO, uavs: 2, range_full_m: [30000, 30000], tasks: [0, 0, 50, 10, 20, 50, 450, 500, 50, 900, 900, 60] };
const MIN = 60000;

const act = (kind, uav, worker, task, weight = 1) => [kind, uav, worker, -1, task, -1, 100, 100, weight];
const decision = (index, t, ...actions) => [index, t, 1, null, 1, 1, "p", actions.flat()];
const report = (more = {}) => ({ scenario: { sha256: "x" }, processes: [], charges: 0, flown_m: 0, ...more });

/** A run in which tasks were done at these times, in minutes; undefined: not. */
function ran(times, more = {}) {
  const at = times.flatMap((min) => (min === undefined ? [] : [min * MIN])).sort((a, b) => a - b);
  return begun({ scenario: FOUR, now_ms: 3600000, ended: true, report: report(), done: [0, [0, 0, ...at.flatMap((t, i) => [t, i + 1])]],
    tasks: times.flatMap((min, id) => (min === undefined ? [] : [[id, 0, [0, 0, min * MIN, DONE]]])), ...more });
}

test("who won, by how much, from when on, and the largest lead", () => {
  const a = ran([10, 40, 20, 50]);
  const b = ran([15, undefined, undefined, 16]);
  const found = rivalry(a, b);
  assert.deepEqual([found.done, found.total, found.byDone, found.better, found.isOpen, found.until], [[4, 2], [4, 4], 0, 0, false, 3600000]);
  // a: 10, 20, 40, 50; b: 15, 16.
  assert.deepEqual(found.lead, { t: [0, 10, 15, 16, 20, 40, 50, 60].map((min) => min * MIN), n: [0, 1, 0, -1, 0, 1, 2, 2] });
  assert.equal(found.since, 40 * MIN);
  assert.deepEqual(found.most, [{ t: 50 * MIN, n: 2 }, { t: 16 * MIN, n: 1 }]);
  assert.deepEqual(found.changes, [{ t: 16 * MIN, of: 1 }, { t: 40 * MIN, of: 0 }]);
  assert.deepEqual(found.took, [30 * MIN, 15.5 * MIN], "means of 10, 20, 40, 50 and of 15, 16");
  const back = rivalry(b, a);
  assert.deepEqual([back.better, back.since, back.most, back.lead.n.at(-1)], [1, 40 * MIN, [{ t: 16 * MIN, n: 1 }, { t: 50 * MIN, n: 2 }], -2], "from the other side");
});

test("a lead that is lost and won again counts from then on; who is level in the end is not ahead", () => {
  assert.deepEqual(readLead({ t: [0, 1, 2, 3, 4], n: [0, 1, 0, 1, 2] }), { changes: [], most: [{ t: 4, n: 2 }, null], since: 3 });
  assert.deepEqual(readLead({ t: [0, 1, 2], n: [0, -3, 0] }), { changes: [], most: [null, { t: 1, n: 3 }], since: null });
  assert.deepEqual(readLead({ t: [0, 1, 2], n: [1, -1, -1] }), { changes: [{ t: 1, of: 1 }], most: [{ t: 0, n: 1 }, { t: 1, n: 1 }], since: 1 });
  assert.deepEqual(readLead({ t: [0], n: [0] }), { changes: [], most: [null, null], since: null });
});

test("where on the map: parts of the box around the tasks, those that differ most first", () => {
  const found = rivalry(ran([10, 20, undefined, undefined]), ran([undefined, undefined, 10, undefined]));
  assert.deepEqual(found.parts.map(({ part, done, more }) => [PARTS[part], done, more]), [["In the south-west", [2, 0], 2], ["In the centre", [0, 1], -1]]);
  assert.deepEqual(found.parts.map(({ since }) => since), [10 * MIN, 10 * MIN]);
  const late = rivalry(ran([30, 20, undefined, undefined]), ran([10, undefined, undefined, undefined]));
  assert.deepEqual(late.parts.map(({ done, since }) => [done, since]), [[[2, 1], 30 * MIN]], "level at 20 min");
  assert.deepEqual(found.parts[0].box, { x: 150, y: 150, wide: 300, high: 300 });
  const line = { ...FOUR, tasks: [500, 0, 50, 500, 900, 50] };
  const on = (times) => ran(times, { scenario: line });
  assert.deepEqual(rivalry(on([undefined, 10]), on([])).parts.map(({ part }) => PARTS[part]), ["In the north"], "tasks on one line are in its middle column");
  const none = () => ran([], { scenario: { ...FOUR, tasks: [] } });
  assert.deepEqual(rivalry(none(), none()).parts, []);
});

test("tasks that one alone did, and why the other one did not", () => {
  const sent = { decisions: [0, [decision(0, 0, act(SENSE, 0, 0, 2))]] };
  const text = "task:1 at (0.90, 0.90) km: not done\n\ndecision   0  0:00:00  outbid: uav:0 and worker:0 could sense it\n";
  const a = ran([10, 30, 20, 40], sent);
  const b = ran([], { ...sent, tasks: [[3, 0, [0, 0, 9 * MIN, EXPIRED]]], reasons: { undone: 4, tasks: [[1, text]] } });
  const [mine, yours] = rivalry(a, b).only.map((list) => list.map(({ task, t, why }) => ({ id: task.id, t, why })));
  assert.deepEqual(yours, []);
  assert.deepEqual(mine, [{ id: 0, t: 10 * MIN, why: "nobody was ever sent" }, { id: 2, t: 20 * MIN, why: "somebody was sent, in vain" },
    { id: 1, t: 30 * MIN, why: "outbid: uav:0 and worker:0 could sense it" }, { id: 3, t: 40 * MIN, why: "expired" }]);
  const important = { scenario: { ...FOUR, task_times: [1, 0, 3, 1].map((priority) => [0, null, null, priority, ""]) } };
  assert.deepEqual(rivalry(ran([10, 30, 20, 40], important), ran([], important)).only[0].map(({ task }) => task.id), [2, 0, 3, 1], "emergencies first");
  const ids = (t) => doneInOne(b, a, t * MIN).map((tasks) => tasks.map(({ id }) => id));
  assert.deepEqual([ids(9), ids(20), ids(60)], [[[], []], [[], [0, 2]], [[], [0, 1, 2, 3]]], "by the chosen time");
});

test("the first decision that commands otherwise: weights do not matter, agents that are sent by one alone do", () => {
  const same = decision(0, 0, act(SENSE, 0, 0, 1, 0.5));
  const with2 = (...decisions) => ran([], { decisions: [0, decisions] });
  const a = with2(same, decision(1, 10 * MIN, act(GO_UAV, 0, -1, 2)), decision(2, 20 * MIN, act(GO_UAV, 1, -1, 2)));
  const b = with2(decision(0, 0, act(SENSE, 0, 0, 1, 0.7)), decision(1, 10 * MIN, act(GO_UAV, 0, -1, 2)), decision(2, 20 * MIN, act(SENSE, 0, 0, 3)));
  const told = (x, y) => {
    const { index, t, agents } = rivalry(x, y).decision;
    return [index, t, agents.map(({ label }) => label)];
  };
  assert.deepEqual(told(a, b), [2, 20 * MIN, ["uav:0", "uav:1", "worker:0"]]);
  assert.deepEqual(told(with2(same), with2(same, decision(1, 10 * MIN, act(GO_UAV, 1, -1, 0)))), [1, 10 * MIN, ["uav:1"]], "one run has no such decision");
});

test("identical runs are alike; equal ones that went otherwise are undecided", () => {
  const same = rivalry(ran([10, 20]), ran([10, 20]));
  assert.deepEqual([same.isAlike, same.better, same.decision, same.only, same.since], [true, null, null, [[], []], null]);
  const equal = rivalry(ran([10, undefined]), ran([undefined, 20]));
  assert.deepEqual([equal.isAlike, equal.better, equal.since, equal.most[0].n], [false, null, null, 1]);
});

test("worth decides between equals, and speaks against more tasks", () => {
  const worth = (worth_done) => ({ report: report({ service: { worth_done } }) });
  const of = (x, y) => {
    const { better, isOpen, byDone, byWorth } = rivalry(x, y);
    return [better, isOpen, byDone, byWorth];
  };
  assert.deepEqual(of(ran([10], worth(3)), ran([10], worth(4))), [1, false, null, 1]);
  assert.deepEqual(of(ran([10, 11], worth(3)), ran([10], worth(4))), [0, true, 0, 1]);
  assert.deepEqual(of(ran([10, 11], worth(4)), ran([10], worth(4))), [0, false, 0, null]);
  assert.equal(rivalry(ran([10]), ran([10], worth(4))).worth, null, "one report does not tell it");
  const timed = { scenario: { ...FOUR, task_times: [[5 * MIN, null, null, 1, ""], ...[1, 2, 3].map(() => [0, null, null, 1, ""])] } };
  assert.deepEqual(rivalry(ran([10], timed), ran([11], timed)).took, [5 * MIN, 6 * MIN], "from the report on");
});

test("a run that goes on is compared up to what is known of it; one that ended stays as it was", () => {
  const short = ran([10, 15], { now_ms: 20 * MIN });
  const long = ran([30, 31, 32]);
  const found = rivalry(short, long);
  assert.deepEqual([found.until, found.ends, found.done, found.lead.n.at(-1)], [60 * MIN, [20 * MIN, 60 * MIN], [2, 3], -1]);
  const going = ran([10, 15], { now_ms: 20 * MIN, ended: false, report: undefined });
  const now = rivalry(going, long);
  assert.deepEqual([now.until, now.ended, now.ends, now.done, now.worth, now.better], [20 * MIN, false, null, [2, 0], null, 0]);
  assert.deepEqual([now.only[0].map(({ task, why }) => [task.id, why]), rivalry(long, going).only[1].length], [[[0, "done later, at 0:30:00"], [1, "done later, at 0:31:00"]], 2]);
  assert.equal(rivalry(going, long), now, "found once");
  going.apply({ now_ms: 35 * MIN, epoch_ms: 0, ended: false, done: [3, [34 * MIN, 3]], tasks: [[2, 0, [0, 0, 34 * MIN, DONE]]] });
  assert.deepEqual([rivalry(going, long).done, rivalry(long, going).until], [[3, 3], 35 * MIN]);
  const behind = rivalry(ran([1]), ran([], { ended: false, report: undefined, now_ms: 5 * MIN }));
  assert.deepEqual(behind.only[0].map(({ why }) => why), ["not yet done"]);
});

test("waiting is counted up to a run's own end", () => {
  const waits = { spans: [[0, 0, [0, 3]]] };
  const { by } = rivalry(ran([], { ...waits, now_ms: 20 * MIN }), ran([], waits));
  assert.deepEqual(by.waitedMs, [20 * MIN, 60 * MIN]);
});

test("runs of other scenarios do not compare", () => {
  const other = ran([10], { report: report({ scenario: { sha256: "y" } }) });
  assert.equal(rivalry(ran([10]), other), null);
  const going = (scenario) => begun({ scenario });
  assert.ok(isSameScenario(ran([10]), going(FOUR)));
  assert.ok(!isSameScenario(ran([10]), going({ ...FOUR, seed: 2 })));
});

test("a link says against which run", () => {
  assert.equal(readLink("#run=1&against=2").against, 2);
  assert.equal(writeLink({ tMs: null, sel: null, run: 1, look: "map", on: "one-run", against: 0 }), "#run=1&on=one-run&against=0");
});

test("4,000 agents, 1,000 tasks, 36 decisions: the one that differs is found, and found once", () => {
  const [n, tasks] = [4000, 1000];
  const scenario = { ...SCENARIO, uavs: n / 2, workers: n / 2, vehicles: 0, range_full_m: Array(n / 2).fill(1),
    tasks: Array.from({ length: tasks }, (_, i) => [i % 37, i % 41, 1]).flat() };
  const made = (shift) => ran(Array.from({ length: tasks }, (_, i) => ((i + shift) % 3 ? 1 + (i % 50) : undefined)), { scenario,
    decisions: [0, Array.from({ length: 36 }, (_, d) => decision(d, d * MIN, ...Array.from({ length: n / 2 }, (_, u) => act(SENSE, u, u, (u + d + (d === 35 ? shift : 0)) % tasks, shift))))],
    spans: Array.from({ length: n }, (_, i) => [i, 0, Array.from({ length: 100 }, (_, s) => [s * 1000, s % 4]).flat()]) });
  const [a, b] = [made(0), made(1)];
  const found = rivalry(a, b);
  assert.equal(found.decision.index, 35);
  assert.equal(rivalry(a, b), found);
});
