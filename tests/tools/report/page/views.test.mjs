// The page in other languages, as a display for a wall, and the story of a comparison, in Chromium. Run by browser_tests.mjs.
import assert from "node:assert/strict";
import { test } from "node:test";
import { LOOKS, accessible, drawn, open, scrub, soon } from "./support.mjs";

const heading = (page) => page.locator("#attention-title").innerText();

for (const [code, title] of [["fr", "Points d’attention"], ["es", null], ["zh", null]]) {
  test(`the page speaks ${code}, and the browser and the link remember it`, async (t) => {
    const page = await open(t, "a.html", {}, "#t=4800&sel=uav:2");
    const english = await heading(page);
    await page.locator("#language").selectOption(code);
    await soon(async () => assert.notEqual(await heading(page), english));
    if (title) assert.equal(await heading(page), title);
    assert.equal(await page.locator("html").getAttribute("lang"), code);
    await soon(async () => assert.match(page.url(), new RegExp(`lang=${code}`)));
    assert.match(await page.locator("#time-now").innerText(), /1:20:00/, "it goes on where it was");
    await accessible(page, code);
    await page.locator("#language").selectOption("en");
    await soon(async () => assert.equal(await heading(page), english));
  });
}

for (const [width, height, colorScheme] of LOOKS) {
  test(`the header and the bars hold French at ${width} x ${height}, ${colorScheme}`, async (t) => {
    const page = await open(t, "a.html", { viewport: { width, height }, colorScheme }, "#lang=fr");
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
    assert.ok(wide <= 0, `${wide} px wider than the window`);
    await accessible(page, "French");
  });

  test(`a display for a wall at ${width} x ${height}, ${colorScheme}`, async (t) => {
    const page = await open(t, "a.html", { viewport: { width, height }, colorScheme }, "#t=8400");
    await page.keyboard.press("w");
    await soon(async () => assert.ok(await page.locator("#wall").isVisible()));
    assert.ok(!(await page.locator("header").isVisible()) && !(await page.locator("#scrub").isVisible()), "no controls");
    assert.match(await page.locator("#wall-figures").innerText(), /of 120/);
    await soon(async () => assert.notEqual((await page.locator("#wall-what").innerText()).trim(), ""));
    const box = await page.locator("#map-panel").boundingBox();
    assert.ok(box.width >= width - 1 && box.height > height / 3, `${JSON.stringify(box)}`);
    assert.match(page.url(), /wall=1/);
    await accessible(page, "wall");
    await page.keyboard.press("Escape");
    await soon(async () => assert.ok(await page.locator("header").isVisible()));
    assert.ok(!(await page.locator("#wall").isVisible()));
  });
}

test("a link opens the wall's display, and what needs attention comes in turn", async (t) => {
  const page = await open(t, "a.html", { reducedMotion: "reduce" }, "#t=8400&wall=1");
  await soon(async () => assert.match(await page.locator("#wall-place").innerText(), /1 of \d+/));
  const first = await page.locator("#wall-what").innerText();
  await page.waitForFunction((was) => document.getElementById("wall-what").textContent !== was, first, { timeout: 15_000 });
  assert.match(await page.locator("#wall-place").innerText(), /2 of \d+/);
});

test("a comparison tells where the better run won", async (t) => {
  const page = await open(t, "ab.html");
  const story = page.locator("#rivalry");
  await story.scrollIntoViewIfNeeded();
  await soon(async () => assert.match(await page.locator("#rivalry-body").innerText(), /tasks/));
  await accessible(page, "story");
  const before = await page.locator("#time-now").innerText();
  await scrub(page, 1);
  await page.locator("#rivalry-body button").first().click();
  await drawn(page);
  await soon(async () => assert.notEqual(await page.locator("#time-now").innerText(), "0:01:00"));
  assert.notEqual(before, "");
  await page.locator("#layers summary").click();
  await page.locator("[data-layer=one-run]").check();
  await soon(async () => assert.match(page.url(), /on=one-run/));
});
