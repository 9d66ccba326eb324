// Local time on the page, in Chromium: that of the scenario's start, whatever the rate and the reader's own zone. Run by
// browser_tests.mjs.
import assert from "node:assert/strict";
import { before, test } from "node:test";
import { accessible, browser, file, muster, open, scrub, soon, text } from "./support.mjs";
import { TOKEN, livePage, liveRun, serve } from "./stub_server.mjs";

const ZONES = ["Asia/Tokyo", "America/Anchorage"];

before(() => {
  muster("scenario", "--start", "2010-01-16T22:30:00-05:00", "--out", file("start.json"));
  muster("simulate", file("start.json"), "--policy", "horizon", "--log", "--out", file("start"));
  muster("report", file("start"), "--reasons", "0", "--out", file("start.html"));
});

for (const timezoneId of ZONES) {
  test(`a simulated mission has the scenario's time, read in ${timezoneId}`, async (t) => {
    const page = await open(t, "start.html", { timezoneId });
    await scrub(page, 80);
    assert.equal(await text(page, "start"), "2010-01-16 22:30 UTC-05:00");
    await soon(async () => assert.equal(await text(page, "local"), "23:50:00, 04:50:00 UTC"));
    assert.equal(await page.locator("#time-wall").innerText(), "23:50:00 UTC-05:00, 04:50:00 UTC");
    assert.equal(await page.locator("#scrub").getAttribute("aria-valuetext"), "1:20:00 (23:50:00 local)");
    await scrub(page, 95);
    await soon(async () => assert.equal(await page.locator("#time-wall").innerText(), "00:05:00 +1 d UTC-05:00, 05:05:00 UTC"));
    assert.equal(await page.locator("#time-wall").getAttribute("title"), "2010-01-17");
    assert.equal(await page.locator("#time-now").innerText(), "1:35:00");
  });
}

test("cards tell local times, and the page says nothing of the kind without a start", async (t) => {
  const page = await open(t, "start.html", {}, "#t=4800&sel=task:0");
  const facts = page.locator("#card-facts");
  await soon(async () => assert.match(await facts.innerText(), /time\s+23:50:00 UTC-05:00, 04:50:00 UTC/));
  const busy = await page.evaluate(() => window.muster.state.run.agents.find((agent) => agent.spans.some((status, i) => i % 2 === 1 && status === 2 && agent.spans[i - 1] < 4e6)));
  await page.evaluate(([t0, id]) => { location.hash = `#t=${t0}&sel=uav:${id}`; }, [busy.spans[busy.spans.findIndex((status, i) => i % 2 === 1 && status === 2) - 1] / 1000 + 1, busy.id]);
  await soon(async () => assert.match(await facts.innerText(), /since \d:\d\d:\d\d \(\d\d:\d\d:\d\d local\)/));
  await accessible(page, "with local times");
  const plain = await open(t, "a.html", {}, "#t=4800&sel=task:0");
  await plain.locator("#card").waitFor();
  assert.doesNotMatch(await plain.locator("body").innerText(), /UTC|local/i);
});

for (const [width, height] of [[1440, 900], [390, 844]]) {
  test(`the bar below with local time covers neither card nor legend at ${width} x ${height}`, async (t) => {
    const phone = width < 500;
    const page = await open(t, "start.html", { viewport: { width, height }, isMobile: phone, hasTouch: phone }, "#t=4800&sel=task:0");
    await page.locator("#card").waitFor();
    await soon(async () => {
      const [card, legend, bar] = await Promise.all(["#card", "#map-legend", "footer"].map((id) => page.locator(id).boundingBox()));
      assert.ok(card.y + card.height <= bar.y, `card to ${card.y + card.height}, bar from ${bar.y}`);
      if (!phone) assert.ok(legend.y + legend.height <= bar.y, `legend to ${legend.y + legend.height}, bar from ${bar.y}`);
      assert.ok(bar.height < 120, `a bar of ${bar.height}`);
    });
  });
}

test("a live page shows local time as the mission goes on", async () => {
  const live = liveRun("start.html", 80);
  const { url, tell } = await serve(await livePage("start"), live, () => [500, {}]);
  const page = await (await browser().newContext({ timezoneId: ZONES[0], viewport: { width: 390, height: 844 } })).newPage();
  await page.goto(`${url}#token=${TOKEN}`);
  await soon(async () => assert.equal(await page.locator("#time-wall").innerText(), "23:50:00 UTC-05:00, 04:50:00 UTC"));
  tell({ now_ms: 81 * 60000 });
  await soon(async () => assert.equal(await page.locator("#time-wall").innerText(), "23:51:00 UTC-05:00, 04:51:00 UTC"));
  await soon(async () => assert.equal(await text(page, "local"), "23:51:00, 04:51:00 UTC"));
  // On a phone the bar has two rows, with the button that goes back to the newest time in the second.
  const [bar, button] = [await page.locator("footer").boundingBox(), await page.locator("#live").boundingBox()];
  assert.ok(bar.height < 120, `a bar of ${bar.height}`);
  assert.ok(button.x + button.width <= 390 && button.y + button.height <= bar.y + bar.height, JSON.stringify(button));
});
