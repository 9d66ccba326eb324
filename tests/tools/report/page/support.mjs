// What the tests in Chromium share: runs, pages of them, a browser.
import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before } from "node:test";

export const { MUSTER_CHROMIUM, MUSTER_PROGRAM, MUSTER_SCENARIOS, MUSTER_WORK } = process.env;
const require = createRequire(join(MUSTER_WORK, "package.json"));
const { chromium } = require("playwright-core");
const axe = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
const folder = mkdtempSync(join(tmpdir(), "muster-page-"));
export const muster = (...args) => execFileSync(MUSTER_PROGRAM, args, { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
export const file = (name) => join(folder, name);
export const json = (name) => JSON.parse(readFileSync(file(name), "utf8"));
/** What a page is looked at in: [width, height, colour scheme]. MUSTER_LOOKS=all: each size in both schemes. */
export const LOOKS = process.env.MUSTER_LOOKS === "all" ?
  [[1440, 900], [1024, 768], [390, 844]].flatMap((size) => ["light", "dark"].map((scheme) => [...size, scheme])) :
  [[1440, 900, "light"], [1024, 768, "dark"], [390, 844, "light"]];
let started;
/** The browser of all tests. */
export const browser = () => started;

before(async () => {
  // The sandbox wants namespaces, which root in a container has not.
  started = await chromium.launch({ executablePath: MUSTER_CHROMIUM, chromiumSandbox: process.getuid() !== 0,
    args: ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"] }); // WebGL without a graphics card
  const scenario = join(MUSTER_SCENARIOS, "random_1.json");
  muster("simulate", scenario, "--policy", "mpq", "--log", "--out", file("a"));
  muster("simulate", scenario, "--policy", "kwta", "--log", "--out", file("b"));
  muster("report", file("a"), "--out", file("a.html"));
  muster("report", file("a"), file("b"), "--out", file("ab.html"));
});

after(async () => {
  await started?.close();
  rmSync(folder, { recursive: true });
});

/** Opens a page; whatever goes wrong in it, or wants to leave it, fails the test at the end. */
export async function open(t, name, options = {}, hash = "") {
  const context = await started.newContext({ viewport: { width: 1400, height: 900 }, colorScheme: "light", ...options });
  const page = await context.newPage();
  const wrong = [];
  const asked = [];
  page.on("console", (message) => wrong.push(`${message.type()}: ${message.text()}`));
  page.on("pageerror", (error) => wrong.push(String(error)));
  page.on("dialog", (dialog) => wrong.push(`dialog ${dialog.message()}`));
  page.on("request", (request) => asked.push(request.url()));
  t.after(async () => {
    await context.close();
    assert.deepEqual(wrong, []);
    assert.deepEqual([...new Set(asked.filter((url) => !url.startsWith("data:")).map((url) => url.split("#")[0]))], [`file://${file(name)}`]);
  });
  const press = page.keyboard.press.bind(page.keyboard);
  page.keyboard.press = async (key) => {
    await press(key);
    await drawn(page);
  };
  await page.goto(`file://${file(name)}${hash}`);
  await page.locator("html[data-ready]").waitFor({ state: "attached" });
  return page;
}

/** A mission that runs with a page: { run, url, ended (its exit code), said() }. It is ended with the test. */
export async function startMission(t, ...words) {
  const run = spawn(MUSTER_PROGRAM, ["run", ...words, "--live=0", "--control"], { stdio: ["ignore", "ignore", "pipe"] });
  t.after(() => run.kill("SIGKILL"));
  const ended = new Promise((resolve) => { run.once("exit", resolve); });
  let said = "";
  const url = await new Promise((resolve, reject) => {
    run.stderr.on("data", (data) => {
      said += data;
      const found = said.match(/live at (http:\S+)/);
      if (found) resolve(found[1]);
    });
    run.once("exit", (code) => reject(new Error(`muster run ended with ${code}: ${said}`)));
  });
  return { run, url, ended, said: () => said };
}

export const raw = async (page, key) => page.locator(`[data-key="${key}"]`).first().getAttribute("data-raw");
export const text = async (page, key) => page.locator(`[data-key="${key}"]`).first().innerText();
/** Once the page has drawn what it was last told. */
export const drawn = (page) => page.evaluate(() => new Promise((resolve) => {
  requestAnimationFrame(() => requestAnimationFrame(() => resolve()));
}));
export const scrub = async (page, minutes) => {
  await page.locator("#scrub").evaluate((input, t) => {
    input.value = t;
    input.dispatchEvent(new Event("input", { bubbles: true }));
  }, minutes * 60000);
  await drawn(page);
};

/** Once the page has drawn: `check` until it holds, ten seconds at most. */
export async function soon(check) {
  for (const until = Date.now() + 10_000; ;) {
    try {
      return await check();
    } catch (error) {
      if (Date.now() > until) throw error;
      await new Promise((resolve) => setTimeout(resolve, 20));
    }
  }
}

/** A canvas' picture, once it is drawn. */
export const picture = (page, id) => page.evaluate((name) => new Promise((resolve) => {
  requestAnimationFrame(() => requestAnimationFrame(() => resolve(document.getElementById(name).toDataURL())));
}), id);

/**
 * Names on the map: resolves to a function that tells those of the newest drawing, [{ text, left, right, top, bottom }]. A name is drawn
 * aside once and stamped from then on, so all are drawn anew after this.
 */
export async function namesOf(page) {
  await page.evaluate(() => {
    window.names = [];
    const texts = new WeakMap(); // by canvas, then by picture
    const { clearRect: clear, drawImage: stamp } = CanvasRenderingContext2D.prototype;
    const { fillText: write } = OffscreenCanvasRenderingContext2D.prototype;
    const { transferToImageBitmap: take } = OffscreenCanvas.prototype;
    OffscreenCanvasRenderingContext2D.prototype.fillText = function (text, ...at) {
      if (this.textAlign === "left" && this.font.startsWith("11px")) texts.set(this.canvas, { text, wide: this.measureText(text).width });
      return write.call(this, text, ...at);
    };
    OffscreenCanvas.prototype.transferToImageBitmap = function () {
      const made = take.call(this);
      if (texts.has(this)) texts.set(made, texts.get(this));
      return made;
    };
    CanvasRenderingContext2D.prototype.clearRect = function (...box) {
      if (this.canvas.id === "map") window.names = [];
      return clear.call(this, ...box);
    };
    CanvasRenderingContext2D.prototype.drawImage = function (what, x, y, ...size) {
      const name = this.canvas.id === "map" && texts.get(what);
      // Its halo is 3 pixels wide, and its line begins 15 pixels below the picture's upper edge.
      if (name) window.names.push({ text: name.text, left: x + 3, right: x + 3 + name.wide, top: y + 7, bottom: y + 17 });
      return stamp.call(this, what, x, y, ...size);
    };
  });
  await page.emulateMedia({ colorScheme: "dark" });
  await drawn(page);
  return () => page.evaluate(() => window.names);
}

/** No violation of axe-core's rules in the page as it is shown. */
export async function accessible(page, what) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => window.axe.run());
  assert.deepEqual(violations.map((v) => `${v.id}: ${v.nodes[0].html}`), [], what);
}
