// Zones on the page, in Chromium: shown while they hold, added and lifted in a mission that runs. Run by browser_tests.mjs.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { before, test } from "node:test";
import { LOOKS, accessible, browser, file, json, muster, open, scrub, soon, startMission } from "./support.mjs";

/** Random_1 with these zones. */
function writeScenario(name, zones) {
  muster("scenario", "--preset", "Random_1", "--seed", "2", "--out", file(name));
  writeFileSync(file(name), JSON.stringify({ ...json(name), version: 2, air: { margin_km: 0.05, zones } }));
}

before(() => {
  writeScenario("zoned.json", [{ circle_km: [15, 15, 4], name: "airfield", from_min: 60, until_min: 120 }]);
  muster("simulate", file("zoned.json"), "--policy", "horizon", "--log", "--out", file("zoned"));
  muster("report", file("zoned"), "--reasons", "0", "--out", file("zoned.html"));
  writeScenario("free.json", []);
});

for (const [width, height, colorScheme] of LOOKS) {
  test(`zones are on the map while they hold, at ${width} x ${height}, ${colorScheme}`, async (t) => {
    const phone = width < 500;
    const page = await open(t, "zoned.html", { viewport: { width, height }, colorScheme, isMobile: phone, hasTouch: phone, reducedMotion: "reduce" }, "#fold=none");
    await accessible(page, "with zones");
    assert.ok(await page.locator("#legend-zones").isVisible());
    assert.ok(!(await page.locator("#legend-closed").isVisible()), "no road is closed");
    // The colour of the ground inside the zone, and outside.
    const ground = async (minutes) => {
      await scrub(page, minutes);
      return page.evaluate(() => {
        const map = document.getElementById("map");
        const c = Object.assign(document.createElement("canvas"), { width: map.width, height: map.height }).getContext("2d");
        c.drawImage(map, 0, 0);
        const most = new Map();
        const { parts: { map: { shown } }, state: { run: { scenario } } } = window.muster;
        const scale = map.width / map.clientWidth;
        const [x, y] = [shown.x(scenario.width_m / 2) * scale, shown.y(scenario.height_m / 2) * scale];
        const { data } = c.getImageData(x - 20, y - 20, 40, 40);
        for (let i = 0; i < data.length; i += 4) {
          const colour = `${data[i]},${data[i + 1]},${data[i + 2]}`;
          most.set(colour, (most.get(colour) ?? 0) + 1);
        }
        return [...most].sort(([, a], [, b]) => b - a)[0][0];
      });
    };
    const [early, during, late] = [await ground(30), await ground(90), await ground(150)];
    assert.equal(early, late);
    assert.notEqual(during, early);
  });
}

test("the tab Air says who is in the air, how high, and which two are nearest", async (t) => {
  const page = await open(t, "zoned.html", { viewport: { width: 1440, height: 900 }, reducedMotion: "reduce" });
  await scrub(page, 13);
  await page.locator("#tab-air").click();
  assert.match(await page.locator("#panel-body .lead").innerText(), /^\d+ UAVs in the air at 0:13:00, \d+ to \d+ m above the ground/);
  assert.ok(await page.locator("#panel-body tbody tr").count() >= 1);
  assert.equal(await page.locator("#panel-body tr.bad").count(), 0, "no two are too close");
  assert.match(await page.locator(".air-said").innerText(), /^No conflict\. As flown, uav:\d+ and uav:\d+ came nearest: .* Closest of the mission as planned/s);
  await accessible(page, "the tab Air");
  await page.locator(".air-now tbody tr").first().click();
  assert.match(await page.locator("#card-facts").innerText(), /altitude\s+\d+ m above the ground/);
  // The nearest pair of the mission: the clock goes there, and both are selected.
  const nearest = page.locator("#panel-body tbody tr").first();
  const [, pair, time] = await nearest.locator("td").allInnerTexts();
  await nearest.click();
  const selected = await page.evaluate(() => window.muster.state.allSelected.map(({ index }) => window.muster.state.run.agents[index].label));
  assert.deepEqual(selected, pair.split(", "));
  const seconds = (text) => text.split(":").reduce((sum, part) => 60 * sum + Number(part), 0);
  const now = await page.locator("#time-now").innerText();
  assert.ok(Math.abs(seconds(now) - seconds(time)) <= 1, `${now}, ${time}`);
  await page.getByText("Table: altitude of each UAV over time").click();
  await soon(async () => assert.ok(await page.locator(".air-scroll + .behind tbody tr").count() > 10));
});

test("a zone is added and lifted on the page of a mission that runs, and the log passes the audit", async (t) => {
  const { run, url, ended, said } = await startMission(t, file("free.json"), "--policy", "horizon", "--rate", "180", "--out", file("flown"));
  const page = await (await browser().newContext({ viewport: { width: 1440, height: 900 }, reducedMotion: "reduce" })).newPage();
  const wrong = [];
  page.on("pageerror", (error) => wrong.push(String(error)));
  await page.goto(url);
  await page.waitForFunction(() => document.getElementById("control-state").textContent === "control");
  assert.ok(!(await page.locator("#order-road").isVisible()), "there are no roads");
  const button = (name) => page.locator("#order").getByRole("button", { name, exact: true });
  const { width, height } = await page.locator("#map").boundingBox();
  const middle = { x: Math.round(0.5 * width), y: Math.round(0.5 * height) };
  const given = async () => {
    await button("Next").click();
    await button("Give the order").click();
    await soon(async () => assert.match(await page.locator("#order-latest").innerText(), /taken/));
  };
  const until = (n) => page.waitForFunction((zones) => (window.muster.state.run.roadChanges.at(-1)?.[1].length ?? 0) === zones, n);
  await page.locator("#order-zone").click();
  await page.locator("#map").click({ position: middle });
  await accessible(page, "the form for zones");
  await page.locator("#order input[name=radius]").fill("3");
  await page.locator("#order input[name=name]").fill("crowd");
  await given();
  await until(1);
  await page.locator("#order-zone").click();
  await page.locator("#map").click({ position: middle });
  await page.locator("#order select[name=what]").selectOption("zone_lift");
  await given();
  await until(0);
  // An area, corner by corner.
  await page.locator("#order-zone").click();
  await page.locator("#pick-area").click();
  assert.ok(!(await page.locator("#pick-area").isVisible()), "there are no three corners yet");
  for (const [x, y] of [[0.3, 0.3], [0.4, 0.3], [0.35, 0.4]]) {
    await page.locator("#map").click({ position: { x: Math.round(x * width), y: Math.round(y * height) } });
  }
  await page.getByRole("button", { name: "Use these 3 corners" }).click();
  await page.locator("#order input[name=name]").fill("smoke");
  await given();
  await until(1);
  assert.equal(await page.evaluate(() => window.muster.state.run.roadChanges.at(-1)[1][0][4][0].length), 6);
  await page.waitForFunction(() => window.muster.state.run.ended, null, { timeout: 120_000 });
  await page.context().close();
  run.kill("SIGINT");  // the page would stay
  assert.equal(await ended, 0, said());
  assert.deepEqual(wrong, []);
  muster("audit", file("flown"));
  muster("redecide", file("flown"));
});
