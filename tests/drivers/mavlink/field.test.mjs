// Whole missions over LCM with the test copter: the field test, and what becomes of a task whose UAV fails.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { distance_m, MissionMap } from "../../../drivers/places.mjs";
import { freePort, MAIN, withPrograms } from "./programs.mjs";

const RATE = 20;  // faster, and a busy machine is late by more than a flight forgives
const MUSTER = process.env.MUSTER_PROGRAM;
const NO_MUSTER = MUSTER ? false : "MUSTER_PROGRAM names no muster";
const ROOT = join(dirname(fileURLToPath(import.meta.url)), "../../..");
const FIELD_TEST = join(ROOT, "scenarios/field_test.json");
const FOLLOWER = `python3 '${join(ROOT, "examples/drivers/uav.py")}'`;  // goes where it is sent, as fast as it is told

/**
 * A copter where the scenario has uav:0, and muster run with a driver for it. `more`: other words of the copter; `options`: of
 * muster run.
 */
async function fly({ start, copter, folder }, scenario, more, drivers = {}, options = []) {
  const { origin, uavs } = JSON.parse(readFileSync(scenario, "utf8"));
  const at = new MissionMap(origin).toDegrees({ x_m: 1000 * uavs[0].x_km, y_m: 1000 * uavs[0].y_km });
  const port = await freePort();
  const one = await copter(["--at", `${at.latitude_deg},${at.longitude_deg}`, "--udp", `127.0.0.1:${port}`, "--speedup", String(RATE),
    "--drain", "0.06", "--changed-after", "60", ...more]);
  const words = [process.execPath, MAIN, "--connect", `udpin:${port}`, "--system", "1", "--speedup", RATE, "--keep", folder, "--cells", "4", "--confirm", "battery"];
  const command = `sh -c 'echo $$ > "${folder}/driver.pid"; exec ${words.map((word) => `"${word}"`).join(" ")}'`;
  const run = join(folder, "run");
  const mission = start(MUSTER, ["run", scenario, "--rate", String(RATE), "--quiet", "--out", run, ...options,
    ...Object.entries({ "uav:0": command, ...drivers }).flatMap(([agent, driver]) => ["--driver", `${agent}=${driver}`])]);
  return { one, mission, run };
}

async function reportOf({ mission, run }, start) {
  assert.equal(await mission.ended, 0, mission.lines.join("\n"));
  for (const command of ["audit", "redecide"]) {
    const check = start(MUSTER, [command, run]);
    assert.equal(await check.ended, 0, check.lines.join("\n"));
  }
  return JSON.parse(readFileSync(join(run, "report.json"), "utf8"));
}

test("the field test: three places sensed, the battery changed once", { skip: NO_MUSTER }, () => withPrograms(async (programs) => {
  const flight = await fly(programs, FIELD_TEST, ["--battery", "60"], { "worker:0": FOLLOWER, "vehicle:0": FOLLOWER });
  const report = await reportOf(flight, programs.start);
  assert.equal(report.tasks_done, 3);
  assert.equal(report.charges, 1);
  assert.deepEqual(report.failed_agents, []);
  assert.deepEqual(report.measured_agents.map(({ agent }) => agent), ["uav:0", "worker:0", "vehicle:0"]);
  const late_s = report.measured_agents[0].legs.filter((leg) => leg.arrived_s !== null).map((leg) => leg.arrived_s - leg.planned_s);
  assert.ok(late_s.length >= 3 && late_s.every((late) => late > -2), `climbing takes time that is not planned: ${late_s}`);
  const landings = flight.one.lines.filter((line) => line.endsWith("LAND disarmed"));
  // At the charging point; and at home, if the mission does not end before it has had nothing to do for long.
  assert.ok([1, 2].includes(landings.length), flight.one.lines.join("\n"));
}));

/** The last place of the field test, and its worker beside it, in a mission that takes zones. */
function withZones(folder) {
  const scenario = JSON.parse(readFileSync(FIELD_TEST, "utf8"));
  const [first] = scenario.uavs, { cost_km, ...place } = scenario.tasks[2];
  first.range_km = first.full_range_km;
  Object.assign(scenario, { version: 2, air: {}, limit_min: 16, tasks: [{ ...place, id: 0, cost_km }] });
  Object.assign(scenario.workers[0], { x_km: place.x_km - 0.02, y_km: place.y_km });
  const path = join(folder, "scenario.json");
  writeFileSync(path, JSON.stringify(scenario));
  return path;
}

test("a zone is added in flight between the UAV and its place: it is in its fence, and it flies around it, there and home", { skip: NO_MUSTER }, () => withPrograms(async (programs) => {
  const flight = await fly(programs, withZones(programs.folder), ["--track"], { "worker:0": FOLLOWER, "vehicle:0": FOLLOWER }, ["--take-orders"]);
  await flight.one.line((line) => line.endsWith("is up"));
  const order = programs.start(MUSTER, ["zone", "add", flight.run, "--circle", "0.38,0.275,0.04", "--id", "heli"]);
  assert.equal(await order.ended, 0, order.lines.join("\n"));
  await flight.one.line((line) => line.endsWith("keeps out of 1"));
  // It would come home by itself if it touched the zone.
  const report = await reportOf(flight, programs.start);
  assert.deepEqual(report.failed_agents, []);
  assert.equal(report.tasks_done, 1);
  const { lines } = flight.one, map = new MissionMap(JSON.parse(readFileSync(FIELD_TEST, "utf8")).origin);
  await flight.one.line((line) => line.endsWith("RTL disarmed"), lines.findIndex((line) => line.endsWith("is up")));
  const middle = { x_m: 380, y_m: 275 }, away_m = trackOf(flight.one, map).map((at) => distance_m(at, middle));
  assert.ok(Math.min(...away_m) > 60, `${Math.min(...away_m)} m from the middle of a zone of 40 m and its margin of 30 m`);
}));

/** Where a copter that tells it was: {unix_ms, x_m, y_m, up_m}. */
function trackOf({ lines }, map) {
  return lines.filter((line) => line.startsWith("track ")).map((line) => JSON.parse(line.slice(6)))
    .map(({ unix_ms, up_m, ...at }) => ({ unix_ms, up_m, ...map.toMetres(at) }));
}

/** Two UAVs whose ways cross in the middle, a worker at each end. */
function withCrossing(folder, air) {
  const scenario = JSON.parse(readFileSync(FIELD_TEST, "utf8"));
  const [uav] = scenario.uavs, [worker] = scenario.workers, [task] = scenario.tasks;
  const ends = [{ x_km: 0.7, y_km: 0.3 }, { x_km: 0.4, y_km: 0.59 }];
  Object.assign(scenario, {
    version: 2, limit_min: 10, air,
    uavs: [{ x_km: 0.1, y_km: 0.3 }, { x_km: 0.4, y_km: 0 }].map((at, id) => ({ ...uav, ...at, id, range_km: uav.full_range_km })),
    workers: ends.map((at, id) => ({ ...worker, ...at, id })),
    tasks: ends.map((at, id) => ({ ...task, ...at, id, name: `end ${id}` })),
  });
  const path = join(folder, "scenario.json"), orders = join(folder, "orders.jsonl");
  writeFileSync(path, JSON.stringify(scenario));
  writeFileSync(orders, [0, 1].map((id) => JSON.stringify({ order: "pin", task: id, agents: [`uav:${id}`, `worker:${id}`], at_min: 0, id: `pin ${id}` })).join("\n"));
  return { scenario, path, orders };
}

/** Metres, while both are in the air: the least across, how far up it is then, and the least up of those within 50 m across. */
function nearest(one, other, map) {
  const others = trackOf(other, map);
  const distances = trackOf(one, map).map((here) => {
    const there = others.reduce((a, b) => (Math.abs(b.unix_ms - here.unix_ms) < Math.abs(a.unix_ms - here.unix_ms) ? b : a));
    const isUp = here.up_m > 1 && there.up_m > 1;
    return { across_m: isUp ? Math.hypot(here.x_m - there.x_m, here.y_m - there.y_m) : Infinity, up_m: Math.abs(here.up_m - there.up_m) };
  });
  const least = distances.reduce((a, b) => (b.across_m < a.across_m ? b : a));
  return { ...least, near_m: Math.min(...distances.filter(({ across_m }) => across_m < 50).map(({ up_m }) => up_m)) };
}

test("two UAVs whose ways cross: without separation they meet, with it they are apart", { skip: NO_MUSTER }, () => withPrograms(async ({ start, copter, folder }) => {
  const found = [];
  for (const air of [{ separation: false }, {}]) {
    const { scenario, path, orders } = withCrossing(folder, air), map = new MissionMap(scenario.origin);
    const copters = [], drivers = {};
    for (const [id, { x_km, y_km }] of scenario.uavs.entries()) {
      const at = map.toDegrees({ x_m: 1000 * x_km, y_m: 1000 * y_km }), port = await freePort();
      copters.push(await copter(["--at", `${at.latitude_deg},${at.longitude_deg}`, "--udp", `127.0.0.1:${port}`, "--speedup", String(RATE), "--track"]));
      drivers[`uav:${id}`] = [process.execPath, MAIN, "--connect", `udpin:${port}`, "--system", "1", "--speedup", RATE, "--keep", join(folder, String(id)),
        "--cells", "4", "--confirm", "battery"].map((word) => `"${word}"`).join(" ");
    }
    const run = join(folder, air.separation === false ? "meets" : "apart");
    const mission = start(MUSTER, ["run", path, "--rate", String(RATE), "--quiet", "--out", run, "--orders", orders,
      ...Object.entries({ ...drivers, "worker:0": FOLLOWER, "worker:1": FOLLOWER }).flatMap(([agent, driver]) => ["--driver", `${agent}=${driver}`])]);
    const report = await reportOf({ mission, run }, start);
    assert.equal(report.tasks_done, 2, mission.lines.join("\n"));
    found.push(nearest(...copters, map));
  }
  const [meets, apart] = found;
  process.stdout.write(`without separation ${meets.across_m.toFixed(1)} m across and ${meets.up_m.toFixed(1)} m up, with it `
    + `${apart.across_m.toFixed(1)} and ${apart.up_m.toFixed(1)}\n`);
  assert.ok(meets.across_m < 50 && meets.up_m < 8, JSON.stringify(meets));
  assert.ok(apart.near_m > 9, JSON.stringify(apart));
}));

/** Two places, of which the second has its worker later, and few decisions. */
function withPause(folder) {
  const scenario = JSON.parse(readFileSync(FIELD_TEST, "utf8"));
  const [uav] = scenario.uavs, [worker] = scenario.workers, [first, second] = scenario.tasks;
  Object.assign(scenario, { interval_min: 5, limit_min: 25, tasks: [first, second] });
  uav.range_km = uav.full_range_km;
  scenario.workers = [{ ...worker, x_km: first.x_km, y_km: first.y_km, online_until_min: 13 },
    { ...worker, id: 1, x_km: second.x_km, y_km: second.y_km, online_from_min: 14 }];
  const path = join(folder, "scenario.json");
  writeFileSync(path, JSON.stringify(scenario));
  return path;
}

test("a UAV with nothing to do stands at home until its next task", { skip: NO_MUSTER }, () => withPrograms(async (programs) => {
  const flight = await fly(programs, withPause(programs.folder), []);
  const report = await reportOf(flight, programs.start);
  assert.deepEqual(report.failed_agents, []);
  assert.equal(report.tasks_done, 2);
  const doing = flight.one.lines.filter((line) => /armed$/.test(line)).map((line) => line.split(" ").slice(1).join(" "));
  const landed = doing.indexOf("LAND disarmed");
  assert.ok(landed > 0 && doing.indexOf("GUIDED armed", landed) > landed, doing.join("\n"));
}));

/** The first place of the field test, with a second UAV, computed, that comes after two minutes. */
function withSecond(folder) {
  const scenario = JSON.parse(readFileSync(FIELD_TEST, "utf8"));
  const [first] = scenario.uavs;
  Object.assign(scenario, { interval_min: 1, limit_min: 9, tasks: scenario.tasks.slice(0, 1) });
  scenario.uavs.push({ ...first, id: 1, range_km: first.full_range_km, online_from_min: 2 });
  Object.assign(scenario.workers[0], { x_km: 0.3, y_km: 0.2 });
  const path = join(folder, "scenario.json");
  writeFileSync(path, JSON.stringify(scenario));
  return path;
}

const FAULTS = [
  ["the pilot takes over", ["--battery", "60", "--pilot-at", "180"], /the pilot has taken over/],
  ["the battery is low", ["--battery", "60", "--drain", "0.25"], /battery/],
  ["the link is cut for ever", ["--battery", "60", "--cut", "180:1e9"], /its link is lost/],
];

for (const [name, words, reason] of FAULTS) {
  test(`${name}: another UAV does the task`, { skip: NO_MUSTER }, () => withPrograms(async (programs) => {
    const flight = await fly(programs, withSecond(programs.folder), words);
    const report = await reportOf(flight, programs.start);
    assert.deepEqual(report.failed_agents.map(({ agent }) => agent), ["uav:0"]);
    assert.match(report.failed_agents[0].why, reason);
    assert.deepEqual(report.tasks.map(({ status, uav }) => [status, uav]), [["done", 1]]);
  }));
}

test("the driver is killed: the UAV comes home, another does the task", { skip: NO_MUSTER }, () => withPrograms(async (programs) => {
  const flight = await fly(programs, withSecond(programs.folder), ["--battery", "60"]);
  await flight.one.line((line) => line.endsWith("is up"));
  process.kill(Number(readFileSync(join(programs.folder, "driver.pid"), "utf8")), "SIGKILL");
  await flight.one.line((line) => line.endsWith("RTL armed"));
  const report = await reportOf(flight, programs.start);
  assert.match(report.failed_agents[0].why, /killed|signal/);
  assert.deepEqual(report.tasks.map(({ status, uav }) => [status, uav]), [["done", 1]]);
}));

test("the mission is killed: the UAV comes home", { skip: NO_MUSTER }, () => withPrograms(async (programs) => {
  const flight = await fly(programs, withSecond(programs.folder), ["--battery", "60"]);
  await flight.one.line((line) => line.endsWith("is up"));
  flight.mission.child.kill("SIGKILL");
  await flight.one.line((line) => line.endsWith("RTL armed"));
  await flight.one.line((line) => line.endsWith("RTL disarmed"));
}));
