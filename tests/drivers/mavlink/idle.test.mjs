// A UAV with nothing to do: it lands at home, and takes off again when it is sent somewhere.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Box, START } from "./box.mjs";

const GOAL = { x_m: 1500, y_m: 400 };

/** It has sensed at a place a kilometre from home, and is told nothing more. */
function idle(settings) {
  const box = new Box({ options: { confirm: "a file" }, ...settings }).ready();
  const there = box.goTo(GOAL.x_m, GOAL.y_m, "sense");
  box.until(() => box.said("arrived", there).length, 300);
  const sense = box.order("sense", 30);
  box.until(() => box.said("done", sense).length, 60);
  return box;
}

function isUpAt(box, place) {
  return box.copter.armed && box.copter.at.up > 50 && box.distanceTo(place) < 5;
}

for (const kind of ["ardupilot", "px4"]) {
  test(`${kind}: lands at home after two minutes, and takes off again without a word of its battery`, () => {
    const box = idle({ kind, drain_percent_s: 0.05 });
    box.run(118);
    assert.ok(isUpAt(box, GOAL), "not before");
    const took = box.landed();
    assert.ok(took < 200, `${took} s`);
    assert.ok(box.distanceTo(START) < 3);
    assert.equal(box.copter.mode, "LAND");
    const { battery_percent } = box.copter;
    box.run(600);
    assert.equal(box.copter.battery_percent, battery_percent, "its motors stay off");
    const { at } = box.said("state").at(-1);
    assert.ok(box.distanceTo(at) < 1, "the mission knows where it is");

    const next = box.goTo(GOAL.x_m, GOAL.y_m, "sense");
    box.until(() => box.said("arrived", next).length, 300);
    assert.ok(isUpAt(box, GOAL));
    box.tell({ type: "bye", reason: "it is over" });
    box.until(() => box.driver.exitCode !== null, 900);
    assert.equal(box.failure, null);
  });

  test(`${kind}: sent somewhere on its way home it goes there at once`, () => {
    const box = idle({ kind });
    box.until(() => box.place.x_m < 1200, 200, "on its way home");
    const next = box.goTo(GOAL.x_m, GOAL.y_m);
    box.until(() => box.said("arrived", next).length, 60);
    assert.ok(!box.copter.history.some(([, mode]) => mode === "LAND"));
    assert.equal(box.failure, null);
  });

  test(`${kind}: sent somewhere while it lands at home it takes off when it stands`, () => {
    const box = idle({ kind });
    box.until(() => box.copter.mode === "LAND", 300);
    const next = box.goTo(GOAL.x_m, GOAL.y_m);
    box.landed(120);
    box.until(() => box.said("arrived", next).length, 300);
    assert.equal(box.failure, null);
  });

  test(`${kind}: the mission ends while it lands at home: it ends on the ground`, () => {
    const box = idle({ kind });
    box.until(() => box.copter.mode === "LAND", 300);
    box.tell({ type: "bye", reason: "it is over" });
    box.until(() => box.driver.exitCode !== null, 200);
    assert.equal(box.driver.exitCode, 0);
    assert.equal(box.copter.armed, false);
    assert.equal(box.kept, null, "its settings are put back");
  });
}

test("its order is called off: it lands at home two minutes later", () => {
  const box = new Box().flying();
  box.tell({ type: "cancel", id: 1, mission_s: box.now, reason: "its partner is gone" });
  const took = box.landed();
  assert.ok(took > 120 && took < 240, `${took} s`);
  assert.ok(box.distanceTo(START) < 3);
});

test("while its partner is awaited it stays", () => {
  const box = new Box().ready();
  const there = box.goTo(GOAL.x_m, GOAL.y_m, "sense");
  box.until(() => box.said("arrived", there).length, 300);
  box.run(300);
  assert.ok(isUpAt(box, GOAL));
});

test("it stays with --land-idle 0, and where UAVs are kept apart", () => {
  const never = idle({ options: { landIdle: 0 } });
  const apart = new Box({ hello: { altitudes: { lowest_m: 60, highest_m: 100 } } }).ready();
  apart.goTo(GOAL.x_m, GOAL.y_m, "wait", undefined, { altitude_m: 60 });
  for (const box of [never, apart]) {
    box.until(() => box.said("arrived").length, 300);
    box.run(300);
    assert.ok(isUpAt(box, GOAL));
    assert.equal(box.failure, null);
  }
});
