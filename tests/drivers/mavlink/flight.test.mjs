// What a mission asks of a UAV, flown by the test copter.
import assert from "node:assert/strict";
import { test } from "node:test";
import { AREA, Box, START } from "./box.mjs";

for (const kind of ["ardupilot", "px4"]) {
  test(`${kind}: flies to a place, senses, has its battery changed, comes home`, () => {
    const box = new Box({ kind, drain_percent_s: 0.035 });
    const factory = { ...box.copter.settings };
    box.ready();
    const first = box.goTo(1500, 900, "sense");
    box.until(() => box.said("arrived", first).length, 300);
    assert.ok(box.distanceTo({ x_m: 1500, y_m: 900 }) < 3);
    assert.ok(Math.abs(box.copter.at.up - 55) < 2, "uav:3 flies at 40 + 3 * 5 m");
    const expected = box.lines.filter(([, line]) => line.expected_s).map(([, line]) => line.expected_s);
    assert.ok(expected.length > 20 && Math.abs(expected.at(-1) - box.now) < 10, "it says when it will be there");

    const sense = box.order("sense", 60);
    const took = box.until(() => box.said("done", sense).length, 100);
    assert.ok(took > 59 && took < 62);
    assert.equal(box.copter.photos.length, 1);

    const charge_to = box.goTo(800, 900, "charge");
    box.until(() => box.said("arrived", charge_to).length, 300);
    assert.ok(!box.copter.armed && box.copter.isLanded, "it has landed when it has arrived");
    const told = box.said("state").filter((line) => line.range_m !== undefined).at(-1).range_m;
    const left = (20000 * (Math.floor(box.copter.battery_percent) - 35)) / 65;
    assert.ok(told < left + 600 && told > 0.7 * left, `${told} m: as its battery says, ${left} m, or less, as it took off and waited`);
    const charge = box.order("charge", 30);
    box.run(60);
    assert.equal(box.said("done", charge).length, 0, "nobody has changed the battery");
    box.copter.battery_percent = 100;
    box.until(() => box.said("done", charge).length, 60);
    const { range_m } = box.said("done", charge)[0];
    assert.ok(range_m > told && range_m < 20000, `full: ${range_m} m, as the battery before has shown`);

    const last = box.goTo(900, 1500);
    box.until(() => box.said("arrived", last).length, 300);
    box.tell({ type: "bye", reason: "it is over" });
    box.until(() => box.driver.exitCode !== null, 900);
    assert.equal(box.driver.exitCode, 0);
    assert.ok(box.distanceTo(START) < 3, "home is where it set out, not where its battery was changed");
    assert.deepEqual(box.copter.settings, factory, "its settings are as they were");
    assert.deepEqual(box.copter.fence, []);
    assert.equal(box.kept, null);
    assert.equal(box.failure, null);
  });

  test(`${kind}: flies by the corners of its way around a zone`, () => {
    const box = new Box({ kind }).flying();
    box.run(120);
    const via = [{ x_m: 1500, y_m: 800 }, { x_m: 1900, y_m: 800 }];
    const there = box.goTo(1900, 400, "wait", via);
    const nearest = [Infinity, Infinity];
    let straight = Infinity;
    box.until(() => {
      via.forEach((corner, i) => (nearest[i] = Math.min(nearest[i], box.distanceTo(corner))));
      straight = Math.min(straight, box.distanceTo({ x_m: 1700, y_m: 400 }));
      return box.said("arrived", there).length;
    }, 400);
    assert.ok(Math.max(...nearest) < 8, `it came no nearer to the corners than ${nearest} m`);
    assert.ok(straight > 190, "not straight through");
    const told = box.lines.findLast(([, line]) => line.expected_s)[1];
    assert.ok(Math.abs(told.expected_s - box.now) < 15, "it says when it will be there");
    assert.equal(box.failure, null);
  });

  test(`${kind}: flies as high as a mission that keeps UAVs apart says, and sets out when it says`, () => {
    const box = new Box({ kind, hello: { agent: "uav:40", altitudes: { lowest_m: 30, highest_m: 120 } } }).ready();
    assert.ok(box.copter.settings[kind === "px4" ? "GF_MAX_VER_DIST" : "FENCE_ALT_MAX"] >= 120, "its fence lets it");
    const set_out_s = box.now + 90;
    const first = box.goTo(1500, 400, "wait", undefined, { altitude_m: 110, set_out_s });
    box.until(() => box.copter.at.up > 0.5, 200);
    assert.ok(box.now > set_out_s - 2, `it rose ${set_out_s - box.now} s too early`);
    box.until(() => box.said("arrived", first).length, 400);
    assert.ok(Math.abs(box.copter.at.up - 110) < 2);
    const second = box.goTo(900, 400, "wait", undefined, { altitude_m: 60 });
    box.until(() => box.said("arrived", second).length, 400);
    assert.ok(Math.abs(box.copter.at.up - 60) < 2);
    box.tell({ type: "altitude", mission_s: box.now, altitude_m: 90 });
    box.until(() => Math.abs(box.copter.at.up - 90) < 2, 60);
    box.run(30);
    assert.ok(Math.abs(box.copter.at.up - 90) < 2 && box.distanceTo({ x_m: 900, y_m: 400 }) < 3, "it stays there, higher");
    assert.equal(box.failure, null);
  });

  test(`${kind}: it changes its altitude at the beginning of its way, as the mission counts on, also around corners`, () => {
    for (const [via, altitude_m] of [[undefined, 120], [[{ x_m: 1560, y_m: 480 }, { x_m: 1800, y_m: 900 }], 30]]) {
      const box = new Box({ kind, hello: { altitudes: { lowest_m: 30, highest_m: 120 } } }).ready();
      const first = box.goTo(1500, 400, "wait", undefined, { altitude_m: 70 });
      box.until(() => box.said("arrived", first).length, 300);
      const from_s = box.now, from_m = box.copter.at.up;
      const second = box.goTo(3300, 900, "wait", via, { altitude_m });
      const planned = (s) => (altitude_m > from_m ? Math.min(altitude_m, from_m + 2.5 * s) : Math.max(altitude_m, from_m - 1.5 * s));
      let worst_m = 0;
      box.until(() => {
        worst_m = Math.max(worst_m, Math.abs(box.copter.at.up - planned(box.now - from_s)));
        return box.said("arrived", second).length;
      }, 400);
      assert.ok(worst_m < 9, `${worst_m} m from the altitude that is planned`);
      assert.equal(box.failure, null);
    }
  });

  test(`${kind}: does not fly in a mission whose highest altitude is above its ceiling`, () => {
    const box = new Box({ kind, options: { ceiling: 100 }, hello: { altitudes: { lowest_m: 30, highest_m: 120 } } });
    box.run(5);
    assert.match(box.failure, /would fly at 120 m, above 100 m/);
  });

  test(`${kind}: two that would meet pass each other at the altitudes that they are given`, () => {
    const [west, east] = [{ x_m: 600, y_m: 400 }, { x_m: 1800, y_m: 400 }];
    const boxes = [west, east].map((at) => new Box({ kind, at, hello: { at, altitudes: { lowest_m: 30, highest_m: 120 } } }).ready());
    const heights = [30, 40];
    boxes.forEach((box, i) => box.goTo([east, west][i].x_m, 400, "wait", undefined, { altitude_m: heights[i] }));
    let closest = Infinity, above = Infinity;
    for (let s = 0; s < 400 && !boxes.every((box) => box.said("arrived").length); s += 0.1) {
      boxes.forEach((box) => box.run(0.1));
      const across = Math.hypot(boxes[0].place.x_m - boxes[1].place.x_m, boxes[0].place.y_m - boxes[1].place.y_m);
      const up = Math.abs(boxes[0].copter.at.up - boxes[1].copter.at.up);
      closest = Math.min(closest, across);
      if (across < 50) above = Math.min(above, up);
    }
    assert.ok(boxes.every((box) => box.said("arrived").length && box.failure === null));
    assert.ok(closest < 10, "they do meet across");
    assert.ok(above > 8.5, `${above} m apart up and down`);
  });

  test(`${kind}: stops when it is told to, goes elsewhere when it is told to`, () => {
    const box = new Box({ kind }).flying();
    box.tell({ type: "cancel", id: 1, mission_s: box.now, reason: "its partner is gone" });
    box.run(20);
    const at = { ...box.place };
    box.run(60);
    assert.ok(box.distanceTo(at) < 1);
    box.goTo(1500, 400);
    box.run(10);
    const second = box.goTo(900, 1000);
    box.until(() => box.said("arrived").length, 200);
    assert.deepEqual(box.said("arrived"), [{ type: "arrived", id: second }]);
    assert.equal(box.failure, null);
  });

  test(`${kind}: every place that it tells is one that its speed allows`, () => {
    const box = new Box({ kind, drain_percent_s: 0.2 }).ready();
    const there = box.goTo(3500, 2500);
    box.until(() => box.said("arrived", there).length, 600);
    const states = [{ at: START, mission_s: 0 }, ...box.said("state")];
    for (let i = 1; i < states.length; ++i) {
      const way = Math.hypot(states[i].at.x_m - states[i - 1].at.x_m, states[i].at.y_m - states[i - 1].at.y_m);
      assert.ok(way <= 12 * (states[i].mission_s - states[i - 1].mission_s) + 1e-6);
      assert.ok(states[i].mission_s <= box.now + 1.5);
    }
    const ranges = states.filter(({ range_m }) => range_m !== undefined);
    assert.ok(ranges.length > 3);
    for (let i = 1; i < ranges.length; ++i) {
      const way = Math.hypot(ranges[i].at.x_m - ranges[i - 1].at.x_m, ranges[i].at.y_m - ranges[i - 1].at.y_m);
      assert.ok(ranges[i].range_m <= ranges[i - 1].range_m - way + 2, "no range from nowhere");
    }
  });
}

for (const late_s of [0.5, 8, 25]) {
  test(`at rate 60 every third tick is told ${late_s} s late: nothing that it tells is too fast`, () => {
    const box = new Box({ options: { speedup: 60 }, hello: { rate: 60 } }).ready();
    box.tickLate_s = (number) => (number % 3 ? 0 : late_s);
    const there = box.goTo(3500, 2500, "sense");
    box.until(() => box.said("arrived", there).length, 600);
    assert.ok(box.said("state").length > 30);
    const sense = box.order("sense", 60);
    box.until(() => box.said("done", sense).length, 120);
    const back = box.goTo(900, 600);
    box.until(() => box.said("arrived", back).length, 600);
    box.run(90);
    assert.equal(box.failure, null);
  });
}

test("a UAV that is faster than the scenario's is told as far as that speed allows, and arrives when it could", () => {
  const box = new Box({ hello: { speed_m_s: 10 } }).ready();
  box.copter.settings.WPNAV_SPEED = 1500;  // as in a strong tailwind
  const id = box.goTo(1500, 400);
  const from = box.now;
  box.until(() => box.distanceTo({ x_m: 1500, y_m: 400 }) < 1, 200);
  const there = box.now;
  box.until(() => box.said("arrived", id).length, 200);
  assert.ok(box.now - from >= 100 - 1 && box.now > there + 10, `${box.now - from} s for 1000 m, there after ${there - from} s`);
  assert.deepEqual(box.said("state").at(-1).at, { x_m: 1500, y_m: 400 });
  assert.equal(box.failure, null);
});

test("sensing that ends at a tick is done before that tick is answered", () => {
  const box = new Box().flying();
  box.until(() => box.said("arrived", 1).length, 300);
  const tick = { type: "time", mission_s: box.now };
  box.tell(tick);
  const sense = box.order("sense", 90);
  box.run(1);
  box.tell({ ...tick, mission_s: tick.mission_s + 89.9 });
  assert.equal(box.said("done", sense).length, 0);
  const from = box.lines.length;
  box.tell({ ...tick, mission_s: tick.mission_s + 90 });
  assert.deepEqual(box.lines.slice(from).map(([, { type }]) => type), ["done", "state"]);
});

test("sensing that has begun before it was told of ends so much earlier", () => {
  const box = new Box().flying();
  box.until(() => box.said("arrived", 1).length, 300);
  box.run(25);
  box.tell({ type: "time", mission_s: box.now });
  box.tell({ type: "sense", id: 2, mission_s: box.now - 20, for_s: 40 });
  box.step();
  assert.ok(Math.abs(box.driver.reporter.mission_s - box.now) < 0.1, "its clock goes on");
  const took = box.until(() => box.said("done", 2).length, 100);
  assert.ok(Math.abs(took - 20) < 1, `${took} s`);
});

test("sets what it relies on, before it takes off, and its fence is the area", () => {
  const box = new Box().ready();
  const { settings, fence } = box.copter;
  assert.deepEqual(
    { gcs: settings.FS_GCS_ENABLE, options: settings.FS_OPTIONS, low: settings.BATT_LOW_MAH, home: settings.RTL_ALT, speed: settings.WPNAV_SPEED, fence: settings.FENCE_ENABLE },
    { gcs: 1, options: 24, low: 1000, home: 5500, speed: 1200, fence: 1 });
  const corners = fence.map((item) => box.map.toMetres({ latitude_deg: item.x / 1e7, longitude_deg: item.y / 1e7 }));
  assert.deepEqual([Math.min(...corners.map((c) => c.x_m)), Math.max(...corners.map((c) => c.y_m))].map(Math.round), [-20, AREA.height_m + 20]);
  assert.equal(box.copter.armed, false);
});

test("PX4's integers are written as bits", () => {
  const box = new Box({ kind: "px4" }).ready();
  assert.equal(box.copter.settings.NAV_DLL_ACT, 2);
  assert.equal(box.copter.settings.COM_RC_OVERRIDE, 1);
  assert.ok(Math.abs(box.copter.settings.BAT_CRIT_THR - 0.2) < 1e-6);
});

test("a fence that it had is put back", () => {
  const box = new Box();
  const old = [[-0.01, -0.01], [0.05, -0.01], [0.05, 0.08], [-0.01, 0.08]].map(([north, east]) =>
    ({ command: 5001, frame: 0, param1: 4, x: Math.round((52.2 + north) * 1e7), y: Math.round((0.1 + east) * 1e7), z: 0 }));
  box.copter.fence = structuredClone(old);
  box.ready();
  assert.notDeepEqual(box.copter.fence, old);
  box.tell({ type: "bye", reason: "over" });
  box.until(() => box.driver.exitCode !== null, 60);
  assert.deepEqual(box.copter.fence, old);
});

test("does not take off before somebody says that the battery was changed, even when the battery says so", () => {
  const box = new Box({ options: { confirm: "a file" } }).ready();
  const to = box.goTo(800, 900, "charge");
  box.until(() => box.said("arrived", to).length, 300);
  box.isChanged = true;  // said too early: of another change
  const charge = box.order("charge", 10);
  box.copter.battery_percent = 100;
  box.run(60);
  assert.equal(box.said("done", charge).length, 0);
  box.tell({ type: "cancel", id: charge, mission_s: box.now, reason: "its partner is gone" });
  box.goTo(1500, 900);
  box.run(60);
  assert.equal(box.copter.armed, false, "somebody may be near");
  box.isChanged = true;
  box.until(() => box.said("arrived", 3).length, 300);
  assert.equal(box.failure, null);
});

test("a battery is changed with the power off for a minute", () => {
  for (const kind of ["ardupilot", "px4"]) {
    // Down to some 70 %: what it said of its battery before does not count.
    const box = new Box({ kind, options: { confirm: "a file" }, drain_percent_s: 0.25 }).ready();
    const to = box.goTo(800, 900, "charge");
    box.until(() => box.said("arrived", to).length, 300);
    const charge = box.order("charge", 30);
    assert.ok(box.copter.battery_percent < 80);
    box.copter.drain_percent_s = 0.02;
    box.cutPower();
    const said = box.lines.length;
    box.run(60);
    assert.ok(box.lines.length >= said + 2, "the mission does not take it for lost");
    box.restorePower();
    box.run(5);
    assert.equal(box.failure, null);
    box.isChanged = true;
    box.until(() => box.said("done", charge).length, 120);
    const on = box.goTo(1500, 900);
    box.until(() => box.said("arrived", on).length, 300);
    box.tell({ type: "bye", reason: "over" });
    box.until(() => box.driver.exitCode !== null, 900);
    assert.ok(box.distanceTo(START) < 3, "home is where it set out");
  }
});
