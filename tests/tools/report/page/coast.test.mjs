// The coast below the map, in Chromium, of a made-up one. Run by browser_tests.mjs.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { before, test } from "node:test";
import { deflateSync, inflateSync } from "node:zlib";
import { planeOf } from "../../../../tools/report/page/place.js";
import { LOOKS, MUSTER_SCENARIOS, accessible, file, muster, open, picture, soon } from "./support.mjs";

const DATA = /(x-muster-run">)([^<]*)(<)/;
/** Land in the south of haiti's area, with a bay of 0.1 degrees in it and an island further north: 1e-5 degrees. */
const COAST = { source: "made up", box: [1820000, -7280000, 1890000, -7200000],
  rings: [[1820000, -7280000, 0, 80000, 35000, 0, 0, -40000, -10000, 0, 0, -10000, 10000, 0, 0, -30000],
    [1860000, -7235000, 2000, 0, 0, 2000, -2000, 0]] };
const ORIGIN = [18.411458, -72.466874];

before(() => {
  muster("simulate", join(MUSTER_SCENARIOS, "haiti.json"), "--policy", "greedy-nearest", "--log", "--out", file("haiti"));
  muster("report", file("haiti"), "--coast", "none", "--reasons", "0", "--out", file("bare.html"));
  const bare = readFileSync(file("bare.html"), "utf8");
  const run = JSON.parse(inflateSync(Buffer.from(bare.match(DATA)[2], "base64")));
  assert.equal(run.coast, undefined);
  run.coast = COAST;
  writeFileSync(file("coast.html"), bare.replace(DATA, (_, head, __, tail) => head + deflateSync(JSON.stringify(run)).toString("base64") + tail));
});

/** Colours of the map at degrees, beside what the style sheet calls them. */
const coloursAt = (page, places) => page.evaluate(async (wanted) => {
  await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
  const canvas = document.getElementById("map");
  const scale = canvas.width / canvas.clientWidth;
  const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  const probe = document.createElement("canvas").getContext("2d");
  probe.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--water").trim();
  probe.fillRect(0, 0, 1, 1);
  const water = [...probe.getImageData(0, 0, 1, 1).data].join();
  return wanted.map((place) => {
    const { shown } = window.muster.parts.map;
    const [x, y] = [shown.x(place.x), shown.y(place.y)];
    const at = 4 * (Math.round(y * scale) * canvas.width + Math.round(x * scale));
    return [...pixels.slice(at, at + 4)].join() === water;
  });
}, places.map((degrees) => planeOf({ scenario: { origin: ORIGIN } }, ...degrees)));

for (const [width, height, colorScheme] of LOOKS) {
  test(`water is filled and land is not, at ${width} x ${height}, ${colorScheme}`, async (t) => {
    const page = await open(t, "coast.html", { viewport: { width, height }, colorScheme }, "#t=0&fold=none");
    await soon(async () => assert.ok(await page.locator("#legend-water").isVisible()));
    assert.equal(await page.locator("#legend-water").innerText(), "water (made up)");
    // Sea, the bay in the land, the island, land: away from the lines of the grid and from agents.
    assert.deepEqual(await coloursAt(page, [[18.6473, -72.4637], [18.4853, -72.4273], [18.6113, -72.3413], [18.4273, -72.2613]]), [true, true, false, false]);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width);
    await accessible(page, "with a coast");
  });
}

test("without a coast the map is as it was, and the scene's ground has it too", async (t) => {
  const bare = await open(t, "bare.html", {}, "#t=0");
  const with_ = await open(t, "coast.html", {}, "#t=0");
  await soon(async () => assert.ok(!(await bare.locator("#legend-water").isVisible())));
  assert.notEqual(await picture(bare, "map"), await picture(with_, "map"));
  const blue = [];
  for (const page of [bare, with_]) {
    await page.locator("#tab-scene").click();
    await page.waitForFunction(() => document.getElementById("scene").dataset.drawn);
    blue.push(await picture(page, "scene"));
  }
  assert.notEqual(blue[0], blue[1]);
});

test("what cannot be is refused", () => {
  assert.throws(() => muster("report", file("a"), "--coast", file("none.nc"), "--out", file("no.html")), /has no origin/);
  assert.throws(() => muster("report", file("haiti"), "--coast", file("none.nc"), "--out", file("no.html")), /none\.nc: /);
});
