// A crowd on the map, in Chromium: clusters, and a map that is moved. Run by browser_tests.mjs.
import assert from "node:assert/strict";
import { before, test } from "node:test";
import { LOOKS, accessible, drawn, file, muster, open, picture, soon } from "./support.mjs";

before(() => {
  muster("scenario", "--preset", "Random_1", "--tasks", "6000", "--limit", "30", "--out", file("crowd.json"));
  muster("simulate", file("crowd.json"), "--policy", "greedy-nearest", "--log", "--out", file("crowd"));
  muster("report", file("crowd"), "--reasons", "0", "--out", file("crowd.html"));
});

/** The clusters in view: [{ words, n, x, y (on the page, of the badge's middle), east, north (metres) }]. */
const clustersOf = (page) => page.evaluate(() => {
  const { map } = window.muster.parts;
  const box = document.getElementById("map").getBoundingClientRect();
  return map.badges().map(({ cluster, left, top, wide, high }) => ({ key: cluster.key, counts: cluster.counts, n: cluster.items.length,
    x: box.left + left + wide / 2, y: box.top + top + high / 2, box: cluster.box }));
});
const zoomOf = (page) => page.evaluate(() => window.muster.parts.map.view.k);
/** Those that nothing covers. */
const inside = async (page, clusters) => {
  const [box, free] = [await page.locator("#map").boundingBox(), await page.evaluate(() => window.muster.parts.map.free)];
  return clusters.filter(({ x, y }) => x > box.x + free.left + 60 && x < box.x + box.width - 60
    && y > box.y + free.top + 60 && y < box.y + box.height - free.bottom - 60);
};

for (const [width, height, colorScheme] of LOOKS) {
  test(`a badge tells what stands together, and a click parts it, at ${width} x ${height}, ${colorScheme}`, async (t) => {
    const page = await open(t, "crowd.html", { viewport: { width, height }, colorScheme }, "#t=600");
    const note = page.locator("#map-crowd");
    await soon(async () => assert.ok(await note.isVisible()));
    await accessible(page, "a crowd");
    await page.locator("#map").scrollIntoViewIfNeeded();
    for (let step = 0; await note.isVisible(); ++step) {
      assert.ok(step < 12, "clusters part");
      const [cluster] = await inside(page, await clustersOf(page));
      const before = await zoomOf(page);
      await page.mouse.move(cluster.x, cluster.y);
      // A symbol that stands alone may be above the badge.
      if (!/^\d+ (UAV|worker|vehicle|task|charging point)/.test(await page.locator("#map-tip").innerText())) break;
      await page.mouse.click(cluster.x, cluster.y);
      await soon(async () => assert.ok(await zoomOf(page) >= 1.9 * before));
      await page.waitForFunction(() => !window.muster.parts.map.gliding || window.muster.parts.map.view === window.muster.parts.map.gliding);
      await drawn(page);
    }
    assert.ok(await zoomOf(page) > 2);
    await page.locator("#map-reset").click();
    await soon(async () => assert.ok(await note.isVisible()));
  });
}

test("all are drawn, in clusters or alone, and what is selected is never in one", async (t) => {
  const page = await open(t, "crowd.html", {}, "#t=600&sel=task:4321");
  await page.locator("#map-reset").click();
  await drawn(page);
  const [alone, together, present, sites] = await page.evaluate(() => {
    const { map } = window.muster.parts;
    return [map.near.length + map.sites.length + map.points.length, map.clusters.reduce((sum, { items }) => sum + items.length, 0), map.present.items.length,
      map.sites.map(({ task }) => task.id)];
  });
  assert.equal(alone + together, present);
  assert.ok(together > 5000, String(together));
  assert.ok(sites.includes(4321));
  assert.match(await page.locator("#selection").innerText(), /^task 4321: /);
});

test("clusters stay as they are while the map is moved", async (t) => {
  const page = await open(t, "crowd.html", {}, "#t=600");
  await drawn(page);
  const box = await page.locator("#map").boundingBox();
  const told = async () => new Map((await clustersOf(page)).map(({ key, counts, box: around }) => [key, JSON.stringify([counts, around])]));
  const before = await told();
  const at = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(...at);
  await page.mouse.down();
  for (let i = 1; i <= 20; ++i) {
    await page.mouse.move(at[0] + 11 * i, at[1] - 7 * i);
    await drawn(page);
    for (const [key, words] of await told()) assert.equal(words, before.get(key) ?? words, `after ${i} steps`);
  }
  await page.mouse.up();
  const kept = [...(await told()).keys()].filter((key) => before.has(key));
  assert.ok(kept.length > 5, `${kept.length} of ${before.size} are still in view`);
});

test("a map that was moved looks as one drawn there", async (t) => {
  for (const deviceScaleFactor of [1, 2]) {
    const page = await open(t, "crowd.html", { deviceScaleFactor }, "#t=600");
    await drawn(page);
    const box = await page.locator("#map").boundingBox();
    await page.mouse.move(box.x + 500, box.y + 200);
    await page.mouse.down();
    for (const by of [5, 40, 90, 400, 280]) { // within what has been drawn, and out of it
      await page.mouse.move(box.x + 500 + by, box.y + 200 + by / 2);
      await drawn(page);
      const moved = await picture(page, "map");
      await page.evaluate(() => window.muster.parts.map.draw()); // all of it again
      const again = await picture(page, "map");
      const share = await page.evaluate(differing, [moved, again]);
      assert.ok(share < 0.001, `${share} of the pixels differ after ${by} pixels at ${deviceScaleFactor}`);
    }
    await page.mouse.up();
  }
});

/** The share of pixels that clearly differ between two pictures; run in the page. */
async function differing(urls) {
  const [a, b] = await Promise.all(urls.map(async (url) => {
    const image = Object.assign(new Image(), { src: url });
    await image.decode();
    const c = Object.assign(document.createElement("canvas"), { width: image.width, height: image.height }).getContext("2d");
    c.drawImage(image, 0, 0);
    return c.getImageData(0, 0, image.width, image.height).data;
  }));
  let n = 0;
  for (let i = 0; i < a.length; i += 4) if ([0, 1, 2].some((j) => Math.abs(a[i + j] - b[i + j]) > 40)) ++n;
  return n / (a.length / 4);
}

test("the keyboard goes from cluster to cluster, and into one", async (t) => {
  const page = await open(t, "crowd.html", {}, "#t=600");
  const group = page.locator("#clusters");
  await soon(async () => assert.ok(await group.locator("button").count() > 10));
  assert.equal(await group.locator('button[tabindex="0"]').count(), 1, "one stop of Tab");
  const unmarked = await picture(page, "map");
  for (let i = 0; i < 60 && !(await group.evaluate((box) => box.contains(document.activeElement))); ++i) await page.keyboard.press("Tab");
  const focused = () => group.locator("button:focus").innerText();
  const first = await focused();
  assert.match(first, /^[\d,]+ (UAV|worker|vehicle|task|charging point).* around [\d.]+, [\d.]+ km.*: zoom in$/);
  assert.notEqual(await picture(page, "map"), unmarked, "the map marks it");
  const now = await page.evaluate(() => window.muster.clock.t);
  await page.keyboard.press("ArrowRight");
  assert.notEqual(await focused(), first);
  assert.equal(await page.evaluate(() => window.muster.clock.t), now, "the arrow does not move time");
  await page.keyboard.press("Home");
  assert.equal(await focused(), first);
  const before = await zoomOf(page);
  await page.keyboard.press("Enter");
  await soon(async () => assert.ok(await zoomOf(page) >= 1.9 * before));
  await soon(async () => {
    const where = await page.evaluate(() => document.activeElement.closest("#clusters, #map-reset")?.id);
    assert.ok(where, "the focus stays at the map");
    assert.ok(!(await group.locator("button").allInnerTexts()).includes(first));
  });
  await accessible(page, "from the keyboard");
});
