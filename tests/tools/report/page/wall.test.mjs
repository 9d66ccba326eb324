// The display for a wall: which figures it has, and what needs attention, one after the other.
import assert from "node:assert/strict";
import { test } from "node:test";
import { attentionAt } from "../../../../tools/report/page/attention.js";
import { readLink, writeLink } from "../../../../tools/report/page/link.js";
import { State } from "../../../../tools/report/page/state.js";
import { Round, wallFigures, wallItems } from "../../../../tools/report/page/wall.js";
import { SCENARIO, begun } from "./small_run.mjs";

const found = (kind, ...texts) => texts.map((text) => ({ kind, text, note: "", item: null }));

/** A round with a clock of its own: shown (what, in turn), wait(ms) lets time pass. */
function roundOf(items) {
  const shown = [];
  const timers = [];
  let now = 0;
  const test = { items, shown, timers, wait(ms) {
    for (const end = now + ms; ;) {
      const next = timers.filter((timer) => timer.at <= end).sort((a, b) => a.at - b.at)[0];
      now = next?.at ?? end;
      if (!next) return;
      timers.splice(timers.indexOf(next), 1);
      next.act();
    }
  } };
  test.round = new Round(() => test.items.map((key) => ({ key })), (item, at, of) => shown.push(item ? `${item.key} ${at + 1}/${of}` : "nothing"), {
    now: () => now,
    set: (act, ms) => {
      const timer = { act, at: now + ms };
      timers.push(timer);
      return timer;
    },
    clear: (timer) => timers.includes(timer) && timers.splice(timers.indexOf(timer), 1) });
  test.round.begin();
  test.round.look();
  return test;
}

test("one after the other, each for eight seconds, and then again", () => {
  const t = roundOf(["a", "b"]);
  assert.deepEqual(t.shown, ["a 1/2"]);
  t.wait(7999);
  t.round.look();
  assert.deepEqual(t.shown, ["a 1/2"]);
  t.wait(1);
  t.wait(8000);
  assert.deepEqual(t.shown, ["a 1/2", "b 2/2", "a 1/2"]);
  t.round.stop();
  t.wait(99999);
  assert.equal(t.shown.length, 3);
});

test("it stops where there is nothing, and goes on when something comes", () => {
  const t = roundOf([]);
  assert.deepEqual([t.shown, t.timers], [["nothing"], []]);
  t.wait(60000);
  t.round.look();
  assert.deepEqual([t.shown, t.timers], [["nothing"], []]);
  t.items = ["a"];
  t.round.look();
  assert.deepEqual(t.shown, ["nothing", "a 1/1"]);
  t.items = [];
  t.wait(3000);
  t.round.look();
  assert.deepEqual([t.shown.at(-1), t.timers], ["nothing", []]);
});

test("what is over is followed by what took its place, after two seconds at the earliest", () => {
  const t = roundOf(["a", "b", "c"]);
  t.items = ["b", "c"];
  t.wait(500);
  for (let i = 0; i < 5; ++i) t.round.look(); // a live page looks often
  assert.deepEqual(t.shown, ["a 1/3"]);
  t.wait(1500);
  assert.deepEqual(t.shown, ["a 1/3", "b 1/2"]);
  t.wait(8000);
  t.items = ["b"];
  t.wait(8000);
  assert.deepEqual(t.shown, ["a 1/3", "b 1/2", "c 2/2", "b 1/1"]);
});

test("what is new and more urgent does not interrupt, and comes in its turn", () => {
  const t = roundOf(["b", "c"]);
  t.items = ["a", "b", "c"];
  t.round.look();
  t.wait(8000);
  t.wait(8000);
  assert.deepEqual(t.shown, ["b 1/2", "c 3/3", "a 1/3"]);
});

test("at most four of a kind, the most harmful kind first, each with how many there are", () => {
  const items = wallItems([...found("risk", "1", "2", "3", "4", "5"), ...found("failed", "uav:0")]);
  assert.deepEqual(items.map(({ key, count }) => [key, count]), [["failed uav:0", 1], ["risk 1", 5], ["risk 2", 5], ["risk 3", 5], ["risk 4", 5]]);
  assert.deepEqual(wallItems(found("log", "nothing heard for 6 s")).map(({ key }) => key), ["log"], "seconds that pass make no other one");
  assert.deepEqual([items[0].mark, items[1].title], ["×", "At risk"]);
});

test("figures: at risk while it runs, not done at the end", () => {
  const run = begun({ scenario: SCENARIO, now_ms: 3600000, ended: true, done: [0, [0, 0, 600000, 1]], tasks: [[0, 0, [0, 0, 600000, 3]]],
    events: [0, [["agent_failed", 700000, 0, -1, -1, -1, -1, "", ""]]],
    report: { tasks_done: 1, tasks_total: 2, completion_rate: 0.5, processes: [], log: { complete: true } } });
  const at = (t) => wallFigures(run, t, attentionAt(run, t));
  assert.deepEqual(at(0), { done: 0, total: 2, failed: 0, isOver: false, risk: 1 });
  assert.deepEqual(at(800000), { done: 1, total: 2, failed: 1, isOver: false, risk: 1 });
  assert.deepEqual(at(3600000), { done: 1, total: 2, failed: 1, isOver: true, risk: 1 });
});

test("the link says whether it is a wall; a page without a run is none", () => {
  assert.deepEqual([readLink("#wall=1").wall, readLink("#wall=0").wall, readLink("").wall], [true, false, false]);
  assert.equal(writeLink({ tMs: null, sel: null, run: 0, look: "map", wall: true }), "#wall=1");
  const state = new State();
  let told = 0;
  state.on("wall", () => ++told);
  state.setWall(true);
  assert.deepEqual([state.wall, told], [false, 0]);
  state.runs = [begun()];
  state.setWall(true);
  state.setWall(true);
  assert.deepEqual([state.wall, told], [true, 1]);
});
