// The mission's zones in the autopilot's fence.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Box, START } from "./box.mjs";

const AREA_ITEMS = 6;
const around = (x_m, y_m, r_m = 100) => [[-r_m, -r_m], [r_m, -r_m], [r_m, r_m], [-r_m, r_m]].map(([x, y]) => ({ x_m: x_m + x, y_m: y_m + y }));
const add = (box, id, ...rings) => box.tell({ type: "zone", mission_s: box.now, id, rings });
const lift = (box, id) => box.tell({ type: "zone_lift", mission_s: box.now, id });
const zonesOf = (box) => box.copter.fence.filter(({ command }) => command === 5002);

/** Corners of its zones, to metres. */
function cornersOf(box) {
  return zonesOf(box).map(({ x, y }) => box.map.toMetres({ latitude_deg: x / 1e7, longitude_deg: y / 1e7 }))
    .map(({ x_m, y_m }) => ({ x_m: Math.round(x_m), y_m: Math.round(y_m) }));
}

for (const kind of ["ardupilot", "px4"]) {
  test(`${kind}: zones that are known before it takes off are in its fence`, () => {
    const box = new Box({ kind });
    add(box, "zone:0", around(2000, 400));
    add(box, "zone:1", around(3000, 2000, 50));
    box.ready();
    assert.equal(box.copter.fence.length, AREA_ITEMS + 8);
    assert.deepEqual(cornersOf(box), [...around(2000, 400), ...around(3000, 2000, 50)]);
    assert.ok(!box.copter.isInFence(box.copter.toMetres(box.map.toDegrees({ x_m: 2000, y_m: 400 }))));
    box.tell({ type: "bye", reason: "over" });
    box.until(() => box.driver.exitCode !== null, 60);
    assert.deepEqual(box.copter.fence, [], "and not any more");
  });

  test(`${kind}: zones come and go while it flies`, () => {
    const box = new Box({ kind }).flying();
    add(box, "heli", around(2000, 1000));
    box.until(() => zonesOf(box).length === 4, 5, "in its fence");
    add(box, "crowd", around(2500, 1000));
    box.until(() => zonesOf(box).length === 8, 5, "the second, too");
    lift(box, "heli");
    box.until(() => zonesOf(box).length === 4, 5, "lifted");
    assert.deepEqual(cornersOf(box), around(2500, 1000));
    box.until(() => box.said("arrived", 1).length, 300);
    assert.equal(box.failure, null);
  });

  test(`${kind}: it is blown into a zone: its autopilot comes home by itself`, () => {
    const box = new Box({ kind }).flying();
    add(box, "heli", around(2000, 1000));
    box.until(() => zonesOf(box).length === 4, 5, "in its fence");
    Object.assign(box.copter.at, box.copter.toMetres(box.map.toDegrees({ x_m: 2000, y_m: 1000 })));
    box.until(() => box.failure, 2, "failed");
    assert.match(box.failure, /by itself \(Fence Breached\)|its fence is touched/);
    assert.equal(box.copter.breaches, 1);
    box.landed();
  });

  test(`${kind}: a zone around it is in its fence when it has left it`, () => {
    const box = new Box({ kind }).flying();
    box.until(() => box.said("arrived", 1).length, 300);
    add(box, "crowd", around(1500, 400));
    box.run(20);
    assert.equal(zonesOf(box).length, 0, "it may leave it");
    box.goTo(1500, 1000);
    box.until(() => zonesOf(box).length === 4, 60, "in its fence");
    assert.ok(box.place.y_m > 500);
    assert.equal(box.failure, null);
  });

  test(`${kind}: after its battery was changed, with the power off, its fence has the zones of then`, () => {
    const box = new Box({ kind, options: { confirm: "a file" }, drain_percent_s: 0.25 });
    add(box, "zone:0", around(2000, 2000));
    box.ready();
    const to = box.goTo(800, 900, "charge");
    box.until(() => box.said("arrived", to).length, 300);
    const charge = box.order("charge", 30);
    box.copter.drain_percent_s = 0.02;
    box.cutPower();
    add(box, "heli", around(3000, 2000));
    box.run(30);
    box.restorePower();
    box.copter.fence = [];
    box.isChanged = true;
    box.until(() => box.said("done", charge).length, 120);
    assert.deepEqual(cornersOf(box), [...around(2000, 2000), ...around(3000, 2000)]);
  });
}

/** Corners of the way from (1500, 400) to the start at (500, 400) around a zone at (1000, 400), and how near it came to its middle. */
const VIA = [{ x_m: 1130, y_m: 530 }, { x_m: 870, y_m: 530 }];

function isOver(box, via) {
  box.tell({ type: "way_home", mission_s: box.now, via });
  box.tell({ type: "bye", reason: "over" });
}

function comesHome(box) {
  let nearest_m = Infinity;
  box.until(() => {
    nearest_m = Math.min(nearest_m, box.distanceTo({ x_m: 1000, y_m: 400 }));
    return !box.copter.armed;
  }, 900, "landed");
  assert.ok(box.distanceTo(START) < 10, "at home");
  return nearest_m;
}

function atItsPlace(kind, options) {
  const box = new Box({ kind, ...options }).flying();
  box.until(() => box.said("arrived", 1).length, 300);
  add(box, "crowd", around(1000, 400));
  box.until(() => zonesOf(box).length === 4, 5, "in its fence");
  return box;
}

for (const kind of ["ardupilot", "px4"]) {
  test(`${kind}: the mission is over: it comes home around zones`, () => {
    const box = atItsPlace(kind);
    isOver(box, VIA);
    const nearest_m = comesHome(box);
    assert.ok(nearest_m > 125, `${nearest_m} m`);
    assert.equal(box.copter.breaches, 0);
    box.until(() => box.driver.exitCode === 0, 60, "its end");
    assert.equal(box.kept, null);
  });

  test(`${kind}: its driver leaves the way home to another program, which flies the rest of it`, () => {
    const box = atItsPlace(kind);
    isOver(box, VIA);
    box.driver.leaveWayHome();
    assert.equal(box.driver.exitCode, 0);
    box.isDead = true;
    box.run(1);
    box.startDriver({ ...box.driver.options, after: 1 });
    box.driver.restore();
    const nearest_m = comesHome(box);
    assert.ok(nearest_m > 125, `${nearest_m} m`);
    assert.equal(box.copter.breaches, 0);
    box.until(() => box.driver.exitCode === 0, 60, "its end");
    assert.equal(box.kept, null, "its settings are as they were");
  });

  test(`${kind}: its battery is at the reserve: it comes home around zones, also when that happens on its way home`, () => {
    for (const isLate of [false, true]) {
      const box = atItsPlace(kind);
      box.tell({ type: "way_home", mission_s: box.now, via: VIA });
      if (isLate) {
        box.tell({ type: "bye", reason: "over" });
        box.run(10);
      }
      box.copter.battery_percent = 24.9;
      if (!isLate) box.until(() => box.failure?.startsWith("its battery is low: 24 %"), 3, "failed");
      const nearest_m = comesHome(box);
      assert.ok(nearest_m > 125, `${nearest_m} m`);
      assert.equal(box.copter.breaches, 0);
    }
  });

  test(`${kind}: on its way home around zones its battery is nearly empty: it lands`, () => {
    const box = atItsPlace(kind);
    isOver(box, VIA);
    box.run(10);
    box.copter.cell_v = 3.1;
    box.until(() => box.copter.mode === "LAND" || !box.copter.armed, 60, "landing");
    assert.ok(box.notes.some((note) => /; it does not fly around zones any more$/.test(note)), box.notes.join("; "));
  });

  test(`${kind}: with nothing to do it lands at home around zones, also when one comes on its way`, () => {
    const box = atItsPlace(kind, { options: { landIdle: 60 } });
    box.tell({ type: "way_home", mission_s: box.now, via: VIA });
    box.until(() => box.distanceTo(VIA[0]) < 50, 300, "on its way home");
    const further = [VIA[0], { x_m: 1000, y_m: 700 }, { x_m: 700, y_m: 530 }];
    box.tell({ type: "way_home", mission_s: box.now, via: further });
    let highest_m = 0;
    box.until(() => ((highest_m = Math.max(highest_m, box.place.y_m)), !box.copter.armed), 900, "landed");
    assert.ok(highest_m > 690, `${highest_m} m`);
    assert.ok(box.distanceTo(START) < 10, "at home");
    assert.equal(box.failure, null);
  });

  test(`${kind}: sent back while it lands at home, it knows the whole way home`, () => {
    const box = atItsPlace(kind, { options: { landIdle: 60 } });
    box.tell({ type: "way_home", mission_s: box.now, via: VIA });
    box.until(() => box.distanceTo(VIA[1]) < 60, 300, "past the first corner");
    const back = box.goTo(1500, 400, "wait", [VIA[0]]);
    box.until(() => box.said("arrived", back).length, 300);
    box.tell({ type: "bye", reason: "over" });
    const nearest_m = comesHome(box);
    assert.ok(nearest_m > 125, `${nearest_m} m`);
    assert.equal(box.copter.breaches, 0);
  });

  test(`${kind}: on its way home around zones the pilot takes over: nothing is commanded any more`, () => {
    const box = atItsPlace(kind);
    isOver(box, VIA);
    box.run(10);
    box.copter.setMode(kind === "px4" ? "POSCTL" : "LOITER");
    box.until(() => box.driver.exitCode !== null, 60, "hands off");
    assert.ok(box.copter.armed);
  });
}

test("the program that brings it home ends when it hears nothing any more", () => {
  const box = atItsPlace("ardupilot");
  isOver(box, VIA);
  box.driver.leaveWayHome();
  box.startDriver({ ...box.driver.options, after: 1 });
  box.driver.restore();
  box.run(10);
  box.loses = () => true;
  box.until(() => box.driver.exitCode !== null, 920, "its end");
  assert.equal(box.driver.exitCode, 1);
  assert.ok(box.notes.includes("it is not heard any more"), box.notes.join("; "));
  assert.ok(box.kept, "what is not put back is kept for another try");
});

test("nobody flies the way home of a mission before", () => {
  const box = atItsPlace("ardupilot");
  box.kept.wayHome = { greeting: box.greeting, plan: box.driver.plan, homeward: [{ x_m: 3000, y_m: 2500 }] };
  box.tell({ type: "bye", reason: "over" });
  box.driver.leaveWayHome();
  assert.equal(box.kept.wayHome, null);
  box.isDead = true;
  box.startDriver({ ...box.driver.options, after: 1 });
  box.driver.restore();
  let furthest_m = 0;
  box.until(() => ((furthest_m = Math.max(furthest_m, box.place.x_m)), !box.copter.armed), 900, "landed");
  assert.ok(furthest_m < 1600, `${furthest_m}`);
  box.until(() => box.driver.exitCode === 0, 60, "its end");
});

test("a way home that is none is passed over", () => {
  for (const via of [null, 7, "x", {}, [null, 3, {}], [{ x_m: 1e9, y_m: 0 }]]) {
    const box = atItsPlace("ardupilot");
    isOver(box, via);
    comesHome(box);
    box.until(() => box.driver.exitCode === 0, 60, "its end");
  }
});

test("it is said once that the autopilot's own return leads through zones, and only then", () => {
  const told = (before, oaType) => {
    const box = new Box();
    box.copter.settings.OA_TYPE = oaType;
    if (before) add(box, "zone:0", around(2000, 2000));
    box.ready();
    add(box, "heli", around(3000, 2000));
    add(box, "crowd", around(3000, 2600));
    return box.notes.filter((note) => note.includes("set OA_TYPE to 2")).length;
  };
  assert.deepEqual([told(true, 0), told(false, 0), told(true, 2), told(true, 3)], [1, 1, 0, 0]);
  const px4 = new Box({ kind: "px4" });
  add(px4, "zone:0", around(2000, 2000));
  px4.ready();
  assert.ok(!px4.notes.some((note) => note.includes("OA_TYPE")));
});

test("what is read back is not what was written: it does not fly; in flight it says so, and tries again", () => {
  const box = new Box();
  add(box, "zone:0", around(2000, 2000));
  box.protocol.shift = 10;
  box.until(() => box.failure, 60, "failed");
  assert.equal(box.failure, "its fence is not as it was written");
  assert.equal(box.copter.armed, false);

  const inFlight = new Box().flying();
  inFlight.protocol.shift = 10;
  add(inFlight, "heli", around(2000, 1000));
  inFlight.until(() => inFlight.notes.includes("the zones are not in its fence: its fence is not as it was written"), 10);
  const from = inFlight.protocol.heard.length;
  inFlight.protocol.shift = 0;
  inFlight.until(() => inFlight.protocol.heard.slice(from).some(([, name]) => name === "MISSION_COUNT"), 15, "written again");
  inFlight.until(() => inFlight.said("arrived", 1).length, 300);
  assert.equal(inFlight.failure, null);
});

for (const kind of ["ardupilot", "px4"]) {
  test(`${kind}: an autopilot with little room has the first zones, and later ones when those are lifted`, () => {
    const box = new Box({ kind });
    box.protocol.room = AREA_ITEMS + 9;
    for (const [i, id] of ["a", "b", "c"].entries()) add(box, id, around(2000 + 300 * i, 2000));
    box.ready();
    assert.deepEqual(cornersOf(box), [...around(2000, 2000), ...around(2300, 2000)]);
    assert.ok(box.notes.some((note) => /^zone c is not in its fence: it has 4 corners, and there is room for [0-3]$/.test(note)), box.notes.join("; "));
    lift(box, "a");
    box.until(() => cornersOf(box).some(({ x_m }) => x_m === 2700), 10, "there is room now");
    assert.equal(zonesOf(box).length, 8);
    assert.equal(box.failure, null);
  });
}

test("an autopilot that rounds places by a centimetre flies", () => {
  const box = new Box();
  box.protocol.shift = 1;
  box.ready();
  assert.equal(box.failure, null);
});

test("a zone comes and goes while its battery is changed: its fence is that of now", () => {
  const box = new Box({ options: { confirm: "a file" }, drain_percent_s: 0.25 }).ready();
  const to = box.goTo(800, 900, "charge");
  box.until(() => box.said("arrived", to).length, 300);
  const charge = box.order("charge", 30);
  box.run(1);
  box.copter.drain_percent_s = 0.02;
  box.copter.battery_percent = box.copter.charge_percent = 100;
  box.run(2);
  add(box, "heli", around(3000, 2000));
  box.isChanged = true;
  box.run(0.1);
  lift(box, "heli");
  box.until(() => box.said("done", charge).length, 120);
  box.run(20);
  assert.deepEqual(cornersOf(box), []);
});

test("an autopilot without room for the area does not fly", () => {
  const box = new Box();
  box.protocol.room = 3;
  add(box, "a", around(2000, 2000));
  box.until(() => box.failure, 60, "failed");
  assert.equal(box.failure, "its fence is refused: it has no room for 6 corners");
  assert.equal(box.copter.armed, false);
});

test("zones that its fence has no room for, and those with holes, are named; lines that no mission says are passed over", () => {
  const box = new Box();
  const circle = Array.from({ length: 250 }, (_, i) => ({ x_m: 2000 + 100 * Math.cos(i / 40), y_m: 2000 + 100 * Math.sin(i / 40) }));
  add(box, "round", circle);
  add(box, "ring", around(2000, 1000, 200), around(2000, 1000));
  add(box, "small", around(3000, 2000));
  for (const rings of [undefined, null, 7, [[]], [[{ x_m: 1 }, {}, null]], [around(1, 1), "x"]]) box.tell({ type: "zone", id: "none", rings });
  box.ready();
  assert.deepEqual(cornersOf(box), around(3000, 2000));
  assert.ok(box.notes.includes("zone round is not in its fence: it has 250 corners, and there is room for 190"), box.notes.join("; "));
  assert.ok(box.notes.includes("zone ring is not in its fence: it has holes"));
});
