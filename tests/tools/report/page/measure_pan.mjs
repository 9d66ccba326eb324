// node measure_pan.mjs WORK PAGE...: frames a second while the map of each page is dragged for some seconds, whole and zoomed
// in, and its longest frame; of a frame, the time that finding what is in view takes, and that of drawing it, and the processor
// time of all of Chromium. Rows of a table. WORK is where browser_tests.mjs put playwright-core. scripts/measure-page makes the pages.
import { createRequire } from "node:module";
import { basename, join, resolve } from "node:path";

const [work, ...pages] = process.argv.slice(2);
const { chromium } = createRequire(join(resolve(work), "package.json"))("playwright-core");
const SECONDS = Number(process.env.MUSTER_SECONDS ?? 4);
const ZOOMS = [1, 4, 16]; // times what the page opens with

/** Drags the map in circles, one step a frame; run in the page. */
const drag = async ({ seconds, zoom }) => {
  const { clock, parts: { map } } = window.muster;
  const canvas = document.getElementById("map");
  const box = canvas.getBoundingClientRect();
  const [x, y] = [box.left + box.width / 2, box.top + box.height / 2];
  const frame = () => new Promise((go) => requestAnimationFrame(go));
  const send = (type, i = 0) => canvas.dispatchEvent(new PointerEvent(type, { pointerId: 1, pointerType: "mouse", button: 0, bubbles: true,
    clientX: x + 200 * Math.sin(i / 40), clientY: y + 100 * Math.sin(i / 25) }));
  canvas.setPointerCapture = () => {}; // the pointer is made up
  clock.seek(clock.max * 0.6);
  map.home();
  for (let done = 1; done < zoom; done *= 2) {
    canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: -500, bubbles: true, cancelable: true, clientX: x, clientY: y }));
  }
  await frame();
  await frame();
  send("pointerdown");
  const frames = [];
  const took = { data: [], draw: [] };
  const start = await frame();
  for (let before = start, i = 1; before - start < 1000 * seconds; ++i) {
    send("pointermove", i);
    const now = await frame();
    frames.push(now - before);
    for (const key of ["data", "draw"]) took[key].push(map.took[key]);
    before = now;
  }
  send("pointerup");
  return { frames, ...took };
};

const mean = (values) => values.reduce((a, b) => a + b, 0) / values.length;
const most = (values) => values.reduce((a, b) => Math.max(a, b), 0);

/** Seconds of processor time that Chromium has used. */
async function processorTime(tools) {
  const { processInfo } = await tools.send("SystemInfo.getProcessInfo");
  return processInfo.reduce((sum, { cpuTime }) => sum + cpuTime, 0);
}

const browser = await chromium.launch({ executablePath: process.env.MUSTER_CHROMIUM ?? "/usr/bin/chromium",
  chromiumSandbox: process.getuid() !== 0 });
const tools = await browser.newBrowserCDPSession();
console.log("| page | zoom | frames a second | longest frame, ms | data, mean and longest, ms | drawing, mean and longest, ms | processor time, ms a frame |");
console.log("| --- | --- | --- | --- | --- | --- | --- |");
for (const file of pages) {
  const page = await (await browser.newContext({ viewport: { width: 1440, height: 900 } })).newPage();
  await page.goto(`file://${resolve(file)}`);
  await page.locator("html[data-ready]").waitFor({ state: "attached" });
  for (const zoom of ZOOMS) {
    const before = await processorTime(tools);
    const { frames, data, draw } = await page.evaluate(drag, { seconds: SECONDS, zoom });
    const used = (1000 * (await processorTime(tools) - before)) / frames.length;
    const both = (values) => `${mean(values).toFixed(1)}, ${most(values).toFixed(0)}`;
    console.log(`| ${basename(file, ".html")} | ${zoom} | ${(1000 / mean(frames)).toFixed(0)} | ${most(frames).toFixed(0)} | ${both(data)} | ${both(draw)} | ${used.toFixed(0)} |`);
  }
  await page.context().close();
}
await browser.close();
