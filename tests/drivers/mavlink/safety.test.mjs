// What goes wrong in flight: what the UAV does, what the mission hears, and within what time (docs/guide/mavlink.md has the table).
import assert from "node:assert/strict";
import { test } from "node:test";
import { common } from "../../../drivers/mavlink/frames.mjs";
import { AREA, Box, START } from "./box.mjs";

const KINDS = ["ardupilot", "px4"];
const { MavCmd, MavResult } = common;

/** Both kinds: a UAV on its way to a place a kilometre away. */
function testInFlight(name, check) {
  for (const kind of KINDS) test(`${kind}: ${name}`, () => check(new Box({ kind }).flying(), kind));
}

/** How long it takes until the mission hears that it failed, for that reason. */
function failsWithin(box, seconds, reason) {
  const took = box.until(() => box.failure, seconds + 60, "failed");
  assert.match(box.failure, reason);
  assert.ok(took <= seconds, `after ${took.toFixed(1)} s, not ${seconds} s`);
  assert.equal(box.said("failed").length, 1);
}

/** Whether it has said something within a second of each tick. */
function answersEachTick(box) {
  const ticks = Array.from({ length: Math.floor(box.now / 30.1) }, (_, i) => 30 * (i + 1));
  return ticks.length > 0 && ticks.every((tick) => box.lines.some(([at]) => at >= tick && at < tick + 1));
}

/** Nothing is commanded for so long, but for settings that are put back. */
function staysSilent(box, seconds) {
  const before = box.protocol.commands().length;
  box.run(seconds);
  assert.deepEqual(box.protocol.commands().slice(before).map(([, , message]) => message.command), []);
}

testInFlight("the pilot takes over: hands off, settings put back at once, nothing commanded again", (box, kind) => {
  const given = Object.keys(box.kept.settings).length;
  assert.ok(given > 8);
  box.copter.setMode(kind === "px4" ? "POSCTL" : "LOITER");
  failsWithin(box, 2, /^the pilot has taken over: (LOITER|POSCTL)/);
  staysSilent(box, 300);
  assert.equal(box.kept, null);
  assert.ok(box.notes.length < 10, box.notes.join("\n"));
  assert.ok([0, 2].includes(box.copter.settings.FS_GCS_ENABLE ?? box.copter.settings.NAV_DLL_ACT));
  box.tell({ type: "bye", reason: "over" });
  staysSilent(box, 60);
  assert.equal(box.driver.exitCode, 1);
  assert.ok(!box.copter.history.some(([at]) => at > box.now - 300), "it is the pilot's");
});

testInFlight("the pilot gives it back: the driver does not take it", (box, kind) => {
  box.copter.setMode(kind === "px4" ? "POSCTL" : "LOITER");
  failsWithin(box, 2, /^the pilot has taken over/);
  const { talk, safety } = box.driver;
  const command = { command: MavCmd.NAV_RETURN_TO_LAUNCH, params: [] };
  box.run(2);
  assert.throws(() => talk.command("coming home", command).next(), { then: "off" });
  box.copter.setMode("GUIDED");
  box.goTo(1500, 400);
  staysSilent(box, 300);
  assert.throws(() => talk.command("coming home", command).next(), { message: "somebody else is in command" });
  assert.equal(safety.mayCommand().then, "off");
});

testInFlight("a command is not repeated when a pilot has taken over meanwhile", (box, kind) => {
  const { talk } = box.driver;
  const asks = talk.command("going there", { command: MavCmd.DO_REPOSITION, params: [] });
  asks.next();
  box.driver.vehicle.mode = kind === "px4" ? 3 << 16 : 5;
  box.now += 0.6;
  assert.throws(() => asks.next(), /the pilot has taken over/);
});

testInFlight("the pilot takes over while it comes home", (box, kind) => {
  box.tell({ type: "bye", reason: "over" });
  box.until(() => box.copter.mode === "RTL", 5);
  box.run(10);
  box.copter.setMode(kind === "px4" ? "POSCTL" : "LOITER");
  box.run(3);
  staysSilent(box, 300);
  assert.equal(box.kept, null);
});

testInFlight("low battery: comes home", (box) => {
  box.copter.battery_percent = 24.9;
  failsWithin(box, 2.5, /^its battery is low: 24 %/);
  box.until(() => box.copter.mode === "RTL", 3);
  box.landed();
  assert.ok(box.distanceTo(START) < 3);
  box.until(() => box.kept === null, 30);
});

testInFlight("link cut for 2 s: it goes on", (box) => {
  const from = box.now;
  box.loses = () => box.now < from + 2;
  box.until(() => box.said("arrived", 1).length, 300);
  assert.equal(box.failure, null);
  assert.ok(!box.copter.history.some(([, mode]) => mode === "RTL"));
});

testInFlight("link cut for 60 s: the mission hears of it, the autopilot comes home by itself, nobody interferes", (box) => {
  const from = box.now;
  box.loses = () => box.now < from + 60;
  failsWithin(box, 3.5, /^its link is lost: nothing heard for 3 s/);
  box.until(() => box.copter.mode === "RTL", 12);
  box.until(() => box.now > from + 60, 60);
  staysSilent(box, 5);
  box.landed();
  assert.ok(box.distanceTo(START) < 3);
  box.until(() => box.kept === null, 60);
});

testInFlight("only what it sends arrives no more: the same", (box) => {
  const from = box.now;
  box.loses = ({ direction }) => direction === "down" && box.now < from + 60;
  failsWithin(box, 3.5, /^its link is lost/);
  // It hears us still, so it does nothing by itself: it comes home as soon as it is heard.
  box.until(() => box.copter.mode === "RTL", 70);
  box.landed();
});

testInFlight("only what we send arrives no more: it comes home by itself", (box) => {
  box.loses = ({ direction }) => direction === "up";
  failsWithin(box, 13, /^it went to (RTL|RETURN) by itself \(GCS Failsafe\)/);
  box.loses = () => false;
  box.run(20);
  assert.notEqual(box.kept, null, "on its way it needs what was set");
  box.landed();
  assert.ok(box.distanceTo(START) < 3);
  box.until(() => box.kept === null, 30);
});

testInFlight("position lost: lands", (box) => {
  box.copter.hasFix = false;
  failsWithin(box, 4.5, /^(its position is lost for 3 s|it went to LAND by itself)/);
  box.until(() => box.copter.mode === "LAND", 3);
  box.landed();
});

test("position lost, and the autopilot does nothing: lands", () => {
  const box = new Box().flying();
  box.copter.settings.FS_EKF_ACTION = 0;
  box.copter.hasFix = false;
  failsWithin(box, 4.5, /^its position is lost for 3 s/);
  box.until(() => box.copter.mode === "LAND", 1);
  box.landed();
});

test("another fix is bad, but for a moment: it goes on", () => {
  const box = new Box().flying();
  box.copter.settings.FS_EKF_ACTION = 0;
  box.copter.hasFix = false;
  box.run(2);
  box.copter.hasFix = true;
  box.until(() => box.said("arrived", 1).length, 300);
  assert.equal(box.failure, null);
});

testInFlight("fence touched: the autopilot comes home by itself", (box) => {
  box.copter.at.east = -600;  // blown away
  failsWithin(box, 2, /^(it is outside the area|it went to (RTL|RETURN) by itself \(Fence Breached\)|its fence is touched)/);
  box.landed();
  assert.ok(box.distanceTo(START) < 3);
  assert.equal(box.copter.breaches, 1);
});

testInFlight("its fence is touched, it says: comes home", (box) => {
  box.driver.hearFrame({ system: 3, component: 1, name: "FENCE_STATUS", message: { breachStatus: 1 } });
  failsWithin(box, 0.1, /^its fence is touched, it says$/);
  box.landed();
});

testInFlight("outside the area, but not of its fence: comes home", (box) => {
  box.copter.at.north = -412;
  failsWithin(box, 2, /^it is outside the area/);
  box.landed();
});

testInFlight("too high: comes home", (box) => {
  box.copter.at.up = 90;
  failsWithin(box, 2, /^(it is outside the area|it went to)/);
  box.landed();
});

testInFlight("disarmed in flight: hands off", (box) => {
  box.copter.armed = false;
  failsWithin(box, 2, /^it has disarmed in flight/);
  staysSilent(box, 60);
});

testInFlight("a place outside the area is commanded never", (box) => {
  const before = box.protocol.commands("DO_REPOSITION").length;
  box.goTo(AREA.width_m + 50, 100);
  failsWithin(box, 2, /is outside the area$/);
  assert.equal(box.protocol.commands("DO_REPOSITION").length, before);
  box.landed();
});

testInFlight("the driver is killed: the autopilot comes home by itself, the next driver puts its settings back", (box) => {
  const options = box.driver.options;
  box.isDead = true;
  box.until(() => box.copter.mode === "RTL", 12);
  box.landed();
  assert.notEqual(box.kept, null);
  box.startDriver(options);
  box.driver.restore();
  box.until(() => box.driver.exitCode !== null, 60);
  assert.equal(box.driver.exitCode, 0);
  assert.equal(box.kept, null);
  assert.equal(box.copter.settings.FS_GCS_ENABLE ?? box.copter.settings.NAV_DLL_ACT, 0);
});

test("settings are not put back in the air, and not where nobody answers", () => {
  for (const loses of [() => false, () => true]) {
    const box = new Box().flying();
    box.startDriver(box.driver.options);
    box.loses = loses;
    box.driver.restore();
    box.until(() => box.driver.exitCode !== null, 40);
    assert.equal(box.driver.exitCode, 1);
    assert.notEqual(box.kept, null);
    assert.equal(box.failure, null, "there is no mission to tell");
  }
});

testInFlight("a second driver in the air commands nothing", (box) => {
  const options = box.driver.options;
  box.startDriver(options);
  box.tell({ ...box.greeting, mission_s: box.now, at: box.referee.seen.at });
  const took = box.until(() => box.failure, 5);
  assert.ok(took < 3);
  assert.equal(box.failure, "it was armed, not by us");
  staysSilent(box, 5);
});

testInFlight("the mission is gone: comes home", (box) => {
  box.driver.bye("nobody speaks to us any more");
  box.until(() => box.copter.mode === "RTL", 1);
  box.landed();
  box.until(() => box.driver.exitCode !== null, 60);
  assert.equal(box.driver.exitCode, 0);
});

testInFlight("coming home is refused: lands", (box) => {
  box.protocol.refusals.push({ command: "NAV_RETURN_TO_LAUNCH", result: MavResult.DENIED });
  box.tell({ type: "bye", reason: "over" });
  box.until(() => box.copter.mode === "LAND", 15);
  box.landed();
});

for (const kind of KINDS) {
  test(`${kind}: arming is refused, with the autopilot's own words`, () => {
    const box = new Box({ kind }).ready();
    box.protocol.refusals.push({ command: "COMPONENT_ARM_DISARM", result: MavResult.FAILED, words: "PreArm: Compass not calibrated" });
    box.goTo(1500, 400);
    failsWithin(box, 40, /^arming is refused: FAILED \(PreArm: Compass not calibrated\)$/);
    assert.equal(box.copter.armed, false);
    box.until(() => box.kept === null, 60);
  });

  test(`${kind}: a command is refused in flight: comes home`, () => {
    const box = new Box({ kind }).flying();
    box.protocol.refusals.push({ command: "DO_REPOSITION", result: MavResult.DENIED });
    box.goTo(900, 900);
    failsWithin(box, 1, /^going there is refused: DENIED/);
    box.landed();
    assert.ok(box.distanceTo(START) < 3);
  });

  for (const command of ["DO_SET_MODE", "COMPONENT_ARM_DISARM", "NAV_TAKEOFF", "DO_REPOSITION", "DO_DIGICAM_CONTROL", "NAV_LAND", "NAV_RETURN_TO_LAUNCH"]) {
    test(`${kind}: the acknowledgement of ${command} is lost: asked again, and it goes on`, () => {
      const box = new Box({ kind });
      let lost = 0;
      box.loses = ({ name, message }) => name === "COMMAND_ACK" && message.command === MavCmd[command] && ++lost <= 1;
      box.ready();
      const to = box.goTo(800, 400, "sense");
      box.until(() => box.said("arrived", to).length, 200);
      const sense = box.order("sense", 10);
      box.until(() => box.said("done", sense).length, 30);
      const charge = box.goTo(900, 400, "charge");
      box.until(() => box.said("arrived", charge).length, 200);
      const on = box.goTo(1100, 400);
      box.until(() => box.said("arrived", on).length, 200);
      box.tell({ type: "bye", reason: "over" });
      box.until(() => box.driver.exitCode !== null, 300);
      assert.ok(lost >= 1);
      assert.equal(box.failure, null);
      assert.equal(box.driver.exitCode, 0);
    });
  }

  test(`${kind}: the acknowledgement of taking off is lost, and it is refused in the air: it has taken off`, () => {
    const box = new Box({ kind }).ready();
    box.copter.up_m_s = 0.8;
    let lost = 0;
    box.loses = ({ name, message }) => name === "COMMAND_ACK" && message.command === MavCmd.NAV_TAKEOFF && ++lost <= 1;
    box.goTo(800, 400);
    box.until(() => box.protocol.commands("NAV_TAKEOFF").length === 2, 20);
    assert.ok(box.copter.at.up > 0.1 && box.copter.at.up < 1);
    box.until(() => box.said("arrived").length, 300);
    assert.equal(box.failure, null);
  });

  test(`${kind}: a command that is repeated says so`, () => {
    const box = new Box({ kind }).ready();
    box.loses = ({ direction }) => direction === "down";
    box.goTo(800, 400);
    box.run(3);
    assert.deepEqual(box.protocol.commands("DO_SET_MODE").map(([, , { confirmation }]) => confirmation), [0, 1, 2, 3]);
  });

  test(`${kind}: it takes three seconds to do as it is told, and says so: that is waited for`, () => {
    const box = new Box({ kind }).ready();
    box.protocol.busy_s = 3;
    const to = box.goTo(800, 400, "sense");
    box.until(() => box.said("arrived", to).length, 200);
    assert.equal(box.protocol.commands("DO_REPOSITION").length, 1);
    assert.equal(box.failure, null);
  });

  test(`${kind}: nothing is answered: asked four times, half a second apart, and then it fails`, () => {
    const box = new Box({ kind }).flying();
    box.loses = ({ name, message }) => name === "COMMAND_ACK" && message.command === MavCmd.DO_REPOSITION;
    const before = box.protocol.commands("DO_REPOSITION").length;
    box.goTo(900, 900);
    failsWithin(box, 5, /^going there is not answered/);
    const times = box.protocol.commands("DO_REPOSITION").slice(before).map(([at]) => at);
    assert.equal(times.length, 4);
    for (let i = 1; i < 4; ++i) assert.ok(Math.abs(times[i] - times[i - 1] - 0.5) < 0.05);
  });

  test(`${kind}: a tenth of all messages is lost, the rest takes up to 0.2 s: it flies`, () => {
    const box = new Box({ kind });
    let random = 12345;
    const next = () => (random = (random * 1103515245 + 12345) % 2147483648) / 2147483648;
    box.loses = () => ((box.delay_s = 0.2 * next()), next() < 0.1);
    box.until(() => box.notes.some((words) => words.startsWith("ready")) || box.failure, 200, "ready");
    const to = box.goTo(1500, 900, "sense");
    box.until(() => box.said("arrived", to).length || box.failure, 400);
    assert.equal(box.failure, null);
    box.tell({ type: "bye", reason: "over" });
    box.landed();
  });
}

test("what cannot be flown is refused, with the reason, and nothing is commanded", () => {
  const cases = [
    [{ hello: { class: "worker" } }, /drives UAVs/],
    [{ hello: { origin: null } }, /no origin/],
    [{ hello: { rate: null } }, /full speed/],
    [{ hello: { rate: 60 } }, /rate 60.*--speedup/],
    [{ hello: { agent: "uav:17" } }, /125 m, above 120 m/],
    [{ at: { x_m: 900, y_m: 400 } }, /^it is 400 m from where the mission has it$/],
    [{ at: { x_m: -8, y_m: 400 }, hello: { at: { x_m: -8, y_m: 400 } } }, /stands outside the area/],
  ];
  for (const [settings, reason] of cases) {
    const box = new Box(settings);
    box.until(() => box.failure, 60);
    assert.match(box.failure, reason);
    const moves = ["COMPONENT_ARM_DISARM", "NAV_TAKEOFF", "DO_REPOSITION"].flatMap((name) => box.protocol.commands(name));
    assert.deepEqual(moves, []);
    assert.equal(box.kept, null);
  }
});

test("armed by somebody else, on the ground: hands off", () => {
  const box = new Box().ready();
  box.copter.setMode("GUIDED");
  box.copter.arm();
  failsWithin(box, 2, /^it was armed, not by us$/);
  box.goTo(1500, 400);
  staysSilent(box, 5);
});

test("as long as it has no fix it says so by waiting, and is not taken for lost", () => {
  const box = new Box();
  box.copter.hasFix = false;
  box.goTo(1500, 400);
  box.run(100);
  assert.equal(box.failure, null);
  assert.ok(answersEachTick(box));
  box.copter.hasFix = true;
  box.until(() => box.said("arrived", 1).length, 300);
  box.driver.bye("over");
});

test("a battery that is low on the ground does not fly", () => {
  const box = new Box({ battery: 24 }).ready();
  box.goTo(1500, 400);
  failsWithin(box, 2, /^its battery is low: 24 %/);
  assert.equal(box.copter.armed, false);
});

test("an autopilot that does not speak: the mission hears of it after 30 s, and the UAV flies when it is switched on", () => {
  const box = new Box();
  box.loses = () => true;
  box.goTo(1500, 400);
  const said = () => box.lines.map(([, line]) => line).filter(({ type }) => ["not_ready", "ready", "failed"].includes(type));
  const took = box.until(() => said().length, 60);
  assert.deepEqual(said(), [{ type: "not_ready", reason: "a heartbeat of system 3" }]);
  assert.ok(took > 29 && took < 31);
  box.run(1800);
  assert.equal(said().length, 1);
  box.loses = () => false;
  box.until(() => box.said("arrived", 1).length, 400);
  assert.equal(said().at(-1).type, "ready");
  assert.equal(box.failure, null);
  box.driver.bye("over");
});

test("another autopilot than ours speaks: the mission hears which", () => {
  const box = new Box({ options: { system: 4 } });
  box.run(31);
  assert.ok(box.lines.some(([, line]) => line.type === "not_ready" && line.reason === "a heartbeat of system 4 (heard: system 3)"));
  assert.equal(box.failure, null);
  box.driver.bye("over");
  assert.equal(box.driver.exitCode, 0);
});

for (const kind of ["ardupilot", "px4"]) {
  test(`${kind}: a driver that gets no processor time for seconds hears what was sent meanwhile before it judges`, () => {
    const box = new Box({ kind }).flying();
    for (const stalled_s of [1, 3.2, 4]) {
      box.isStalled = true;
      box.run(stalled_s);
      box.isStalled = false;
      box.run(10);
      assert.equal(box.failure, null, `after ${stalled_s} s: ${box.failure}`);
    }
    box.until(() => box.said("arrived", 1).length, 300);
  });

  test(`${kind}: stalls hide no lost link`, () => {
    const box = new Box({ kind }).flying();
    const from_s = box.now;
    box.loses = ({ direction }) => direction === "down";
    while (!box.failure && box.now - from_s < 20) {
      box.isStalled = Math.floor((box.now - from_s) * 10) % 8 !== 0;  // 0.7 s of each 0.8 s
      box.step();
    }
    assert.match(box.failure, /its link is lost/);
    assert.ok(box.now - from_s < 5, `${box.now - from_s} s`);
  });
}
