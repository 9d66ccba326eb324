// Distances and areas on the map, in numbers and in Chromium. Run by browser_tests.mjs.
import assert from "node:assert/strict";
import { join } from "node:path";
import { before, test } from "node:test";
import { areaOf, lengthOf, measureText } from "../../../../tools/report/page/measure.js";
import { MUSTER_SCENARIOS, accessible, file, muster, open, soon } from "./support.mjs";

before(() => {
  muster("simulate", join(MUSTER_SCENARIOS, "random_1.json"), "--policy", "greedy-nearest", "--log", "--out", file("measured"));
  muster("report", file("measured"), "--reasons", "0", "--out", file("measured.html"));
});

test("a line is as long as its parts, an area has that of its corners", () => {
  const square = [{ x: 0, y: 0 }, { x: 300, y: 0 }, { x: 300, y: 400 }, { x: 0, y: 400 }];
  assert.equal(lengthOf([]), 0);
  assert.equal(lengthOf([square[0], square[2]]), 500);
  assert.equal(lengthOf(square), 1000);
  assert.equal(areaOf(square), 120_000);
  assert.equal(areaOf([...square].reverse()), 120_000);
  assert.equal(areaOf([square[0], square[1], square[2]]), 60_000);
  assert.equal(measureText([]), "Click the first place on the map.");
  assert.equal(measureText([square[0], square[2]]), "500 m");
  assert.equal(measureText(square), "1.00 km; the last part 300 m; 0.12 km² within");
});

test("clicks on the map are measured, and select again afterwards", async (t) => {
  const page = await open(t, "measured.html", { viewport: { width: 1440, height: 900 } }, "#t=3600");
  const words = () => page.locator("#measure-text").innerText();
  await page.keyboard.press("l");
  await soon(async () => assert.equal(await words(), "Click the first place on the map."));
  assert.equal(await page.locator("#measure").getAttribute("aria-pressed"), "true");
  const box = await page.locator("#map").boundingBox();
  const click = async (km) => {
    const [x, y] = await page.evaluate(([east, north]) => {
      const { shown } = window.muster.parts.map;
      return [shown.x(east * 1000), shown.y(north * 1000)];
    }, km);
    await page.mouse.click(box.x + x, box.y + y);
  };
  await click([10, 10]);
  await click([20, 10]);
  // A click is a whole pixel, some tens of metres.
  await soon(async () => assert.ok(Math.abs(parseFloat(await words()) - 10) < 0.15, await words()));
  await click([20, 20]);
  await soon(async () => assert.match(await words(), /^(19|20)\.\d\d km; the last part (9|10)\.\d\d km; (49|50|51)\.\d\d km² within$/));
  await accessible(page);
  await page.locator("#measure-back").click();
  await soon(async () => assert.match(await words(), /^(9|10)\.\d\d km$/));
  await page.keyboard.press("Escape");
  await soon(async () => assert.ok(!(await page.locator("#measure-box").isVisible())));
  assert.equal(await page.locator("#measure").getAttribute("aria-pressed"), "false");
  assert.equal(await page.evaluate(() => window.muster.parts.map.picking), null);
});
