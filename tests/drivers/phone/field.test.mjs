// The field test as it is meant: the UAV by MAVLink, the worker and the vehicle with a phone each, in Chromium. MUSTER_FIELD_RATE
// flies it at another rate; MUSTER_FIELD_RUN keeps the run directory there. Faster than life it begins two minutes later, so that
// pages are open by then, and with a battery that forgives waiting.
import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { existsSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { distance_m, MissionMap } from "../../../drivers/places.mjs";
import { freePort, MAIN as MAVLINK, withPrograms } from "../mavlink/programs.mjs";
import { bePerson } from "./person.mjs";
import { MAIN as PHONE } from "./programs.mjs";

const { MUSTER_CHROMIUM, MUSTER_WORK, MUSTER_PROGRAM, MUSTER_FIELD_RATE, MUSTER_FIELD_RUN } = process.env;
const RATE = Number(MUSTER_FIELD_RATE ?? 20);
const FIELD_TEST = join(dirname(fileURLToPath(import.meta.url)), "../../../scenarios/field_test.json");
const { chromium } = createRequire(join(MUSTER_WORK, "package.json"))("playwright-core");

let browser = null;
before(async () => {
  // The sandbox wants namespaces, which root in a container has not.
  browser = await chromium.launch({ executablePath: MUSTER_CHROMIUM, chromiumSandbox: process.getuid() !== 0 });
});
after(() => browser?.close());

const commandOf = (...words) => [process.execPath, ...words].map((word) => `'${word}'`).join(" ");
const metres = ({ x_km, y_km }) => ({ x_m: 1000 * x_km, y_m: 1000 * y_km });

const LATER_MIN = 2;
const hasPackages = existsSync(join(dirname(MAVLINK), "node_modules/node-mavlink")) || process.env.MUSTER_DRIVERS === "required";
const CANNOT = [!MUSTER_PROGRAM && "MUSTER_PROGRAM names no muster", !hasPackages && "node-mavlink is not installed"].find(Boolean) ?? false;

/** The scenario, and the words for the copter's battery. */
function fieldTest(folder) {
  const scenario = JSON.parse(readFileSync(FIELD_TEST, "utf8"));
  if (RATE === 1) return { scenario, path: FIELD_TEST, battery: ["--battery", "60", "--drain", "0.06"] };
  scenario.limit_min += LATER_MIN;
  for (const spec of [scenario.uavs, scenario.workers, scenario.vehicles].flat()) {
    spec.online_from_min += LATER_MIN;
    spec.online_until_min += LATER_MIN;
  }
  const path = join(folder, "scenario.json");
  writeFileSync(path, JSON.stringify(scenario));
  return { scenario, path, battery: ["--battery", "80", "--drain", "0.05"] };
}

/** The link that the driver of that agent keeps in the run directory. */
async function linkOf(run, agent, isOver) {
  const path = join(run, "phones", `${agent.replace(":", "-")}.json`);
  while (!existsSync(path)) {
    if (isOver()) throw new Error(`the mission has ended, and ${agent} had no link`);
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
  return JSON.parse(readFileSync(path, "utf8")).url;
}

function photosIn(run, agent) {
  const folder = join(run, "photos");
  const names = readdirSync(folder).filter((name) => name.startsWith(`${agent.replace(":", "-")}_`) && name.endsWith(".json"));
  const found = names.map((name) => JSON.parse(readFileSync(join(folder, name), "utf8"))).sort((a, b) => a.mission_s - b.mission_s);
  for (const { photo, bytes, sha256 } of found.filter((words) => words.photo)) {
    const content = readFileSync(join(folder, photo));
    assert.deepEqual([content.length, createHash("sha256").update(content).digest("hex")], [bytes, sha256]);
  }
  return found;
}

test(`at rate ${RATE}: three places, a battery changed, a photo of each place by the worker and by the UAV`, { skip: CANNOT }, () =>
  withPrograms(async ({ start, copter, folder }) => {
    const { scenario, path, battery } = fieldTest(folder), { origin } = scenario;
    const at = new MissionMap(origin).toDegrees(metres(scenario.uavs[0])), port = await freePort(), run = MUSTER_FIELD_RUN ?? join(folder, "run");
    const one = await copter(["--at", `${at.latitude_deg},${at.longitude_deg}`, "--udp", `127.0.0.1:${port}`, "--speedup", String(RATE),
      "--changed-after", "60", ...battery]);
    const phone = commandOf(PHONE, "--run", run);
    const mavlink = commandOf(MAVLINK, "--connect", `udpin:${port}`, "--system", "1", "--speedup", RATE, "--keep", folder, "--confirm", "battery", "--run", run);
    const mission = start(MUSTER_PROGRAM, ["run", path, "--policy", "rollout", "--rate", String(RATE), "--quiet", "--out", run,
      "--driver", `uav:0=${mavlink}`, "--driver", `worker:0=${phone}`, "--driver", `vehicle:0=${phone}`]);
    let isEnded = false;
    mission.ended.then(() => (isEnded = true));
    const people = await Promise.all([["worker:0", scenario.workers[0]], ["vehicle:0", scenario.vehicles[0]]].map(async ([agent, spec]) => {
      const link = await linkOf(run, agent, () => isEnded);
      return bePerson({ browser, link, origin, at: metres(spec), speed_m_s: (1000 * spec.speed_km_per_min) / 60, rate: RATE, takesPhotos: agent === "worker:0",
        note: (words) => console.log(`${agent}: ${words}`), isOver: () => isEnded });
    }));
    assert.equal(await mission.ended, 0, mission.lines.join("\n"));
    for (const command of ["audit", "redecide"]) {
      const check = start(MUSTER_PROGRAM, [command, run]);
      assert.equal(await check.ended, 0, check.lines.join("\n"));
    }
    console.log(mission.lines.join("\n"));
    const report = JSON.parse(readFileSync(join(run, "report.json"), "utf8"));
    assert.deepEqual([report.tasks_done, report.charges, report.failed_agents], [3, 1, []]);
    assert.deepEqual(report.measured_agents.map(({ agent }) => agent), ["uav:0", "worker:0", "vehicle:0"]);
    assert.deepEqual(people.map(({ pressed }) => pressed.filter((word) => word !== "I am here")), [["Done", "Done", "Done"], ["Battery changed"]]);
    for (const [agent, near_m] of [["worker:0", 20], ["uav:0", 5]]) {
      const photos = photosIn(run, agent);
      assert.deepEqual(photos.map(({ task }) => task).sort(), [0, 1, 2], agent);
      for (const { at, task, mission_s } of photos) {
        assert.ok(distance_m(at, metres(scenario.tasks[task])) < near_m, `${agent} at ${JSON.stringify(at)} for task ${task}`);
        const [done] = report.tasks.filter(({ id }) => id === task);
        assert.ok(mission_s < done.done_s, `${agent}: task ${task} at ${mission_s} s: ${JSON.stringify(done)}`);
      }
    }
    assert.ok(photosIn(run, "worker:0").every(({ photo }) => photo?.endsWith(".png")));
    assert.equal(one.lines.filter((line) => line.endsWith("LAND disarmed")).length, 1, one.lines.join("\n"));
  }));
