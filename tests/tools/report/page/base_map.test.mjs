// Base maps from files of tiles, in Chromium, of made-up ones; and the map's layers. Run by browser_tests.mjs.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { before, test } from "node:test";
import { degreesOf, planeOf } from "../../../../tools/report/page/place.js";
import { layer, png, pmtiles } from "./made_tiles.mjs";
import { LOOKS, MUSTER_SCENARIOS, accessible, browser, file, muster, open, picture, soon, startMission } from "./support.mjs";

const ORIGIN = [18.411458, -72.466874];
const ZOOM = 11; // haiti's area is columns 611 to 613, rows 915 to 917
const AREA = { zoom: ZOOM, columns: [609, 615], rows: [914, 920] };
/** Degrees of haiti's first task, and the tile that a place is in. */
const [TASK] = JSON.parse(readFileSync(join(MUSTER_SCENARIOS, "haiti.json"), "utf8")).tasks
  .map(({ x_km, y_km }) => degreesOf({ scenario: { origin: ORIGIN } }, { x: 1000 * x_km, y: 1000 * y_km }));
function tileOf(latitude, longitude, zoom) {
  const n = 2 ** zoom;
  return [((longitude + 180) / 360) * n, ((1 - Math.asinh(Math.tan((latitude * Math.PI) / 180)) / Math.PI) / 2) * n].map(Math.floor);
}
const SQUARE = [[0, 0], [4096, 0], [4096, 4096], [0, 4096]];

before(() => {
  muster("simulate", join(MUSTER_SCENARIOS, "haiti.json"), "--policy", "greedy-nearest", "--log", "--out", file("haiti"));
  writeFileSync(file("red.pmtiles"), pmtiles({ ...AREA, type: 2, tile: () => png([255, 0, 0]), attribution: "<b>somebody</b>" }));
  // Water in every other column, with a town on its western shore.
  const sea = layer("water", [{ type: 3, places: SQUARE }]);
  const town = Buffer.concat([layer("place", [{ type: 1, tags: { class: "city", name: "Town" }, places: [[2048, 2048]] }]),
    layer("street_labels", [{ type: 2, tags: { kind: "primary", name: "Long Lane" }, places: [[500, 1000], [3500, 1000]] }])]);
  writeFileSync(file("shapes.pmtiles"), pmtiles({ ...AREA, type: 1, tile: (column) => (column % 2 ? sea : town), attribution: "somebody else" }));
  const [column, row] = tileOf(...TASK, ZOOM + 1);
  const closer = { ...AREA, attribution: "us", closer: [column, row, png([0, 160, 0])] };
  writeFileSync(file("closer.pmtiles"), pmtiles({ ...closer, type: 2, tile: () => png([255, 0, 0]) }));
  for (const name of ["red", "shapes", "closer"]) muster("report", file("haiti"), "--coast", "none", "--reasons", "0", "--tiles", file(`${name}.pmtiles`), "--out", file(`${name}.html`));
  muster("report", file("haiti"), "--coast", "none", "--reasons", "0", "--out", file("bare.html"));
});

/** Of the map at degrees, [red, green, blue]. */
const coloursAt = (page, places) => page.evaluate(async (wanted) => {
  await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
  const canvas = document.getElementById("map");
  const scale = canvas.width / canvas.clientWidth;
  const copy = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height }).getContext("2d", { willReadFrequently: true });
  copy.drawImage(canvas, 0, 0);
  const { shown } = window.muster.parts.map;
  return wanted.map((place) => [...copy.getImageData(shown.x(place.x) * scale, shown.y(place.y) * scale, 1, 1).data].slice(0, 3));
}, places.map((degrees) => planeOf({ scenario: { origin: ORIGIN } }, ...degrees)));

const isRed = ([r, g, b]) => r > g + 60 && r > b + 60;
/** Takes a place in degrees to the middle of the map, so many times as large as the whole area. */
const goTo = (page, degrees, k) => page.evaluate(([place, zoom]) => window.muster.parts.map.goTo(place, zoom),
  [planeOf({ scenario: { origin: ORIGIN } }, ...degrees), k]);
/** Degrees in the middle of a tile. */
const inTile = (column, row, zoom = ZOOM) => {
  const n = 2 ** zoom;
  return [(Math.atan(Math.sinh(Math.PI * (1 - (2 * (row + 0.53)) / n))) * 180) / Math.PI, ((column + 0.53) / n) * 360 - 180];
};

for (const [width, height, colorScheme] of LOOKS) {
  test(`pictures lie below the mission, at ${width} x ${height}, ${colorScheme}`, async (t) => {
    const page = await open(t, "red.html", { viewport: { width, height }, colorScheme }, "#t=0&off=tasks,grid&fold=none");
    await soon(async () => assert.ok((await coloursAt(page, [inTile(612, 916)])).every(isRed)));
    assert.equal(await page.locator("#map-source").innerText(), "somebody");
    assert.equal(await page.locator("#legend-basemap").innerText(), "map: somebody");
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width);
    await page.locator("#layers summary").click();
    await accessible(page, "with the list of layers");
  });
}

test("shapes are drawn where they are, and places are named", async (t) => {
  const page = await open(t, "shapes.html", {}, "#t=0&off=tasks,grid");
  const water = await page.evaluate(() => {
    const c = document.createElement("canvas").getContext("2d");
    c.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--water").trim();
    c.fillRect(0, 0, 1, 1);
    return [...c.getImageData(0, 0, 1, 1).data].slice(0, 3);
  });
  await soon(async () => assert.deepEqual(await coloursAt(page, [inTile(611, 916), inTile(613, 916)]), [water, water]));
  assert.notDeepEqual(await coloursAt(page, [inTile(612, 916)]), [water]);
  const named = await picture(page, "map");
  await page.locator("#layers summary").click();
  await page.locator("[data-layer=names]").uncheck();
  assert.notEqual(await picture(page, "map"), named, "a town is named");
});

test("streets are named along them, once the map is near enough, and found by name", async (t) => {
  const page = await open(t, "shapes.html", { reducedMotion: "reduce" }, "#t=0&off=tasks,grid,charging,ways");
  await page.keyboard.press("/");
  await page.keyboard.type("long");
  await soon(async () => assert.equal(await page.locator("#search-list li").first().innerText(), "Long Lane"));
  await page.keyboard.press("Enter");
  await goTo(page, inTile(612, 916), 3);
  const named = await picture(page, "map");
  await page.locator("#layers summary").click();
  await page.locator("[data-layer=streets]").uncheck();
  await soon(async () => assert.notEqual(await picture(page, "map"), named, "a street is named"));
  await accessible(page, "without the names of streets");
});

test("a page has a closer zoom around tasks, and the one below everywhere else", async (t) => {
  const page = await open(t, "closer.html", { reducedMotion: "reduce" }, "#t=0&off=tasks,grid,charging,ways,names");
  assert.deepEqual(await page.evaluate(() => window.muster.state.run.baseMap.info.zooms), [ZOOM, ZOOM + 1]);
  const [column, row] = tileOf(...TASK, ZOOM + 1);
  const places = [[column, row], [column + 1, row], [column - 1, row]].map(([c, r]) => inTile(c, r, ZOOM + 1));
  await soon(async () => assert.ok((await coloursAt(page, places)).every(isRed), "seen as a whole"));
  await goTo(page, TASK, 2);
  await soon(async () => {
    const [inside, ...around] = await coloursAt(page, places);
    assert.ok(inside[1] > inside[0] + 40, `${inside}`);
    assert.ok(around.every(isRed), around.join(" "));
  });
});

test("the box above the map finds by name, with the keyboard alone", async (t) => {
  const page = await open(t, "shapes.html", { reducedMotion: "reduce" }, "#t=0");
  await page.keyboard.press("/");
  await page.keyboard.type("worker:7");
  await soon(async () => assert.equal(await page.locator("#search-list li").first().innerText(), "worker:7"));
  await accessible(page, "with what was found");
  await page.keyboard.press("Enter");
  await soon(async () => assert.match(page.url(), /sel=worker:7/));
  await page.keyboard.press("/");
  await page.keyboard.type("town");
  await soon(async () => assert.equal(await page.locator("#search-list li").first().innerText(), "Town"));
  const before = await page.evaluate(() => window.muster.parts.map.view.left);
  await page.keyboard.press("Enter");
  await soon(async () => assert.notEqual(await page.evaluate(() => window.muster.parts.map.view.left), before));
  await page.keyboard.press("/");
  await page.keyboard.type("nobody");
  await soon(async () => assert.equal(await page.locator("#search-list").innerText(), "Nothing of that name"));
  await page.keyboard.press("Escape");
  assert.ok(!(await page.locator("#search-list").isVisible()));
});

test("layers are switched off, which the browser and a link remember", async (t) => {
  const context = await browser().newContext({ viewport: { width: 1400, height: 900 } });
  t.after(() => context.close());
  const page = await context.newPage();
  await page.goto(`file://${file("red.html")}#t=0`);
  await soon(async () => assert.ok((await coloursAt(page, [inTile(612, 916)])).every(isRed)));
  await page.locator("#layers summary").click();
  await page.locator("[data-layer=map]").uncheck();
  await soon(async () => assert.ok(!(await coloursAt(page, [inTile(612, 916)])).some(isRed)));
  await page.keyboard.press("Escape");
  assert.equal(await page.locator("#layers").getAttribute("open"), null);
  await soon(async () => assert.match(page.url(), /off=map/));
  await page.goto(page.url().replace(/#.*/, ""));
  await page.waitForFunction(() => document.documentElement.dataset.ready);
  assert.deepEqual(await page.evaluate(() => [...window.muster.state.off]), ["map"], "the browser remembers");
  await page.goto(`${page.url().replace(/#.*/, "")}#t=0&off=tasks,nothing`);
  await soon(async () => assert.deepEqual(await page.evaluate(() => [...window.muster.state.off]), ["tasks"]));
  await page.reload();
  await page.waitForFunction(() => document.documentElement.dataset.ready);
  assert.deepEqual(await page.evaluate(() => [...window.muster.state.off]), ["tasks"], "a link goes first");
  assert.equal(await page.evaluate(() => window.muster.parts.map.sites.length), 0, "what is not shown is not chosen");
});

test("the scene stands on the base map, without made-up buildings", async (t) => {
  const page = await open(t, "red.html", {}, "#t=0&look=scene");
  await page.waitForFunction(() => document.getElementById("scene").dataset.drawn);
  assert.equal(await page.locator("#scene-blocks").isChecked(), false);
});

test("without tiles there is no base map, and what cannot be is refused", async (t) => {
  const page = await open(t, "bare.html", {}, "#t=0");
  assert.ok(!(await page.locator("#map-source").isVisible()));
  assert.ok(!(await page.locator("#legend-basemap").isVisible()));
  await page.locator("#layers summary").click();
  assert.equal(await page.locator("[data-layer=map]").count(), 0);
  assert.throws(() => muster("report", file("haiti"), "--tiles", file("none.mbtiles"), "--out", file("no.html")), /none\.mbtiles: cannot read map tiles/);
  assert.throws(() => muster("report", file("haiti"), "--tiles", join(MUSTER_SCENARIOS, "haiti.json"), "--out", file("no.html")), /expected map tiles: an MBTiles or a PMTiles file/);
});

test("a live page asks for the tiles that it shows", async (t) => {
  const { url } = await startMission(t, join(MUSTER_SCENARIOS, "haiti.json"), "--policy", "greedy-nearest", "--rate", "60", "--tiles", file("red.pmtiles"), "--out", file("live"));
  const context = await browser().newContext({ viewport: { width: 1400, height: 900 } });
  t.after(() => context.close());
  const page = await context.newPage();
  const asked = [];
  page.on("request", (request) => asked.push(request.url()));
  await page.goto(`${url}&off=tasks,charging,names,ways,grid`);
  await soon(async () => assert.ok((await coloursAt(page, [inTile(612, 916)])).every(isRed)));
  const tiles = asked.filter((one) => one.includes("/tiles/"));
  assert.ok(tiles.length >= 4 && tiles.every((one) => one.includes(`/tiles/${ZOOM}/`)), tiles.join());
  assert.equal(new Set(tiles).size, tiles.length, "each once");
  assert.throws(() => muster("run", join(MUSTER_SCENARIOS, "random_1.json"), "--live=0", "--tiles", file("red.pmtiles"), "--out", file("nowhere")), /has no origin/);
  assert.throws(() => muster("run", join(MUSTER_SCENARIOS, "haiti.json"), "--tiles", file("red.pmtiles"), "--out", file("nowhere")), /--tiles: found .*red\.pmtiles, expected --live/);
});
