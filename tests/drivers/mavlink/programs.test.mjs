// The driver as a program, over UDP, TCP and a serial line, in muster drive --check, and killed.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { setTimeout } from "node:timers/promises";
import { readOptions, UsageError } from "../../../drivers/mavlink/options.mjs";
import { AT, freePort, MAIN, ORIGIN, reportIn, withPrograms } from "./programs.mjs";

const TICK_S = 10;
const SPEEDUP = 60;
const MUSTER = process.env.MUSTER_PROGRAM;
const NO_MUSTER = MUSTER ? false : "MUSTER_PROGRAM names no muster";

/** Throws where it is not refused with that reason. A program says so with exit code 2, which one of them is started for in each test. */
const isRefused = (words, reason) => assert.throws(() => readOptions(words), { constructor: UsageError, message: reason });

const driverWords = (link, folder, ...more) => [MAIN, "--connect", link, "--system", "1", "--keep", folder, "--cells", "4", "--confirm", "battery", ...more];

function hello(rate) {
  return {
    type: "hello", version: 1, agent: "uav:0", class: "uav", speed_m_s: 16, full_range_m: 30000, range_m: 30000, at: { x_m: 4000, y_m: 4000 },
    area: { width_m: 10000, height_m: 10000 }, origin: ORIGIN, rate, mission_s: 0, online_from_s: 0, online_until_s: 86400,
  };
}

const goTo = (id) => ({ type: "goto", id, mission_s: 0, to: { x_m: 4500, y_m: 4000 }, expected_s: 60, then: "wait", task: null, charging_point: null, partner: null });

/** Sends it there, and tells it the time as missions do. */
function send(driver) {
  let mission_s = 0;
  driver.say(goTo(1));
  const timer = setInterval(() => driver.say({ type: "time", mission_s: (mission_s += TICK_S) }), (1000 * TICK_S) / SPEEDUP);
  driver.ended.then(() => clearInterval(timer));
}

for (const kind of ["ardupilot", "px4"]) {
  test(`${kind}: passes muster drive --check over UDP`, { skip: NO_MUSTER }, () => withPrograms(async ({ start, copter, folder }) => {
    const port = await freePort();
    await copter(["--udp", `127.0.0.1:${port}`, "--kind", kind, "--speedup", SPEEDUP, "--changed-after", "20"].map(String));
    const command = [process.execPath, ...driverWords(`udpin:${port}`, folder, "--speedup", SPEEDUP)].map((word) => `'${word}'`).join(" ");
    const check = start(MUSTER, ["drive", "--check", command, "--rate", String(SPEEDUP), "--json"]);
    const code = await check.ended;
    assert.equal(code, 0, check.lines.join("\n"));
    const report = reportIn(check.lines);
    assert.deepEqual(report.wrong, []);
    assert.deepEqual(report.steps.map(({ what }) => what), ["goto 1", "sense 2", "goto 3", "charge 4", "goto 5", "goto 6", "goto 7"]);
    assert.equal(existsSync(join(folder, "system-1.json")), false, "its settings are put back");
  }));
}

/** A driver that is at one of these links takes off, is told bye, and comes home. */
async function flies(driver, copter) {
  driver.say(hello(SPEEDUP));
  await driver.said("hello");
  send(driver);
  await driver.said("arrived");
  driver.say({ type: "bye", reason: "it is over" });
  assert.equal(await driver.ended, 0, driver.lines.join("\n"));
  assert.ok(copter.lines.some((line) => line.endsWith("RTL armed")));
  assert.ok(copter.lines.at(-1).endsWith("disarmed"));
}

test("a port that another driver has taken, and a device that is not there, end it at once with that reason", () => withPrograms(async ({ start, copter, folder }) => {
  const port = await freePort();
  await copter(["--udp", `127.0.0.1:${port}`, "--speedup", String(SPEEDUP)]);
  const first = start(process.execPath, driverWords(`udpin:${port}`, folder, "--speedup", String(SPEEDUP)));
  first.say(hello(SPEEDUP));
  await first.line((line) => line.includes(" ready: "));
  for (const [link, reason] of [[`udpin:${port}`, /port \d+ of 127\.0\.0\.1 is taken by another program/], ["serial:/dev/there-is-none:57600", /there-is-none/]]) {
    const second = start(process.execPath, driverWords(link, folder, "--speedup", String(SPEEDUP)));
    second.say(hello(SPEEDUP));
    assert.match((await second.said("failed")).reason, reason);
    assert.equal(await second.ended, 3);
  }
}));

test("flies over TCP, which comes up later", () => withPrograms(async ({ start, copter, folder }) => {
  const port = await freePort(true);
  const driver = start(process.execPath, driverWords(`tcp:127.0.0.1:${port}`, folder, "--speedup", String(SPEEDUP)));
  await driver.line((line) => line.includes("ECONNREFUSED"));
  await flies(driver, await copter(["--tcp", String(port), "--speedup", String(SPEEDUP)]));
}));

const PTYS = `
import os, pty, select, sys, tty
ends = [pty.openpty() for _ in range(2)]
for master, slave in ends: tty.setraw(slave)
print(" ".join(os.ttyname(slave) for master, slave in ends), flush=True)
masters = [master for master, slave in ends]
while True:
    ready = select.select(masters + [0], [], [])[0]
    if 0 in ready: sys.exit()
    for master in ready: os.write(masters[1 - masters.index(master)], os.read(master, 4096))
`;
const NO_PYTHON = spawnSync("python3", ["--version"]).status === 0 ? false : "there is no python3, which has terminals";

test("flies over a serial line", { skip: NO_PYTHON }, () => withPrograms(async ({ start, copter, folder }) => {
  const ptys = start("python3", ["-c", PTYS]);
  const [ours, theirs] = (await ptys.line((line) => line.startsWith("/dev/"))).split(" ");
  const one = await copter(["--serial", theirs, "--speedup", String(SPEEDUP)]);
  await flies(start(process.execPath, driverWords(`serial:${ours}:57600`, folder, "--speedup", String(SPEEDUP))), one);
}));

test("killed: the copter comes home by itself, --restore puts its settings back", () => withPrograms(async ({ start, copter, folder }) => {
  const port = await freePort();
  const one = await copter(["--udp", `127.0.0.1:${port}`, "--speedup", String(SPEEDUP)]);
  const words = driverWords(`udpin:${port}`, folder, "--speedup", String(SPEEDUP));
  const driver = start(process.execPath, words);
  driver.say(hello(SPEEDUP));
  send(driver);
  await driver.said("arrived");
  driver.child.kill("SIGKILL");
  const from = one.lines.length;
  await one.line((line) => line.endsWith("RTL armed"), from);
  await one.line((line) => line.endsWith("RTL disarmed"), from);
  const kept = JSON.parse(readFileSync(join(folder, "system-1.json"), "utf8"));
  assert.equal(kept.settings.FS_GCS_ENABLE.value, 0);
  const again = start(process.execPath, [...words, "--restore"]);
  assert.equal(await again.ended, 0, again.lines.join("\n"));
  assert.equal(existsSync(join(folder, "system-1.json")), false);
}));

test("nobody speaks to it any more: it has sent it home before it ends", () => withPrograms(async ({ start, copter, folder }) => {
  const port = await freePort();
  const one = await copter(["--udp", `127.0.0.1:${port}`, "--speedup", String(SPEEDUP)]);
  const driver = start(process.execPath, driverWords(`udpin:${port}`, folder, "--speedup", String(SPEEDUP)));
  driver.say(hello(SPEEDUP));
  send(driver);
  await one.line((line) => line.endsWith("GUIDED armed"));
  driver.child.stdin.end();
  assert.equal(await driver.ended, 0, driver.lines.join("\n"));
  assert.ok(one.lines.some((line) => line.endsWith("RTL armed")));
}));

test("killed on its way home, as by a mission that is over: its settings are put back when it has landed", () => withPrograms(async ({ start, copter, folder }) => {
  const port = await freePort();
  const one = await copter(["--udp", `127.0.0.1:${port}`, "--speedup", String(SPEEDUP)]);
  const driver = start(process.execPath, driverWords(`udpin:${port}`, folder, "--speedup", String(SPEEDUP)));
  driver.say(hello(SPEEDUP));
  send(driver);
  await driver.said("arrived");
  driver.say({ type: "bye", reason: "it is over" });
  const from = one.lines.length;
  await one.line((line) => line.endsWith("RTL armed"), from);
  driver.child.kill("SIGKILL");
  await one.line((line) => line.endsWith("RTL disarmed"), from);
  const kept = join(folder, "system-1.json");
  for (let n = 0; n < 200 && existsSync(kept); ++n) await setTimeout(100);
  assert.equal(existsSync(kept), false);
}));

test("two UAVs, one driver each, by system id", () => withPrograms(async ({ start, copter, folder }) => {
  const ports = [await freePort(), await freePort()];
  const drivers = [];
  for (const [i, port] of ports.entries()) {
    await copter(["--udp", `127.0.0.1:${port}`, "--speedup", String(SPEEDUP), "--system", String(i + 1)]);
    const words = [MAIN, "--connect", `udpin:${port}`, "--system", String(i + 1), "--keep", folder, "--cells", "4", "--confirm", "battery", "--speedup", String(SPEEDUP)];
    drivers.push(start(process.execPath, words));
  }
  for (const [i, driver] of drivers.entries()) {
    driver.say({ ...hello(SPEEDUP), agent: `uav:${i}` });
    send(driver);
  }
  await Promise.all(drivers.map((driver) => driver.said("arrived")));
  const altitudes = drivers.map((driver) => driver.lines.find((line) => line.includes(" ready: ")));
  assert.match(altitudes[0], /at 40 m/);
  assert.match(altitudes[1], /at 45 m/);
}));

test("signs with a key, believes nobody who does not, and says what it has passed over", () => withPrograms(async ({ start, copter, folder }) => {
  const port = await freePort(), hex = "0123456789abcdef".repeat(4), path = join(folder, "key");
  writeFileSync(path, `${hex}\n`, { mode: 0o644 });
  const words = driverWords(`udpin:${port}`, folder, "--speedup", String(SPEEDUP), "--sign-key", path);
  const stranger = await copter(["--udp", `127.0.0.1:${port}`]);
  const driver = start(process.execPath, words);
  await driver.line((line) => line === `mavlink: others can read the key: chmod 600 ${path}`);
  await flies(driver, await copter(["--udp", `127.0.0.1:${port}`, "--speedup", String(SPEEDUP), "--sign-key", hex]));
  assert.match(await driver.line((line) => line.includes("passed over")), /^mavlink: \d+ messages were not signed with our key/);
  assert.deepEqual(stranger.lines.map((line) => line.split(" ").slice(1).join(" ")), ["STABILIZE disarmed"], "it is told nothing");
}));

test("a key that is none is refused", () => withPrograms(async ({ folder }) => {
  const path = join(folder, "key");
  const words = ["--connect", "udpin:1", "--system", "1", "--sign-key", path];
  const { status, stderr } = spawnSync(process.execPath, [MAIN, ...words], { encoding: "utf8", input: "" });
  assert.match(stderr, /--sign-key: .*key cannot be read \(ENOENT\), expected a file of 64 hex digits/);
  assert.equal(status, 2);
  for (const text of ["", "0123", "x".repeat(64), "0".repeat(65)]) {
    writeFileSync(path, text);
    isRefused(words, new RegExp(`--sign-key: .*key: found ${text.length} characters, expected 64 hex digits`));
  }
}));

test("a command line that cannot be is refused", () => {
  const run = (...words) => spawnSync(process.execPath, [MAIN, ...words], { encoding: "utf8", input: "" });
  const { status, stderr } = run();
  assert.equal(status, 2, stderr);
  assert.match(stderr, /--connect: found ''/);
  const cases = [
    [["--connect", "udp:1", "--system", "1"], /--connect: found 'udp:1'/], [["--connect", "udpin:1"], /--system: found ''/],
    [["--connect", "tcp:5760", "--system", "1"], /--connect/], [["--connect", "udpin:1", "--system", "1", "--camera", "x"], /--camera/],
    [["--connect", "udpin:99999", "--system", "1"], /--connect/], [["--connect", "udpin:1", "--system", "1", "--none"], /none/],
    [["--connect", "udpin:1", "--system", "1", "--reserve", "5"], /--reserve: found '5', expected a number from 10 to 80/],
    [["--connect", "udpin:1", "--system", "1", "--land-idle", "-1"], /--land-idle/],
    [["--connect", "udpin:1", "--system", "1", "--land-idle", "soon"], /--land-idle: found 'soon', expected a number from 0 to 86400/],
  ];
  for (const [words, reason] of cases) isRefused(words, reason);
  assert.equal(run("--help").status, 0);
  assert.equal(run("--connect", "serial:/dev/none:57600", "--system", "1").status, 3);
});

const ARDUCOPTER = process.env.ARDUCOPTER;

test("ArduPilot's own Copter passes muster drive --check", { skip: ARDUCOPTER ? NO_MUSTER : "ARDUCOPTER names no arducopter" }, () =>
  withPrograms(async ({ start, folder }) => {
    const port = await freePort(), speedup = "10";
    start(ARDUCOPTER, ["--model", "quad", "--wipe", "--speedup", speedup, "--home", `${AT},12,0`, "--serial0", `udpclient:127.0.0.1:${port}`], { cwd: folder });
    const command = [process.execPath, ...driverWords(`udpin:${port}`, folder, "--speedup", speedup, "--camera", "none", "--charged", "1", "--cells", "3")].map((word) => `'${word}'`).join(" ");
    const check = start(MUSTER, ["drive", "--check", command, "--rate", speedup]);
    assert.equal(await check.ended, 0, check.lines.join("\n"));
  }));
