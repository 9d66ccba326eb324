// Roads on the page, in Chromium: closed ones, and closing them in a mission that runs. Run by browser_tests.mjs.
import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { before, test } from "node:test";
import { LOOKS, accessible, browser, file, json, muster, open, scrub, soon, startMission } from "./support.mjs";

const STREETS = 11; // in each direction
const BLOCK_MM = 3_000_000;

/** Streets at right angles over an area of 30 km, as a road file. */
function streets() {
  const [x, y, roads] = [[], [], []];
  for (let row = 0; row < STREETS; ++row) {
    for (let column = 0; column < STREETS; ++column) {
      const at = x.length;
      x.push(column * BLOCK_MM);
      y.push(row * BLOCK_MM);
      if (column > 0) roads.push({ id: 1000 + at, class: 0, points: [at - 1, at] });
      if (row > 0) roads.push({ id: 2000 + at, class: 0, points: [at - STREETS, at] });
    }
  }
  return { version: 1, source: "made up", classes: [{ name: "street", workers_percent: 100, vehicles_percent: 100, one_way: false }], x_mm: x, y_mm: y, roads };
}

/** Random_1 on streets; `closures` as the scenario's key has them. */
function writeScenario(name, closures) {
  muster("scenario", "--preset", "Random_1", "--seed", "2", "--out", file(name));
  const roads = JSON.stringify(streets());
  writeFileSync(file("streets.roads.json"), roads);
  const scenario = { ...json(name), version: 2,
    roads: { file: "streets.roads.json", sha256: createHash("sha256").update(roads).digest("hex"), open_ground: { workers: { percent: 50, reach_km: 5 }, vehicles: { percent: 25, reach_km: 5 } }, closures } };
  writeFileSync(file(name), JSON.stringify(scenario));
}

before(() => {
  writeScenario("closed.json", [{ circle_km: [15, 15, 2], name: "rubble", from_min: 60, until_min: 120 }]);
  muster("simulate", file("closed.json"), "--policy", "horizon", "--log", "--out", file("closed"));
  muster("report", file("closed"), "--reasons", "0", "--out", file("closed.html"));
  writeScenario("open.json", []);
});

for (const [width, height, colorScheme] of LOOKS) {
  test(`closed roads are on the map while they are closed, at ${width} x ${height}, ${colorScheme}`, async (t) => {
    const phone = width < 500;
    const page = await open(t, "closed.html", { viewport: { width, height }, colorScheme, isMobile: phone, hasTouch: phone, reducedMotion: "reduce" }, "#fold=none");
    await accessible(page, "with closed roads");
    assert.ok(await page.locator("#legend-closed").isVisible());
    assert.match(await page.locator("#legend-roads").innerText(), /made up/);
    // The map less what moves on it: pictures of the red of closed roads around the middle.
    const red = async (minutes) => {
      await scrub(page, minutes);
      return page.evaluate(() => {
        const map = document.getElementById("map");
        const c = Object.assign(document.createElement("canvas"), { width: map.width, height: map.height }).getContext("2d");
        c.drawImage(map, 0, 0);
        const wanted = getComputedStyle(document.documentElement).getPropertyValue("--failed").trim();
        const probe = document.createElement("canvas").getContext("2d");
        probe.fillStyle = wanted;
        probe.fillRect(0, 0, 1, 1);
        const [r, g, b] = probe.getImageData(0, 0, 1, 1).data;
        const { data } = c.getImageData(0, 0, map.width, map.height);
        let n = 0;
        for (let i = 0; i < data.length; i += 4) if (Math.abs(data[i] - r) + Math.abs(data[i + 1] - g) + Math.abs(data[i + 2] - b) < 12) n += 1;
        return n;
      });
    };
    const [early, during, late] = [await red(30), await red(90), await red(150)];
    assert.ok(during > 4 * Math.max(early, late) + 20, `red pixels at 0:30, 1:30 and 2:30: ${[early, during, late]}`);
  });
}

test("the scene's ground has the roads that are closed at its time", async (t) => {
  const page = await open(t, "closed.html", { reducedMotion: "reduce" }, "#t=1800");
  const painted = async (minutes) => {
    await scrub(page, minutes);
    await page.waitForFunction(() => window.muster.scene && document.getElementById("scene").dataset.drawn === String(Math.round(window.muster.clock.t)));
    return page.evaluate(() => {
      const { image } = window.muster.scene.ground.mesh.material.map;
      return image.toDataURL();
    });
  };
  await page.locator("#tab-scene").click();
  const [early, during, late] = [await painted(30), await painted(90), await painted(150)];
  assert.equal(early, late);
  assert.notEqual(early, during);
});

test("three closures are given on the page of a mission that runs, and the log passes the audit", async (t) => {
  const { run, url, ended, said } = await startMission(t, file("open.json"), "--policy", "horizon", "--rate", "180", "--out", file("ran"));
  const page = await (await browser().newContext({ viewport: { width: 1440, height: 900 }, reducedMotion: "reduce" })).newPage();
  const wrong = [];
  page.on("pageerror", (error) => wrong.push(String(error)));
  await page.goto(url);
  await page.waitForFunction(() => document.getElementById("control-state").textContent === "control");
  const button = (name) => page.locator("#order").getByRole("button", { name, exact: true });
  /** Where on the map that part of the area is, east and north. */
  const at = (east, north) => page.evaluate(([x, y]) => {
    const { parts: { map: { shown } }, state: { run: { scenario } } } = window.muster;
    return { x: Math.round(shown.x(x * scenario.width_m)), y: Math.round(shown.y(y * scenario.height_m)) };
  }, [east, north]);
  for (const [i, [east, north]] of [[0.5, 0.5], [0.35, 0.4], [0.6, 0.7]].entries()) {
    await page.locator("#order-road").click();
    await page.locator("#map").click({ position: await at(east, north) });
    await page.locator("#order input[name=radius]").fill("1.5");
    await page.locator("#order input[name=name]").fill(`closure ${i + 1}`);
    if (i === 1) await page.locator("#order input[name=minutes]").fill("20");
    if (i === 0) await accessible(page, "the form for roads");
    await button("Next").click();
    await button("Give the order").click();
    await soon(async () => assert.match(await page.locator("#order-latest").innerText(), /taken/));
    await page.waitForFunction((n) => window.muster.state.run.roadChanges.length > 0 &&
      window.muster.state.run.roadChanges.some(([, closures]) => closures.some(([, name]) => name === `closure ${n}`)), i + 1);
  }
  await page.waitForFunction(() => window.muster.state.run.ended, null, { timeout: 120_000 });
  await page.context().close();
  run.kill("SIGINT");  // the page would stay
  assert.equal(await ended, 0, said());
  assert.deepEqual(wrong, []);
  muster("audit", file("ran"));
  muster("redecide", file("ran"));
  muster("log", "export", file("ran"), "--format", "csv", "--out", file("csv"));
  const closed = readFileSync(file("csv/closed_roads.csv"), "utf8").trim().split("\r\n").slice(1).map((line) => line.split(","));
  assert.deepEqual([...new Set(closed.map((cells) => cells[5]))].sort(), ["closure 1", "closure 2", "closure 3"]);
  assert.ok(closed.every(([, , , until, , name]) => (until === "") === (name !== "closure 2")));
});
