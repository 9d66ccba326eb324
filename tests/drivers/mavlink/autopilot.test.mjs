// What was seen with ArduPilot's own simulator, and what the driver has to make of it.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Box, START } from "./box.mjs";

const KINDS = ["ardupilot", "px4"];
const FAR = [1500, 400];

/** How long it takes until the mission hears that it failed, for that reason. */
function failsWithin(box, seconds, reason) {
  const took = box.until(() => box.failure, seconds + 60, "failed");
  assert.match(box.failure, reason);
  assert.ok(took <= seconds, `after ${took.toFixed(1)} s, not ${seconds} s`);
}

test("the autopilot listens to another ground station: it is told to listen to this one, and that is put back", () => {
  const box = new Box({ options: { ownSystem: 250 } });
  box.copter.settings.SYSID_MYGCS = 255;
  box.flying();
  assert.equal(box.copter.settings.SYSID_MYGCS, 250);
  box.isDead = true;
  const took = box.until(() => box.copter.mode === "RTL", 30);
  assert.ok(took < 12, `${took} s after the driver was killed`);
  box.landed();
  box.startDriver(box.driver.options);
  box.driver.restore();
  box.until(() => box.driver.exitCode !== null, 60);
  assert.equal(box.copter.settings.SYSID_MYGCS, 255);
});

test("the setting is found by its new name, too", () => {
  const box = new Box({ options: { ownSystem: 250 } });
  delete box.copter.settings.SYSID_MYGCS;
  box.copter.settings.MAV_GCS_SYSID = 255;
  box.ready();
  assert.equal(box.copter.settings.MAV_GCS_SYSID, 250);
});

for (const kind of KINDS) {
  test(`${kind}: only the way down is cut: the driver falls silent, and the autopilot comes home by itself`, () => {
    const box = new Box({ kind }).flying();
    box.loses = ({ direction }) => direction === "down";
    const took = box.until(() => box.copter.mode === "RTL", 30);
    assert.ok(took < 12, `${took} s`);
    assert.match(box.failure, /^its link is lost/);
    box.landed();
    assert.ok(box.distanceTo(START) < 3);
  });

  test(`${kind}: the way down is cut for two seconds: it flies on`, () => {
    const box = new Box({ kind }).flying();
    box.loses = ({ direction }) => direction === "down";
    box.run(2);
    box.loses = () => false;
    box.until(() => box.said("arrived", 1).length, 300);
    assert.equal(box.failure, null);
  });

  test(`${kind}: an empty battery is plugged in, and the autopilot says 100 %: it does not start again`, () => {
    const box = new Box({ kind, options: { confirm: "a file" } }).ready();
    const to = box.goTo(800, 900, "charge");
    box.until(() => box.said("arrived", to).length, 300);
    const charge = box.order("charge", 30);
    box.cutPower();
    box.run(20);
    box.restorePower(10);
    box.isChanged = true;
    box.run(120);
    assert.equal(box.said("done", charge).length, 0);
    assert.ok(box.notes.some((words) => /3\.57 V a cell/.test(words)), box.notes.join("\n"));
    assert.equal(box.copter.armed, false);
    box.cutPower();
    box.run(20);
    box.restorePower(100);
    box.until(() => box.said("done", charge).length, 120);
    assert.equal(box.failure, null);
  });

  test(`${kind}: it says 100 % of a battery that is nearly empty: it does not take off`, () => {
    const box = new Box({ kind });
    box.copter.charge_percent = 10;
    box.run(100);
    box.goTo(...FAR);
    box.run(100);
    assert.equal(box.copter.armed, false);
    assert.ok(box.notes.some((words) => /3\.57 V a cell/.test(words)), box.notes.join("\n"));
  });

  test(`${kind}: the voltage falls in flight while the percentage stays: comes home, and lands if it falls on`, () => {
    const box = new Box({ kind }).flying();
    box.copter.cell_v = 3.49;
    failsWithin(box, 6, /^its battery is low: 3\.39 V a cell/);
    box.until(() => box.copter.mode === "RTL", 2);
    box.copter.cell_v = 3.3;
    box.until(() => box.copter.mode === "LAND", 6);
    box.landed();
  });

  test(`${kind}: a voltage that falls for a moment is none`, () => {
    const box = new Box({ kind }).flying();
    box.copter.cell_v = 3.3;
    box.run(1.5);
    box.copter.cell_v = null;
    box.until(() => box.said("arrived", 1).length, 300);
    assert.equal(box.failure, null);
  });

  test(`${kind}: it falls: the mission hears of it within a second`, () => {
    const box = new Box({ kind }).flying();
    box.copter.fall_m_s = 8;
    failsWithin(box, 1, /^it falls at 8 m\/s/);
  });

  test(`${kind}: switched on with the mission: it waits until it can fly, says for what, and flies`, () => {
    const box = new Box({ kind, ready_s: 35 });
    box.goTo(...FAR);
    box.run(30);
    assert.equal(box.failure, null);
    assert.ok(box.notes.some((words) => /^not ready yet: /.test(words)), box.notes.join("\n"));
    const said = () => box.lines.map(([, line]) => line).filter(({ type }) => ["not_ready", "ready", "failed"].includes(type));
    assert.ok(said().length > 0);
    assert.ok(said().every(({ type, reason }) => type === "not_ready" && reason.length > 3), JSON.stringify(said()));
    assert.ok(said().length < 12, JSON.stringify(said()));
    box.until(() => said().at(-1).type === "ready", 60);
    box.until(() => box.said("arrived", 1).length, 300);
    assert.equal(said().filter(({ type }) => type === "ready").length, 1);
    assert.equal(box.failure, null);
  });

  test(`${kind}: home and arming are refused at first: it asks again`, () => {
    const box = new Box({ kind });
    box.protocol.refusals.push({ command: "DO_SET_HOME", result: 4, times: 3 }, { command: "COMPONENT_ARM_DISARM", result: 4, times: 3, words: "PreArm: Gyros inconsistent" });
    box.goTo(...FAR);
    box.until(() => box.said("arrived", 1).length, 300);
    assert.equal(box.failure, null);
  });

  test(`${kind}: it goes home by itself: the mission is told why in its words, which come later`, () => {
    const box = new Box({ kind }).flying();
    box.copter.setMode("RTL");
    box.run(0.1);  // the heartbeat may be on its way by then
    box.copter.say("Fence Breached", 5);
    failsWithin(box, 3, /^it went to (RTL|RETURN) by itself \(Fence Breached\)$/);
  });
}

test("the thrust of a motor is lost, it says: lands", () => {
  const box = new Box().flying();
  box.copter.say("Potential Thrust Loss (2)", 2);
  failsWithin(box, 1, /^its thrust is lost, it says: Potential Thrust Loss \(2\)/);
  box.until(() => box.copter.mode === "LAND", 2);
});

test("before its estimate is known it is not taken for good", () => {
  const box = new Box();
  box.loses = ({ name }) => name === "EKF_STATUS_REPORT";
  box.run(30);
  assert.ok(!box.notes.some((words) => words.startsWith("ready")));
  box.loses = () => false;
  box.ready();
});

test("the cells are known to nobody: it does not fly, and says what to do", () => {
  const box = new Box({ options: { cells: 0 } });
  failsWithin(box, 60, /the number of its battery's cells is not known: --cells N/);
  assert.equal(box.copter.armed, false);
});

test("PX4 knows its cells", () => {
  const box = new Box({ kind: "px4", options: { cells: 0 } });
  box.copter.settings.BAT1_N_CELLS = 4;
  box.flying();
  box.copter.cell_v = 3.49;
  failsWithin(box, 6, /^its battery is low: 3\.39 V a cell/);
});

test("streams that stop are asked for again", () => {
  const box = new Box().flying();
  box.protocol.intervals.delete(1);
  box.protocol.intervals.delete(24);
  box.run(6);
  assert.ok(box.protocol.intervals.has(1) && box.protocol.intervals.has(24));
  assert.equal(box.failure, null);
});

test("the pilot brakes: that is the pilot", () => {
  const box = new Box().flying();
  box.copter.setMode("BRAKE");
  failsWithin(box, 2, /^the pilot has taken over: BRAKE/);
});

test("the last answer to its fence is lost: it is written again", () => {
  const box = new Box();
  let lost = 0;
  box.loses = ({ direction, name, message }) => direction === "down" && name === "MISSION_ACK" && message.type === 0 && box.protocol.heard.some(([, heard]) => heard === "MISSION_ITEM_INT") && ++lost <= 1;
  box.ready();
  assert.equal(lost, 2, "the first is lost, the second is not");
  assert.ok(box.copter.fence.length > 3);
});

test("home stays where it set out, also while it is armed where its battery was changed", () => {
  const box = new Box().ready();
  const to = box.goTo(800, 900, "charge");
  box.until(() => box.said("arrived", to).length, 300);
  const charge = box.order("charge", 30);
  box.until(() => box.said("done", charge).length, 120);
  box.goTo(1500, 900);
  let most_m = 0;
  box.until(() => {
    const home = box.map.toMetres(box.copter.home);
    most_m = Math.max(most_m, Math.hypot(home.x_m - START.x_m, home.y_m - START.y_m));
    return box.distanceTo({ x_m: 1500, y_m: 900 }) < 3;
  }, 300);
  assert.ok(most_m < 3, `it was ${most_m} m away`);
});

test("no camera is there, though pictures are acknowledged: it does not fly, unless none is wanted", () => {
  for (const camera of ["digicam", "none"]) {
    const box = new Box({ options: { camera } });
    box.copter.settings.CAM1_TYPE = 0;
    if (camera === "none") box.flying();
    else failsWithin(box, 10, /^it has no camera: CAM1_TYPE is 0/);
    assert.equal(box.copter.armed, camera === "none");
  }
  const box = new Box();
  delete box.copter.settings.CAM1_TYPE;  // a version that has no such setting
  box.flying();
});

for (const kind of KINDS) {
  test(`${kind}: no faster than it is set, which is said, and the mission hears when it will be there`, () => {
    const box = new Box({ kind });
    const [name, per_m_s] = kind === "px4" ? ["MPC_XY_CRUISE", 1] : ["WPNAV_SPEED", 100];
    box.copter.settings[name] = 5 * per_m_s;
    box.ready();
    assert.equal(box.copter.settings[name], 5 * per_m_s);
    assert.ok(box.notes.some((words) => words.startsWith("it flies 5.0 m/s, as it is set; the scenario counts on 12.0")), box.notes.join("; "));
    const id = box.goTo(1500, 400);
    box.until(() => box.place.x_m > 600, 120);
    const { expected_s } = box.said("state").at(-1);
    box.until(() => box.said("arrived", id).length, 400);
    assert.ok(Math.abs(expected_s - box.now) < 12, `expected at ${expected_s} s, there at ${box.now} s`);
  });

  test(`${kind}: slower than the scenario, if it was faster`, () => {
    const box = new Box({ kind });
    const [name, per_m_s] = kind === "px4" ? ["MPC_XY_CRUISE", 1] : ["WPNAV_SPEED", 100];
    box.copter.settings[name] = 20 * per_m_s;
    box.ready();
    assert.equal(box.copter.settings[name], 12 * per_m_s);
    assert.ok(!box.notes.some((words) => words.includes("late")));
  });

  test(`${kind}: what it takes to land is learned from landing`, () => {
    const box = new Box({ kind }).ready();
    const late = [];
    for (const [x_m, y_m] of [[1200, 700], [600, 700]]) {
      const to = box.goTo(x_m, y_m, "charge");
      box.until(() => box.distanceTo({ x_m, y_m }) < 300 && box.copter.armed && box.copter.at.up > 50, 300);
      const { expected_s } = box.said("state").at(-1);
      box.until(() => box.said("arrived", to).length, 400);
      late.push(Math.abs(box.now - expected_s));
      const charge = box.order("charge", 30);
      box.until(() => box.said("done", charge).length, 120);
    }
    assert.ok(late[0] < 40, `${late[0]} s off at first`);
    assert.ok(late[1] < 10, `${late[1]} s off then`);
  });
}
