// The range that the mission is told, by what the battery was measured to give.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Box } from "./box.mjs";

const WEST = { x_m: 1500, y_m: 400 }, EAST = { x_m: 3500, y_m: 400 }, CHARGING = { x_m: 2500, y_m: 400 };
const SPEED_M_S = 12, SENSING_M = 400, SENSE_S = SENSING_M / SPEED_M_S;
const RESERVE = 25, MARGIN = 10, FULL_M = 20000, USUAL = (100 - RESERVE - MARGIN) / FULL_M;

const distance = (a, b) => Math.hypot(a.x_m - b.x_m, a.y_m - b.y_m);

function arrive(box, place, then) {
  const there = box.goTo(place.x_m, place.y_m, then, undefined, { on_to_charge_m: distance(place, CHARGING) });
  box.until(() => box.said("arrived", there).length || box.failure, 900);
  assert.equal(box.failure, null, `at ${box.copter.battery_percent} %`);
}

function sense(box) {
  const sensing = box.order("sense", SENSE_S);
  box.until(() => box.said("done", sensing).length || box.failure, SENSE_S + 60);
  assert.equal(box.failure, null, `at ${box.copter.battery_percent} %`);
}

function charge(box) {
  const charging = box.order("charge", 30);
  box.copter.battery_percent = box.copter.charge_percent = 100;
  box.until(() => box.said("done", charging).length, 120);
}

/** As a mission does: senses as long as the range that it knows of lets it, then sends it to charge. Returns how often it sensed. */
function senseUntilCharge(box, from) {
  let times = 0, at = from;
  for (; ; ++times) {
    const to = times % 2 ? EAST : WEST;
    if (distance(at, to) + SENSING_M + distance(to, CHARGING) > box.referee.seen.range_m) break;
    arrive(box, to, "sense");
    sense(box);
    at = to;
  }
  assert.ok(box.referee.seen.range_m >= distance(at, CHARGING), `${box.referee.seen.range_m} m: it may not be sent to charge`);
  arrive(box, CHARGING, "charge");
  return times;
}

for (const kind of ["ardupilot", "px4"]) {
  for (const [drain_percent_s, hover] of [[0.05, 1], [0.05, 4], [0.12, 2], [0.2, 1]]) {
    test(`${kind}: ${drain_percent_s} % a second, ${hover} times as much in one place: it is sent to charge before its reserve`, () => {
      const box = new Box({ kind, drain_percent_s, hover }).ready();
      let from = box.greeting.at;
      for (let battery = 0; battery < 3; ++battery) {
        const times = senseUntilCharge(box, from), left = box.copter.battery_percent;
        assert.ok(times >= 1, `it has sensed ${times} times`);
        assert.ok(left > RESERVE && left < 70, `${left} % are left of battery ${battery} after ${times}`);
        charge(box);
        from = CHARGING;
      }
    });
  }
}

test("what it took to sense at the end of a way is told as range when that is over", () => {
  const box = new Box({ drain_percent_s: 0.05, hover: 3 }).ready();
  const before = box.copter.battery_percent;
  arrive(box, WEST, "sense");
  sense(box);
  const each = (before - box.copter.battery_percent) / (distance(box.greeting.at, WEST) + SENSING_M);
  const left_m = (box.copter.battery_percent - RESERVE - MARGIN) / each, { range_m } = box.referee.seen;
  assert.ok(each > 2 * USUAL && Math.abs(range_m - left_m) < 0.1 * left_m, `${range_m} m are told, ${left_m} m are left`);
});

test("where the battery gives more than the scenario has, the range is as the scenario has it", () => {
  const box = new Box({ drain_percent_s: 0.01 }).ready();
  arrive(box, WEST, "sense");
  sense(box);
  box.copter.battery_percent = 60.5;
  box.run(35);
  const usual_m = (60 - RESERVE - MARGIN) / USUAL;
  assert.ok(Math.abs(box.referee.seen.range_m - usual_m) < 1, `${box.referee.seen.range_m} m, ${usual_m} m as the scenario has it`);
});
