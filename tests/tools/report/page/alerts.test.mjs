// What a live page says at once, by text, sound and notification, in Chromium. Run by browser_tests.mjs.
import assert from "node:assert/strict";
import { join } from "node:path";
import { test } from "node:test";
import { MUSTER_SCENARIOS, accessible, browser, file, open, soon, startMission } from "./support.mjs";

/** Notes what is sounded and notified, in place of the browser's own. */
function listen() {
  window.heard = { tones: 0, told: [], asked: 0 };
  const { start } = window.OscillatorNode.prototype;
  window.OscillatorNode.prototype.start = function counted(...when) {
    window.heard.tones += 1;
    start.apply(this, when);
  };
  window.Notification = class {
    static permission = "granted";
    static requestPermission() { window.heard.asked += 1; }
    constructor(title, { body }) { window.heard.told.push(`${title}: ${body}`); }
  };
}

async function openLive(t, url) {
  const context = await browser().newContext({ viewport: { width: 1440, height: 900 }, reducedMotion: "reduce" });
  t.after(() => context.close());
  const page = await context.newPage();
  await page.addInitScript(listen);
  await page.goto(url);
  await page.waitForFunction(() => document.getElementById("live-state").textContent === "live");
  return page;
}

test("a live page says at once who has failed, with a sound where that is wanted", async (t) => {
  const { url } = await startMission(t, join(MUSTER_SCENARIOS, "random_1.json"), "--policy", "mpq", "--rate", "300", "--fault", "agent_silent:worker:3@100+30",
    "--fault", "agent_silent:worker:4@160+10", "--out", file("alerts"));
  const page = await openLive(t, url);
  const quiet = await openLive(t, url);
  await page.locator("#sound").click();
  assert.equal(await page.locator("#sound").innerText(), "Sound on");
  await accessible(page, "with the sound on");
  await page.waitForFunction(() => document.getElementById("news").textContent === "New: worker:3 has failed");
  await page.waitForFunction(() => window.heard.told.length > 0);
  assert.deepEqual(await page.evaluate(() => window.heard), { tones: 2, told: ["Muster: alerts: worker:3 has failed"], asked: 0 });
  await quiet.waitForFunction(() => document.getElementById("news").textContent === "New: worker:3 has failed");
  assert.deepEqual(await quiet.evaluate(() => window.heard), { tones: 0, told: [], asked: 0 }, "off unless it is wanted");
  // It is remembered, and what was before the page was opened is no news.
  await page.reload();
  await page.waitForFunction(() => document.getElementById("live-state").textContent === "live");
  await page.mouse.click(5, 5);
  await soon(async () => assert.equal(await page.locator("#sound").innerText(), "Sound on"));
  await page.waitForFunction(() => document.getElementById("news").textContent === "New: worker:4 has failed");
});

test("a page of a mission that is over has no sound", async (t) => {
  const page = await open(t, "a.html");
  assert.ok(!(await page.locator("#sound").isVisible()));
  assert.ok(!(await page.locator("#news").isVisible()));
});
