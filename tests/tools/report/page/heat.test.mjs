// Heat of tasks and coverage on the map, in numbers and in Chromium. Run by browser_tests.mjs.
import assert from "node:assert/strict";
import { test } from "node:test";
import { coverage, coverageSide, coveredShare, openHeat, responseHeat } from "../../../../tools/report/page/heat.js";
import { DONE, IDLE, MOVING, OPEN, RESERVED } from "../../../../tools/report/page/words.js";
import { SCENARIO, begun } from "./small_run.mjs";
import { LOOKS, accessible, browser, drawn, file, json, open, picture, scrub, soon } from "./support.mjs";

begun(); // from here on statuses have their numbers
const LEVEL = 9; // squares of 512 m
const tasks = [100, 100, 0, 200, 300, 0, 900, 900, 0]; // two in the first square, one in the last
const values = ({ squares }) => squares.map(({ west, south, value }) => [west, south, value]);

test("open tasks are counted by squares, those with somebody on the way are not", () => {
  const run = begun({ scenario: { ...SCENARIO, tasks }, tasks: [[1, 0, [60000, RESERVED, 120000, OPEN, 180000, DONE]]] });
  assert.deepEqual(values(openHeat(run, 0, LEVEL)), [[0, 0, 2], [512, 512, 1]]);
  assert.deepEqual(values(openHeat(run, 60000, LEVEL)), [[0, 0, 1], [512, 512, 1]]);
  assert.deepEqual(values(openHeat(run, 120000, LEVEL)), [[0, 0, 2], [512, 512, 1]]);
  const { least, most, side } = openHeat(run, 120000, LEVEL);
  assert.deepEqual([least, most, side], [1, 2, 512]);
  assert.deepEqual(values(openHeat(run, 120000, LEVEL + 1)), [[0, 0, 3]], "larger squares");
  run.apply({ version: 1, now_ms: 300000, epoch_ms: 0, ended: false, tasks: [[0, 0, [90000, DONE]]] });
  assert.deepEqual(values(openHeat(run, 120000, LEVEL + 1)), [[0, 0, 2]], "what was heard since counts");
});

test("response is the mean time from report to done", () => {
  const done = [[0, 0, [600000, DONE]], [1, 0, [1200000, DONE]]];
  const run = begun({ scenario: { ...SCENARIO, tasks }, tasks: done });
  assert.deepEqual(values(responseHeat(run, 599999, LEVEL)), []);
  assert.deepEqual(values(responseHeat(run, 600000, LEVEL)), [[0, 0, 10]]);
  assert.deepEqual(values(responseHeat(run, 1200000, LEVEL)), [[0, 0, 15]]);
  const reported = begun({ scenario: { ...SCENARIO, tasks, task_times: [[300000, null, null, 1, ""], [900000, null, null, 1, ""], [0, null, null, 1, ""]] }, tasks: done });
  assert.deepEqual(values(responseHeat(reported, 1200000, LEVEL)), [[0, 0, 5]]);
});

test("a square is covered once a UAV has been in it", () => {
  assert.deepEqual([[100, 50], [1000, 1000], [20000, 1000], [190000, 190000], [600000, 600000]].map(([w, h]) => coverageSide({ width_m: w, height_m: h })),
    [1, 5, 100, 1000, 1000]);
  const scenario = { ...SCENARIO, width_m: 200000, height_m: 200000 };
  // A UAV flies 10 km to the east in ten minutes, a worker goes elsewhere.
  const run = begun({ scenario, stops: [[0, 0, [0, 500, 500, 30000, 600000, 10500, 500, 20000]], [1, 0, [0, 500, 50500, 0, 600000, 10500, 50500, 0]]],
    spans: [[0, 0, [0, MOVING, 600000, IDLE]]] });
  const { side, columns, rows, first } = coverage(run);
  assert.deepEqual([side, columns, rows], [1000, 200, 200]);
  assert.equal([...first].filter((at) => at < Infinity).length, 11);
  assert.equal(first[0], 0);
  assert.ok(Math.abs(first[5] - 4.5 * 60000) <= 15000, `${first[5]}`);
  assert.equal(coveredShare(run, 0), 1 / 40000);
  assert.equal(coveredShare(run, 600000), 11 / 40000);
});

for (const [width, height, colorScheme] of LOOKS) {
  test(`layers of heat are shown when asked for, at ${width} x ${height}, ${colorScheme}`, async (t) => {
    const page = await open(t, "a.html", { viewport: { width, height }, colorScheme }, "#t=5400&fold=none");
    const seen = [await picture(page, "map")];
    await page.locator("#layers summary").click();
    for (const id of ["open-heat", "response-heat", "coverage"]) {
      assert.ok(!(await page.locator(`#legend-${id}`).isVisible()));
      await page.locator(`[data-layer=${id}]`).check();
      await soon(async () => assert.ok(await page.locator(`#legend-${id}`).isVisible()));
      seen.push(await picture(page, "map"));
    }
    assert.equal(new Set(seen).size, 4, "each changes the map");
    await accessible(page, "with heat");
    await soon(async () => assert.match(page.url(), /on=open-heat,response-heat,coverage/));
    const share = async () => Number((await page.locator("#legend-coverage").innerText()).match(/([\d.]+) % of the area/)[1]);
    const before = await share();
    await scrub(page, 10);
    assert.ok(await share() < before, "less was covered earlier");
    assert.match(await page.locator("#legend-response-heat").innerText(), /minutes from the mission's start to done/);
  });
}

test("printed, a map with heat has its squares and its legend, in light colours whatever the screen's are", async (t) => {
  const printed = async (hash, colorScheme) => {
    const page = await open(t, "a.html", { colorScheme }, `#t=5400&fold=legend${hash}`);
    const screen = await picture(page, "map");
    await page.emulateMedia({ media: "print", colorScheme });
    const legends = page.locator("#legend-open-heat, #legend-response-heat, #legend-coverage");
    const shown = await legends.evaluateAll((spans) => spans.filter((span) => span.checkVisibility()).length);
    const map = await picture(page, "map");
    const pdf = (await page.pdf({ format: "A4", landscape: true, scale: 0.7 })).toString("latin1");
    assert.equal(pdf.match(/\/Type\s*\/Page\b/g).length, 1);
    await page.emulateMedia({ media: "screen", colorScheme });
    await soon(async () => assert.equal(await picture(page, "map"), screen, "the screen has its own colours again"));
    return { shown, map };
  };
  const on = "&on=open-heat,response-heat,coverage";
  const [plain, light, dark] = [await printed("", "light"), await printed(on, "light"), await printed(on, "dark")];
  assert.deepEqual([plain.shown, light.shown, dark.shown], [0, 3, 3]);
  assert.notEqual(light.map, plain.map, "the squares are there");
  assert.equal(dark.map, light.map);
});

test("the browser and a link remember layers of heat", async (t) => {
  const context = await browser().newContext({ viewport: { width: 1400, height: 900 } });
  t.after(() => context.close());
  const page = await context.newPage();
  const shown = () => page.evaluate(() => [[...window.muster.state.extra], [...window.muster.state.off]]);
  const start = async (hash) => {
    await page.goto("about:blank");
    await page.goto(`file://${file("a.html")}${hash}`);
    await page.waitForFunction(() => document.documentElement.dataset.ready);
  };
  await start("#t=5400&on=coverage,nothing,roads");
  assert.deepEqual(await shown(), [["coverage"], []], "a link asks for layers of the menu only, and only for such ones");
  await page.locator("#layers summary").click();
  await page.locator("[data-layer=open-heat]").check();
  await start("");
  assert.deepEqual(await shown(), [["coverage", "open-heat"], []], "the browser remembers");
  await start("#on=response-heat&off=coverage,names");
  assert.deepEqual(await shown(), [["response-heat"], ["names"]], "a link goes first");
});

test("the heat of open tasks tells how many there are", async (t) => {
  const page = await open(t, "a.html", {}, "#t=0&on=open-heat");
  await drawn(page);
  // Numbers are drawn: their sum is that of the tasks.
  const sum = await page.evaluate(async () => {
    const { map } = window.muster.parts;
    const prototype = CanvasRenderingContext2D.prototype;
    const { fillText } = prototype;
    let total = 0;
    prototype.fillText = function told(text, ...rest) {
      if (this.font.startsWith("9px")) total += Number(text);
      return fillText.call(this, text, ...rest);
    };
    map.draw();
    await new Promise((go) => requestAnimationFrame(() => requestAnimationFrame(go)));
    prototype.fillText = fillText;
    return total;
  });
  assert.equal(sum, json("a/report.json").tasks_total);
});
