// The scene in three dimensions, in Chromium. Run by browser_tests.mjs.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { before, test } from "node:test";
import { LOOKS, accessible, browser, drawn, file, json, muster, open, scrub, soon } from "./support.mjs";

const SENSING = 4;
const CHARGING = 5;

before(() => {
  muster("scenario", "--scale", "20", "--seed", "1", "--out", file("many.json"));
  muster("simulate", file("many.json"), "--policy", "kwta", "--log", "--out", file("many"));
  muster("report", file("many"), "--reasons", "0", "--out", file("many.html"));
});

/** Once the scene has drawn the page's time; what it shows. */
const scene = async (page) => {
  await page.waitForFunction(() => window.muster.scene && document.getElementById("scene").dataset.drawn === String(Math.round(window.muster.clock.t)));
  await drawn(page);
  return page.evaluate(() => window.muster.scene.counts);
};
const openScene = async (page) => {
  if (!(await page.locator("#tab-scene").isVisible())) await page.locator("[data-fold=tools]").click(); // a phone
  await page.locator("#tab-scene").click();
  return scene(page);
};
/** How many UAVs have a status at the page's time. */
const uavsThat = (page, status) => page.evaluate((wanted) => window.muster.state.run.agents.filter(({ kind, spans }) => {
  let now = 0;
  for (let i = 0; i < spans.length && spans[i] <= window.muster.clock.t; i += 2) now = spans[i + 1];
  return kind === 0 && now === wanted;
}).length, status);
/** The scene's pixels: how many colours, and a sum that another picture hardly has. */
const pixels = (page) => page.evaluate(() => new Promise((resolve) => {
  requestAnimationFrame(() => requestAnimationFrame(() => {
    const from = document.getElementById("scene");
    const flat = Object.assign(document.createElement("canvas"), { width: from.width, height: from.height });
    const c = flat.getContext("2d", { willReadFrequently: true });
    c.drawImage(from, 0, 0);
    const colours = new Set();
    let sum = 0;
    for (const [i, pixel] of new Uint32Array(c.getImageData(0, 0, flat.width, flat.height).data.buffer).entries()) {
      colours.add(pixel);
      sum = (sum * 31 + (pixel ^ i)) >>> 0;
    }
    resolve({ colours: colours.size, sum });
  }));
}));
const camera = (page) => page.evaluate(() => {
  const { azimuth, polar, distance, target } = window.muster.scene.orbit;
  return { azimuth, polar, distance, target: [...target] };
});

for (const [width, height, colorScheme] of LOOKS) {
  test(`the scene at ${width} x ${height}, ${colorScheme}`, async (t) => {
    const phone = width < 500;
    const page = await open(t, "a.html", { viewport: { width, height }, colorScheme, isMobile: phone, hasTouch: phone, reducedMotion: "reduce" }, "#t=4800");
    assert.equal(await page.evaluate(() => typeof window.musterScene), "undefined", "nothing is unpacked before the tab is opened");
    const map = await page.locator("#map").boundingBox();
    await openScene(page);
    assert.ok((await pixels(page)).colours > 100);
    assert.ok(!(await page.locator("#map").isVisible()));
    const box = await page.locator("#scene").boundingBox();
    assert.ok(box.width >= 0.9 * map.width && box.height >= 0.6 * map.height, `${JSON.stringify(box)} in the place of ${JSON.stringify(map)}`);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width);
    assert.match(await page.locator("#scene-legend").innerText(), /scenery drawn from the seed/);
    await accessible(page, "the scene");
    if (phone) await page.locator("[data-fold=tools]").click();
    await page.locator("#tab-time").click();
    await scene(page);
    await accessible(page, "space and time");
  });
}

test("the scene follows the time, and shows what the run knows", async (t) => {
  const page = await open(t, "a.html", {}, "#look=scene&t=0");
  const report = json("a/report.json");
  const sums = new Set();
  for (const minutes of [40, 81, 140, 170]) {
    await scrub(page, minutes);
    const shown = await scene(page);
    assert.equal(shown.sensing, await uavsThat(page, SENSING));
    assert.equal(shown.charging, await uavsThat(page, CHARGING));
    assert.equal(shown.open + shown.done, report.tasks_total);
    sums.add((await pixels(page)).sum);
  }
  assert.equal(sums.size, 4);
  await page.keyboard.press("End");
  assert.equal((await scene(page)).done, report.tasks_done);
  await scrub(page, 80);
  assert.ok((await scene(page)).trails > 0);
  await page.locator("#layers summary").click();
  await page.locator("#trail").selectOption("0");
  await soon(async () => assert.equal((await scene(page)).trails, 0));
  const { agents } = await scene(page);
  await page.keyboard.press("1");
  await soon(async () => assert.ok((await scene(page)).agents < agents, "classes are hidden here too"));
});

test("what is selected in the scene is selected everywhere, and the other way", async (t) => {
  const page = await open(t, "a.html", { reducedMotion: "reduce" }, "#t=4860");
  await openScene(page);
  const flying = await page.evaluate(() => window.muster.scene.actors.places.filter(({ agent, y }) => agent.kind === 0 && y > 3).map(({ agent }) => agent.index)[0]);
  const at = await page.evaluate((index) => window.muster.scene.whereIs(index), flying);
  await page.locator("#scene").hover({ position: { x: at.px, y: at.py } });
  await soon(async () => assert.match(await page.locator("#scene-tip").innerText(), /^uav:\d+: /));
  const name = (await page.locator("#scene-tip").innerText()).split(":").slice(0, 2).join(":");
  await page.locator("#scene").click({ position: { x: at.px, y: at.py } });
  await soon(async () => assert.equal(await page.locator("#card-title").innerText(), name));
  const before = await camera(page);
  await page.locator("#attention-list .alarm").first().click();
  await soon(async () => assert.notEqual(await page.locator("#card-title").innerText(), name));
  await soon(async () => assert.notDeepEqual((await camera(page)).target, before.target, "the camera goes to what is chosen elsewhere"));
  await page.waitForFunction(() => location.hash.includes("look=scene"));
});

/** The corners of the area on the ground, and the box on the screen that what floats leaves free. */
const corners = (page) => page.evaluate(() => {
  const { camera, canvas, plane, orbit } = window.muster.scene;
  const box = (id) => document.getElementById(id).getBoundingClientRect();
  const within = canvas.getBoundingClientRect();
  const seen = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, z]) => {
    const v = camera.position.clone().set((x * plane.width) / 2, 0, (z * plane.height) / 2).project(camera);
    return { x: within.left + ((v.x + 1) / 2) * within.width, y: within.top + ((1 - v.y) / 2) * within.height };
  });
  return { seen, within, side: box("side"), tools: box("map-tools"), search: box("search-box"), legend: box("legend-box"), moved: orbit.moved };
});

for (const [width, height] of [[1440, 900], [390, 844]]) {
  test(`all of the area is seen between what floats on the scene, at ${width} x ${height}`, async (t) => {
    const phone = width < 500;
    const page = await open(t, "a.html", { viewport: { width, height }, isMobile: phone, hasTouch: phone }, "#look=scene&t=4800");
    const fits = async (what) => {
      await scene(page);
      await soon(async () => {
        const { seen, within, side, tools, search, legend } = await corners(page);
        const free = phone ? { left: within.left, right: within.right, top: search.bottom, bottom: side.top }
          : { left: side.right, right: within.right, top: tools.bottom, bottom: legend.top };
        for (const { x, y } of seen) assert.ok(x > free.left && x < free.right && y > free.top && y < free.bottom, `${what}: ${JSON.stringify({ x, y, free })}`);
        const fill = (from, to, values) => (Math.max(...values) - Math.min(...values)) / (to - from);
        const filled = Math.max(fill(free.left, free.right, seen.map(({ x }) => x)), fill(free.top, free.bottom, seen.map(({ y }) => y)));
        assert.ok(filled > 0.85 && filled < 1, `${what}: ${filled} of the free part`);
      });
    };
    await fits("as it opens");
    await page.locator("#scene").focus();
    for (const key of ["ArrowLeft", "+", "Shift+ArrowRight"]) await page.keyboard.press(key);
    assert.ok((await corners(page)).moved);
    await page.locator("#map-reset").click();
    await fits("Fit");
    if (phone) return;
    await page.keyboard.press("n");
    await page.keyboard.press("c");
    await soon(async () => {
      const { seen } = await corners(page);
      assert.ok(Math.min(...seen.map(({ x }) => x)) < 250, "what is folded leaves its room");
    });
  });
}

test("the camera follows the selected agent", async (t) => {
  const page = await open(t, "a.html", { reducedMotion: "reduce" }, "#t=4860&sel=uav:2&look=scene");
  await scene(page);
  await page.getByRole("button", { name: "Follow uav:2" }).click();
  const targets = new Set();
  for (const minutes of [82, 95, 105]) {
    await scrub(page, minutes);
    await scene(page);
    const { at, middle, target } = await page.evaluate(() => {
      const { canvas: { clientWidth: width, clientHeight: height }, orbit } = window.muster.scene;
      const { left, right, top, bottom } = orbit.free;
      return { at: window.muster.scene.whereIs(2), middle: { px: (left + width - right) / 2, py: (top + height - bottom) / 2 }, target: orbit.target.join() };
    });
    assert.ok(Math.hypot(at.px - middle.px, at.py - middle.py) < 2, JSON.stringify({ at, middle }));
    targets.add(target);
  }
  assert.ok(targets.size > 1, "it has moved");
  await page.locator("#map-reset").click();
  assert.equal(await page.locator("#scene-follow").getAttribute("aria-pressed"), "false");
});

test("keys and pointers move the camera, and not the time", async (t) => {
  const page = await open(t, "a.html", {}, "#t=4800");
  await page.keyboard.press("s");
  await scene(page);
  await page.locator("#scene").focus();
  const start = await camera(page);
  for (const key of ["ArrowLeft", "ArrowUp", "+", "Shift+ArrowRight"]) await page.keyboard.press(key);
  const keyed = await camera(page);
  for (const what of ["azimuth", "polar", "distance", "target"]) assert.notDeepEqual(keyed[what], start[what], what);
  assert.equal(await page.locator("#time-now").innerText(), "1:20:00");
  assert.equal(await page.evaluate(() => window.muster.clock.speed), 300);
  const box = await page.locator("#scene").boundingBox();
  await page.mouse.move(box.x + 600, box.y + 200);
  await page.mouse.down();
  await page.mouse.move(box.x + 660, box.y + 220);
  await page.mouse.up();
  assert.notEqual((await camera(page)).azimuth, keyed.azimuth);
  assert.ok(!(await page.locator("#card").isVisible()), "a drag selects nothing");
  await page.mouse.wheel(0, 300);
  await soon(async () => assert.ok((await camera(page)).distance > keyed.distance));
  await page.keyboard.press("f");
  await soon(async () => assert.equal((await camera(page)).azimuth, start.azimuth));
  await page.keyboard.press("m");
  await soon(async () => assert.ok(await page.locator("#map").isVisible()));
  await page.locator("#tab-map").focus();
  await page.keyboard.press("ArrowRight");
  await soon(async () => assert.equal(await page.evaluate(() => document.activeElement.id), "tab-scene"));
  await soon(async () => assert.ok(await page.locator("#scene").isVisible()));
});

test("space and time: as many meetings as the run has, and the future above", async (t) => {
  const page = await open(t, "a.html", {}, "#t=4800&look=time");
  const { meetings } = await scene(page);
  assert.equal(meetings, await page.evaluate(() => window.muster.state.run.activities.length / 6));
  assert.ok(meetings > 50);
  const floor = () => page.evaluate(() => window.muster.scene.floor);
  const now = await floor();
  await scrub(page, 160);
  await scene(page);
  assert.ok(Math.abs((await floor()) - 2 * now) < 0.01, "time goes up evenly");
  await page.locator("#tab-scene").click();
  await soon(async () => assert.equal((await scene(page)).meetings, 0));
});

test("scenery comes from the seed, and can be switched off", async (t) => {
  const page = await open(t, "a.html", {}, "#look=scene");
  const { blocks } = await scene(page);
  assert.ok(blocks > 100);
  await page.locator("#scene-blocks").uncheck();
  assert.equal((await scene(page)).blocks, 0);
  const again = await open(t, "ab.html", {}, "#look=scene");
  assert.equal((await scene(again)).blocks, blocks, "the same for the same seed");
});

test("two thousand agents are drawn in few calls", async (t) => {
  const page = await open(t, "many.html", {}, "#look=scene&t=6000");
  const { agents } = await scene(page);
  assert.equal(await page.evaluate(() => window.muster.state.run.agents.length), 2000);
  assert.ok(agents > 500);
  assert.ok(await page.evaluate(() => window.muster.scene.renderer.info.render.calls) <= 20);
});

test("without WebGL, or built without three.js, the tab says so", async (t) => {
  const page = await open(t, "a.html");
  await page.evaluate(() => {
    const get = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...more) { return kind.startsWith("webgl") ? null : get.call(this, kind, ...more); };
  });
  await page.locator("#tab-scene").click();
  await soon(async () => assert.match(await page.locator("#scene-problem").innerText(), /has no WebGL 2/));
  await accessible(page, "without WebGL");
  await page.locator("#tab-map").click();
  assert.ok(await page.locator("#map").isVisible());
  writeFileSync(file("flat.html"), readFileSync(file("a.html"), "utf8").replace(/<script type="text\/x-muster-scene">[^<]*<\/script>/, ""));
  const flat = await open(t, "flat.html", {}, "#look=scene");
  await soon(async () => assert.match(await flat.locator("#scene-problem").innerText(), /built without three.js/));
});

test("a picture of the scene is made with what the link says", async () => {
  muster("report", file("a"), "--scene", file("scene.png"), "--show", "t=4860&sel=uav:25");
  const png = readFileSync(file("scene.png"));
  assert.equal(png.toString("latin1", 1, 4), "PNG");
  assert.deepEqual([png.readUInt32BE(16), png.readUInt32BE(20)], [1920, 1080]);
  muster("report", file("a"), "--scene", file("scene.png"), "--show", "look=time");
  assert.notDeepEqual(readFileSync(file("scene.png")), png);
  assert.throws(() => muster("report", file("a"), "--scene", file("a.html")), { status: 2 });
});

test("a film of the scene plays, and has the length that it says", async (t) => {
  const page = await open(t, "a.html", { viewport: { width: 320, height: 240 } }, "#look=scene&sel=uav:2");
  await scene(page);
  const webm = await page.evaluate(async () => {
    const { film } = window.muster;
    const n = await film.begin(2, 3, 0.5);
    for (let i = 0; i < n; i += 2) await film.take(i, 2);
    return film.end();
  });
  assert.equal(await page.evaluate(() => window.muster.clock.t), await page.evaluate(() => window.muster.state.run.nowMs));
  const player = await (await browser().newContext()).newPage();
  const seen = await player.evaluate((data) => new Promise((resolve, reject) => {
    const video = Object.assign(document.createElement("video"), { src: `data:video/webm;base64,${data}`, muted: true });
    video.onerror = () => reject(new Error(video.error.message));
    video.onloadedmetadata = () => { video.currentTime = 1.4; };
    video.onseeked = () => resolve({ width: video.videoWidth, height: video.videoHeight, duration: video.duration });
  }), webm);
  assert.deepEqual(seen, { width: 320, height: 240, duration: 2 });
  await player.context().close();
});
