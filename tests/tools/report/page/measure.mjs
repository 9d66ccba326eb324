// node measure.mjs WORK PAGE...: how long each page takes until it can be used, with the scene and without, and the
// longest frames while its time moves and while its map is zoomed, as rows of a table. WORK is where browser_tests.mjs
// put playwright-core. scripts/measure-page makes the pages.
// MUSTER_PROFILE=FILE writes Chromium's profile of the last page, for its developer tools.
import { readFileSync, statSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { basename, join, resolve } from "node:path";

const [work, ...pages] = process.argv.slice(2);
const { chromium } = createRequire(join(resolve(work), "package.json"))("playwright-core");
const REPEATS = Number(process.env.MUSTER_REPEATS ?? 3);
const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1];

/** The longest time between two frames while `step` is called for each of `n` frames; run in the page. */
const longest = async ({ n, what }) => {
  const { clock } = window.muster;
  const map = document.getElementById("map");
  const box = map.getBoundingClientRect();
  const frame = () => new Promise((go) => requestAnimationFrame(go));
  const steps = {
    time: (i) => clock.seek((clock.max * (i + 1)) / (n + 1)),
    zoom: (i) => map.dispatchEvent(new WheelEvent("wheel", { deltaY: i < n / 2 ? -250 : 250, bubbles: true, cancelable: true,
      clientX: box.left + box.width * 0.4, clientY: box.top + box.height * 0.4 })),
  };
  await frame();
  let before = await frame();
  let most = 0;
  for (let i = 0; i < n; ++i) {
    steps[what](i);
    await frame();
    const now = await frame();
    most = Math.max(most, now - before);
    before = now;
  }
  return most;
};

async function measure(browser, file, profile) {
  const context = await browser.newContext({ viewport: { width: 1440, height: 900 } });
  const page = await context.newPage();
  const tools = profile ? await context.newCDPSession(page) : null;
  if (tools) {
    await tools.send("Profiler.enable");
    await tools.send("Profiler.start");
  }
  await page.goto(`file://${resolve(file)}`);
  await page.locator("html[data-ready]").waitFor({ state: "attached" });
  const open = await page.evaluate(() => new Promise((done) => {
    requestAnimationFrame(() => requestAnimationFrame(() => done(performance.now())));
  }));
  const time = await page.evaluate(longest, { n: 40, what: "time" });
  const zoom = await page.evaluate(longest, { n: 20, what: "zoom" });
  if (tools) writeFileSync(profile, JSON.stringify((await tools.send("Profiler.stop")).profile));
  await context.close();
  return { open, time, zoom };
}

/** The page in `file`, and beside it the same without the scene. */
function both(file) {
  const bare = file.replace(/\.html$/, "-bare.html");
  writeFileSync(bare, readFileSync(file, "utf8").replace(/<script type="text\/x-muster-scene">.*?<\/script>/s, ""));
  return [[file, "with"], [bare, "without"]];
}

const browser = await chromium.launch({ executablePath: process.env.MUSTER_CHROMIUM ?? "/usr/bin/chromium",
  chromiumSandbox: process.getuid() !== 0 });
console.log("| page | scene | kB | usable after, ms | longest frame, time moves, ms | map zooms, ms |\n| --- | --- | --- | --- | --- | --- |");
for (const [file, scene] of pages.flatMap(both)) {
  const runs = [];
  for (let i = 0; i < REPEATS; ++i) runs.push(await measure(browser, file, i === REPEATS - 1 ? process.env.MUSTER_PROFILE : null));
  const of = (key) => median(runs.map((run) => run[key])).toFixed(0);
  console.log(`| ${basename(file, ".html").replace("-bare", "")} | ${scene} | ${(statSync(file).size / 1000).toFixed(0)} | ${of("open")} | ${of("time")} | ${of("zoom")} |`);
}
await browser.close();
