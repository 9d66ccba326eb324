// The map as the page, and what floats on it, in Chromium. Run by browser_tests.mjs.
import assert from "node:assert/strict";
import { before, test } from "node:test";
import { LOOKS, accessible, drawn, file, muster, namesOf, open, soon } from "./support.mjs";

const box = (page, id) => page.locator(id).boundingBox();
const isShown = (page, id) => page.locator(id).isVisible();

before(() => {
  // Nothing in most of the area: the map opens on the rest.
  muster("scenario", "--preset", "Random_1", "--seed", "3", "--limit", "60", "--out", file("one.json"));
  muster("simulate", file("one.json"), "--policy", "mpq", "--log", "--out", file("one"));
  muster("report", file("one"), "--reasons", "0", "--out", file("one.html"));
});

test("on a desktop the map is the first screen, below a header of one line", async (t) => {
  const page = await open(t, "a.html", { viewport: { width: 1440, height: 900 } }, "#t=4800");
  const [map, header, bar, strip] = await Promise.all(["#map", "header", "footer", "#jumps"].map((id) => box(page, id)));
  assert.ok(map.width >= 0.85 * 1440 && map.height >= 0.75 * 900, JSON.stringify(map));
  assert.ok(header.height <= 56, `a header of ${header.height}`);
  assert.ok(strip.y >= map.y + map.height - 1 && strip.y + strip.height <= bar.y + 1, `a strip at ${strip.y}, the bar at ${bar.y}`);
  assert.equal(await page.locator("#figures .tile").count(), 4);
});

for (const [width, height, colorScheme] of LOOKS) {
  test(`what is there opens where nothing covers it, at ${width} x ${height}, ${colorScheme}`, async (t) => {
    const phone = width < 500;
    const page = await open(t, "one.html", { viewport: { width, height }, colorScheme, isMobile: phone, hasTouch: phone }, "#t=1800");
    await drawn(page);
    const { places, map } = await page.evaluate(() => {
      const { map: view } = window.muster.parts;
      const { left, top } = document.getElementById("map").getBoundingClientRect();
      return { places: [...view.near, ...view.sites, ...view.points].map(({ px, py }) => [left + px, top + py]), map: { left, top } };
    });
    assert.ok(places.length > 50, String(places.length));
    const covers = await Promise.all((phone ? ["#side", "#search-box", "header"] : ["#side", "#map-tools", "#legends"]).map((id) => box(page, id)));
    for (const [x, y] of places) {
      assert.ok(x >= map.left && x <= width && y >= map.top, `${x} ${y} is on the map`);
      for (const cover of covers) {
        assert.ok(x < cover.x || x > cover.x + cover.width || y < cover.y || y > cover.y + cover.height, `${x}, ${y} is covered by ${JSON.stringify(cover)}`);
      }
    }
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width);
  });
}

test("panels fold by mouse and by key, which the browser and a link remember", async (t) => {
  const page = await open(t, "a.html", { viewport: { width: 1440, height: 900 } }, "#t=4800&sel=uav:2");
  const wide = () => page.evaluate(() => window.muster.parts.map.free.left);
  const before = await wide();
  assert.ok(before > 200, String(before));
  await page.keyboard.press("n");
  assert.ok(!(await isShown(page, "#attention-list")) && await isShown(page, "#attention-title"));
  assert.equal(await page.locator("[data-fold=attention]").getAttribute("aria-expanded"), "false");
  assert.equal(await wide(), 0, "the map is fitted to what is free now");
  await page.locator("[data-fold=legend]").click();
  assert.ok(!(await isShown(page, "#map-legend")));
  await page.keyboard.press("c");
  assert.ok(!(await isShown(page, "#card-facts")) && await isShown(page, "#card-title"));
  await accessible(page, "folded");
  await soon(async () => assert.match(page.url(), /fold=attention,card,legend/));
  await page.reload();
  await page.locator("html[data-ready]").waitFor({ state: "attached" });
  assert.ok(!(await isShown(page, "#attention-list")) && !(await isShown(page, "#map-legend")));
  await page.keyboard.press("h");
  assert.ok(!(await isShown(page, "#measure")), "all of them");
  await page.keyboard.press("h");
  for (const id of ["#attention-list", "#map-legend", "#card-facts", "#measure"]) assert.ok(await isShown(page, id), id);
  await page.evaluate(() => localStorage.clear());
  const other = await open(t, "a.html", {}, "#t=4800&fold=tools");
  assert.ok(!(await isShown(other, "#measure")) && await isShown(other, "#map-reset") && await isShown(other, "#attention-list"));
});

test("Fit shows what is there, and again all of the area", async (t) => {
  const page = await open(t, "a.html", { viewport: { width: 1440, height: 900 } }, "#t=4800");
  await page.evaluate(() => { // all is in a corner
    const { run } = window.muster.state;
    run.derived.set("bounds", { west: 1000, east: 5000, south: 1000, north: 5000 });
    window.muster.parts.map.draw();
  });
  const zoom = () => page.evaluate(() => window.muster.parts.map.view.k);
  const home = await zoom();
  assert.ok(home > 4, String(home));
  await page.keyboard.press("f");
  assert.ok(await zoom() <= 1, "all of it");
  await page.keyboard.press("f");
  assert.equal(await zoom(), home);
});

test("the engine room has what concerns the machine, by key and from the strip", async (t) => {
  const page = await open(t, "a.html", { viewport: { width: 1440, height: 900 } }, "#t=4800");
  assert.ok(!(await isShown(page, '[data-key="digest"]')));
  await page.keyboard.press("i");
  for (const key of ["scenario", "policy", "seed", "interval", "agents", "digest", "charges", "flown_m", "weight", "solve_s", "lost", "log"]) {
    assert.ok(await isShown(page, `[data-key="${key}"]`), key);
  }
  await accessible(page, "engine room");
  await page.keyboard.press("t");
  assert.ok(await isShown(page, "#task-table") && !(await isShown(page, "#engine")));
  await page.locator("#jumps button", { hasText: "Map" }).click();
  assert.ok(await page.evaluate(() => document.getElementById("map-panel").getBoundingClientRect().top) >= -1, "the map is in view");
  await page.locator("#jumps button", { hasText: "Engine room" }).click();
  assert.ok((await box(page, "#engine")).y < 843, "in view");
});

test("on a phone the map comes first, and a sheet is drawn up", async (t) => {
  const page = await open(t, "a.html", { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true }, "#t=4800");
  assert.ok((await box(page, "#map")).y <= 64);
  const high = async () => (await box(page, "#side")).height;
  const handle = page.locator("#sheet-handle");
  const peek = await high();
  assert.ok(peek < 0.25 * 844 && await isShown(page, "#figures"), String(peek));
  await handle.tap();
  const half = await high();
  assert.ok(half > peek + 100 && half < 0.6 * 844 && await isShown(page, "#attention-list"), String(half));
  await handle.focus();
  await page.keyboard.press("ArrowUp");
  assert.ok(await high() > 0.6 * 844);
  await page.keyboard.press("n");
  assert.equal(await high(), peek);
  const at = await box(page, "#sheet-handle");
  await page.mouse.move(200, at.y + 10);
  await page.mouse.down();
  await page.mouse.move(200, at.y - 200, { steps: 4 });
  await page.mouse.up();
  assert.equal(await high(), half, "the nearest of the three heights");
  const small = await page.locator("button:visible, select:visible, summary:visible").evaluateAll((all) => all
    .filter((one) => one.closest("header, #side, #map-panel, #jumps, footer") && !one.closest("#clusters") && !one.matches(".name, .sorter"))
    .filter((one) => one.getBoundingClientRect().height < 43.5 || one.getBoundingClientRect().width < 40).map((one) => one.id || one.textContent));
  assert.deepEqual(small, [], "large enough for a finger");
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
  await accessible(page, "the sheet");
  // A card draws it up, and leaves it where it was.
  await page.keyboard.press("n");
  await page.keyboard.press("n");
  assert.equal(await high(), peek);
  await page.evaluate(() => window.muster.state.select({ type: "task", id: 3 }));
  await soon(async () => assert.ok(await isShown(page, "#card") && await high() === half));
  await page.keyboard.press("Escape");
  await soon(async () => assert.equal(await high(), peek));
});

test("names on the map are short, and none stands over another, however near the map is", async (t) => {
  const page = await open(t, "a.html", { viewport: { width: 1440, height: 900 } }, "#t=4800&sel=uav:2");
  const named = await namesOf(page);
  for (const zoom of [0, 1, 2]) {
    if (zoom > 0) await page.locator("#map").dispatchEvent("wheel", { deltaY: -400, clientX: 900, clientY: 450 });
    await drawn(page);
    const names = await named();
    assert.ok(names.length >= 3, `${names.length} at ${zoom}`);
    assert.ok(names.every(({ text }) => /^(uav:2|[UWV]\d+( [WV]\d+)?|\d+)$/.test(text)), names.map(({ text }) => text).join());
    for (const [i, a] of names.entries()) {
      for (const b of names.slice(i + 1)) {
        assert.ok(a.right < b.left || b.right < a.left || a.bottom < b.top || b.bottom < a.top, `${a.text} and ${b.text} at ${zoom}`);
      }
    }
  }
});
