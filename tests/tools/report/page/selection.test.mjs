// What is selected: one thing, or several.
import assert from "node:assert/strict";
import { test } from "node:test";
import { State } from "../../../../tools/report/page/state.js";

const UAV = { type: "agent", index: 0 }, WORKER = { type: "agent", index: 1 }, TASK = { type: "task", id: 0 }, POINT = { type: "charge", id: 0 };

function selecting(...steps) {
  const state = new State();
  let told = 0;
  state.on("selection", () => ++told);
  for (const [item, more] of steps) state.select(item && { ...item }, more);
  assert.equal(told, steps.length, "each step is told");
  return state;
}

test("one thing is selected instead of another", () => {
  const state = selecting([UAV], [TASK]);
  assert.deepEqual([state.selected, state.others], [TASK, []]);
  assert.deepEqual(selecting([UAV], [null]).allSelected, []);
});

test("more are selected besides, the last one first; nothing changes where there is nothing", () => {
  const state = selecting([UAV, true], [TASK, true], [WORKER, true], [null, true]);
  assert.deepEqual(state.allSelected, [WORKER, TASK, UAV]);
  assert.deepEqual([state.isSelected({ ...UAV }), state.isSelected(POINT)], [true, false], "task 0 is not charging point 0");
});

test("what is selected already is selected no longer; then the one before comes first", () => {
  assert.deepEqual(selecting([UAV], [TASK, true], [UAV, true]).allSelected, [TASK]);
  assert.deepEqual(selecting([UAV], [TASK, true], [TASK, true]).allSelected, [UAV]);
  assert.deepEqual(selecting([UAV], [UAV, true]).allSelected, []);
});

test("one of several leads; alone again, the others are selected no longer, nor in another run", () => {
  const state = selecting([UAV], [TASK, true], [WORKER, true]);
  state.lead(UAV);
  assert.deepEqual(state.allSelected, [UAV, WORKER, TASK]);
  state.select(POINT);
  assert.deepEqual(state.allSelected, [POINT]);
  state.select(UAV, true);
  state.open(1);
  assert.deepEqual(state.allSelected, []);
});
