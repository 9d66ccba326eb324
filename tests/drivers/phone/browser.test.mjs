// The page in Chromium, at a phone's size, with a position that the test makes.
import assert from "node:assert/strict";
import { once } from "node:events";
import { mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { helloOf, map } from "./box.mjs";
import { linkOf, MAIN, withPrograms } from "./programs.mjs";

const { MUSTER_CHROMIUM, MUSTER_WORK } = process.env;
const require = createRequire(join(MUSTER_WORK, "package.json"));
const { chromium } = require("playwright-core");
const axe = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
const PNG = Buffer.from("iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==", "base64");
const START = { x_m: 4000, y_m: 4000 }, GOAL = { x_m: 4010, y_m: 4000 };

let browser = null;
before(async () => {
  // The sandbox wants namespaces, which root in a container has not.
  browser = await chromium.launch({ executablePath: MUSTER_CHROMIUM, chromiumSandbox: process.getuid() !== 0 });
});
after(() => browser?.close());

const positionAt = (place, accuracy = 6) => {
  const { latitude_deg, longitude_deg } = map.toDegrees(place);
  return { latitude: latitude_deg, longitude: longitude_deg, accuracy };
};

/** Runs `body({driver, page, context, goTo, tick, folder})` with a driver, told hello, and its page in a phone. */
async function withPhone(body, more = {}, isThere = true, words = []) {
  const folder = mkdtempSync(join(tmpdir(), "muster-phone-"));
  try {
    await withPrograms(async ({ start }) => {
      const driver = start(process.execPath, [MAIN, "--run", folder, ...words]);
      driver.say(helloOf({ rate: 60, ...more }));
      const link = await linkOf(driver);
      const context = await browser.newContext({ viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true, deviceScaleFactor: 2, colorScheme: "light",
        geolocation: positionAt(START), permissions: isThere ? ["geolocation"] : [] });
      const page = await context.newPage();
      const wrong = [];
      page.on("pageerror", (error) => wrong.push(String(error)));
      page.on("console", (message) => message.text().includes("net::ERR_") || wrong.push(`${message.type()}: ${message.text()}`));
      page.on("request", (request) => request.url().startsWith(new URL(link).origin) || request.url().startsWith("data:") || wrong.push(`asks ${request.url()}`));
      await page.goto(link);
      let ticks = 0;
      const tick = () => driver.say({ type: "time", mission_s: 30 * ++ticks });
      const goTo = (to = GOAL, words = {}) => driver.say({ type: "goto", id: 1, mission_s: 30 * ticks, to: { ...to, ...map.toDegrees(to) }, expected_s: 1800, then: "sense", task: 12,
        charging_point: null, partner: "uav:3", ...words });
      try {
        await body({ driver, page, context, goTo, tick, folder, link });
      } finally {
        await context.close();
      }
      assert.deepEqual(wrong, []);
    });
  } finally {
    rmSync(folder, { recursive: true });
  }
}

async function accessible(page) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => window.axe.run());
  assert.deepEqual(violations.map((v) => `${v.id}: ${v.nodes[0].html}`), []);
}

const shows = (page, text) => page.getByText(text).first().waitFor();

/** Ticks until the driver says such a state. */
async function until(driver, tick, isIt) {
  for (let from = 0; ;) {
    tick();
    const line = await driver.line((some) => some.startsWith('{"type":"state"'), from);
    from = driver.lines.indexOf(line, from) + 1;
    if (isIt(JSON.parse(line))) return;
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
}

/** Mission time goes on until the driver says that its person is there. */
async function ticksUntilArrived(driver, tick) {
  const until_ms = Date.now() + 30_000;
  for (let isThere = false; !isThere; tick()) {
    assert.ok(Date.now() < until_ms, "nobody arrived within 30 s");
    await new Promise((resolve) => setTimeout(resolve, 20));
    isThere = driver.lines.includes('{"type":"arrived","id":1}');
  }
}

test("a worker is sent, is seen on the way, is there, senses, takes a photo", () => withPhone(async ({ driver, page, context, goTo, tick, folder }) => {
  await shows(page, "connected");
  await shows(page, "Nothing to do yet");
  await accessible(page);
  goTo({ x_m: 4400, y_m: 4300 });
  await shows(page, "Go to task 12");
  await shows(page, "500 m to the north-east");
  await shows(page, "With uav:3");
  assert.match(await page.locator("#geo").getAttribute("href"), /^geo:18\.\d{6},-72\.\d{6}\?q=/);
  await shows(page, "Your place is good to 6 m.");
  await context.setGeolocation(positionAt({ x_m: 4100, y_m: 4075 }));
  await until(driver, tick, ({ at }) => Math.hypot(at.x_m - 4100, at.y_m - 4075) < 1);
  await shows(page, /380 m to the north-east|370 m to the north-east/);
  await accessible(page);
  if (process.env.MUSTER_PICTURE) {  // docs/images/phone.webp
    const session = await context.newCDPSession(page);
    const { data } = await session.send("Page.captureScreenshot", { format: "webp", quality: 80 });
    writeFileSync(process.env.MUSTER_PICTURE, Buffer.from(data, "base64"));
  }
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing is beside the screen");
  await page.getByRole("button", { name: "I am here" }).tap();
  await shows(page, /your phone is 3[78]0 m from there; if you are there, press again/);
  await page.getByRole("button", { name: "I am here" }).tap();
  await ticksUntilArrived(driver, tick);
  driver.say({ type: "sense", id: 2, mission_s: 600, for_s: 60 });
  await shows(page, "At task 12: the UAV is at work");
  await context.setOffline(true);
  await shows(page, /no connection/);
  await page.locator("#photo").setInputFiles({ name: "../evil name.png", mimeType: "image/png", buffer: PNG });
  await shows(page, "1 thing waits to be sent. Keep this page open.");
  await context.setOffline(false);
  await shows(page, /sent: worker-4_task-12_.*\.png/);
  const files = readdirSync(join(folder, "photos"));
  assert.equal(files.length, 2, files.join());
  assert.ok(files.every((name) => /^worker-4_task-12_\d+m-\d+m_\d+s_1\.(png|json)$/.test(name)), files.join());
  await page.getByRole("button", { name: "Done" }).tap();
  await driver.said("done");
  await shows(page, "Done; wait here");
  driver.say({ type: "bye", reason: "the mission is over" });
  await shows(page, "You may close this page.");
  assert.equal(await driver.ended, 0);
}));

test("a person is late, has a break, sends a message, calls for help and is all right again", () => withPhone(async ({ driver, page, goTo, tick }) => {
  await shows(page, "Nothing to do yet");
  assert.ok(await page.getByRole("button", { name: "I will be late" }).isDisabled());
  goTo({ x_m: 4400, y_m: 4300 }, { priority: 3, due_s: 3600 });
  await shows(page, "An emergency");
  await shows(page, /To be done by 1:00:00/);
  await page.getByRole("button", { name: "I will be late" }).tap();
  await accessible(page);
  await page.locator("#minutes").selectOption("20");
  await page.locator("#ask-late").getByRole("button", { name: "Send" }).tap();
  await until(driver, tick, ({ expected_s }) => expected_s >= 1800 + 20 * 60 * 60);  // twenty minutes of the clock, sixty times as fast
  await page.getByRole("button", { name: "Take a break" }).tap();
  await shows(page, "Your break begins when this is done.");
  assert.equal((await driver.said("not_ready")).reason, "the end of a break");
  await page.getByRole("button", { name: "My break is over" }).tap();
  await shows(page, "Take a break");
  await page.getByRole("button", { name: "Message", exact: true }).tap();
  await page.locator("#text").fill("the way is blocked");
  await page.locator("#ask-message").getByRole("button", { name: "Send" }).tap();
  await shows(page, 'sent: "Message"');
  assert.deepEqual(await driver.said("message"), { type: "message", text: "the way is blocked" });
  await page.getByRole("button", { name: "Call for help" }).first().tap();
  await accessible(page);
  await page.locator("#trouble").fill("I am trapped");
  await page.locator("#ask-help").getByRole("button", { name: "Call for help" }).tap();
  await shows(page, "You have called for help: I am trapped");
  await driver.line((line) => line === '{"type":"message","text":"I am trapped","help":true}');
  await accessible(page);
  await page.getByRole("button", { name: "I am all right again" }).tap();
  await driver.line((line) => line === '{"type":"message","text":"all right again"}');
  await page.locator("#called").getByText("You have called").waitFor({ state: "detached" });
  // What is called off in a dialog is not sent.
  await page.getByRole("button", { name: "Call for help" }).first().tap();
  await page.locator("#ask-help").getByRole("button", { name: "Back" }).tap();
  tick();
  await new Promise((resolve) => setTimeout(resolve, 1500));
  assert.equal(driver.lines.filter((line) => line.startsWith('{"type":"message"')).length, 3);
}));

for (const [code, words] of [["fr", "Rien à faire pour l’instant"], ["es", "Nada que hacer por ahora"], ["zh", "暂无任务"]]) {
  test(`the page speaks ${code}, and remembers it`, () => withPhone(async ({ page, goTo }) => {
    await shows(page, "Nothing to do yet");
    await page.locator("#language").selectOption(code);
    await shows(page, words);
    assert.equal(await page.locator("html").getAttribute("lang"), code);
    goTo({ x_m: 4400, y_m: 4300 });
    await page.locator("#act:enabled").waitFor();
    await accessible(page);
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing is beside the screen");
    await page.reload();
    await page.waitForFunction((chosen) => document.getElementById("language").value === chosen, code);
  }));
}

test("the page opens without connection, and sends what is pressed when it is back", () => withPhone(async ({ driver, page, context, goTo, tick }) => {
  goTo();
  await shows(page, "Go to task 12");
  await page.evaluate(() => navigator.serviceWorker.ready);
  await page.reload();
  await shows(page, "Go to task 12");
  await context.setOffline(true);
  await page.reload();
  await shows(page, /no connection/);
  await context.setOffline(false);
  await shows(page, "Go to task 12");
  await page.getByRole("button", { name: "I am here" }).tap();
  await ticksUntilArrived(driver, tick);
  const manifest = await page.evaluate(async () => (await fetch("app.webmanifest")).json());
  assert.equal(manifest.start_url, "./");
}));

test("the mission's base map lies below, with its source", async () => {
  // Zoom 13, of shapes: water everywhere but in the west of each tile.
  const asked = [];
  const live = createServer((question, answer) => {
    asked.push(question.url);
    const shapes = Array.from({ length: 10 }, () => []);
    shapes[2] = [[1000, 0, 3096, 0, 0, 4096, -3096, 0]];
    const content = question.url === "/tiles.json" ? { source: "© somebody", vector: true, type: "", zooms: [10, 13], units: 4096 } : { shapes, names: [], streets: [] };
    answer.writeHead(200, { "Content-Type": "application/json" }).end(JSON.stringify(content));
  }).listen(0, "127.0.0.1");
  await once(live, "listening");
  try {
    await withPhone(async ({ page, goTo }) => {
      goTo({ x_m: 7000, y_m: 6000 });
      await shows(page, "© somebody");
      await page.waitForFunction(() => {
        const { width, height } = document.getElementById("ground");
        const copy = Object.assign(document.createElement("canvas"), { width, height }).getContext("2d", { willReadFrequently: true });
        copy.drawImage(document.getElementById("ground"), 0, 0);
        const { data } = copy.getImageData(0, 0, width, height);
        const filled = data.filter((value, i) => i % 4 === 3 && value > 0).length / (data.length / 4);
        return filled > 0.6 && filled < 0.9;  // three quarters of each tile
      });
      await accessible(page);
      assert.ok(asked.filter((url) => url.startsWith("/tiles/13/")).length >= 2, asked.join());
      assert.equal(new Set(asked).size, asked.length, "each once");
    }, {}, true, ["--tiles", `http://127.0.0.1:${live.address().port}`]);
  } finally {
    live.close();
    live.closeAllConnections();
  }
});

test("the arrow shows where the phone points, and a line says where the way leads from there", () => withPhone(async ({ page, goTo }) => {
  goTo({ x_m: 4400, y_m: 4400 });
  await shows(page, "Your place is good to 6 m.");
  assert.equal(await page.locator("#map path.own").count(), 0);
  await page.evaluate(() => dispatchEvent(Object.assign(new Event("deviceorientationabsolute"), { alpha: 270 })));  // to the east
  await shows(page, "ahead on the left");
  assert.match(await page.locator("#map path.own").getAttribute("transform"), /rotate\(90\)/);
}));

test("a person sees the way by road on the map, and another when a road is closed", () => withPhone(async ({ page, goTo, tick }) => {
  goTo({ x_m: 4400, y_m: 4300 }, { via: [{ x_m: 4400, y_m: 4000 }] });
  tick();
  await shows(page, "700 m by road to the north-east");
  const corners = async () => (await page.locator("#map .way").getAttribute("points")).split(" ").length;
  assert.equal(await corners(), 3);
  await accessible(page);
  goTo({ x_m: 4400, y_m: 4300 }, { id: 2, via: [{ x_m: 4000, y_m: 4600 }, { x_m: 4400, y_m: 4600 }] });
  tick();
  await shows(page, "1.3 km by road to the north-east");
  assert.equal(await corners(), 4);
}));

test("what is pressed without connection is sent when it is back, once, also by a page that was opened again", () => withPhone(async ({ driver, page, context, goTo, tick }) => {
  goTo();
  tick();
  await shows(page, "Go to task 12");
  await context.setOffline(true);
  await shows(page, /no connection; last heard/);
  assert.equal(await page.locator("#connection").getAttribute("data-state"), "lost");
  await page.getByRole("button", { name: "I am here" }).tap();
  await shows(page, "I am here – not sent yet");
  await shows(page, "1 thing waits to be sent. Keep this page open.");
  await accessible(page);
  assert.ok(!driver.lines.some((line) => line.includes("arrived")));
  assert.equal(await page.evaluate(() => JSON.parse(localStorage.getItem(`muster-phone-${location.pathname}`)).filter(({ type }) => type === "here").length), 1);
  await context.setOffline(false);
  await page.reload();
  // The page that goes may have sent it already, and its note that it did is gone with it.
  await ticksUntilArrived(driver, tick);
  await shows(page, "Wait here for uav:3");
  assert.equal(driver.lines.filter((line) => line.includes("here, pressed")).length, 1);
  await page.waitForFunction(() => localStorage.length === 0);  // nothing is left in the phone
}));

test("who cannot go on is asked back, and is out with the reason", () => withPhone(async ({ driver, page, goTo }) => {
  goTo();
  await shows(page, "Go to task 12");
  await page.getByRole("button", { name: "I cannot" }).tap();
  await shows(page, "Leave the mission?");
  await accessible(page);
  await page.getByRole("button", { name: "Stay" }).tap();
  await page.getByRole("button", { name: "I cannot" }).tap();
  await page.getByRole("button", { name: "Leave the mission" }).tap();
  assert.ok(await page.locator("#ask-cannot").isVisible(), "it wants a reason");
  await page.getByLabel("Why can you not go on?").fill("the bridge is down");
  await page.getByRole("button", { name: "Leave the mission" }).tap();
  assert.deepEqual(await driver.said("failed"), { type: "failed", id: 1, reason: "says: the bridge is down" });
  await shows(page, "You are out of the mission");
  await page.getByRole("button", { name: "Call for help" }).first().tap();
  await page.locator("#trouble").fill("somebody is hurt");
  await page.locator("#ask-help").getByRole("button", { name: "Call for help" }).tap();
  assert.deepEqual(await driver.said("message"), { type: "message", text: "somebody is hurt", help: true });
}));

test("a vehicle, without a position, in the dark", () => withPhone(async ({ driver, page, goTo, tick }) => {
  await page.emulateMedia({ colorScheme: "dark" });
  goTo(GOAL, { then: "charge", task: null, charging_point: 2 });
  tick();
  await shows(page, "Go to charging point 2");
  await shows(page, /Your place is not known: this page may not ask for it/);
  await accessible(page);
  await page.getByRole("button", { name: "I am here" }).tap();
  tick();
  await driver.said("arrived");
  driver.say({ type: "charge", id: 2, mission_s: 60, for_s: 60 });
  await page.getByRole("button", { name: "Battery changed" }).tap();
  assert.equal((await driver.said("done")).id, 2);
}, { agent: "vehicle:1", class: "vehicle", speed_m_s: 12.5 }, false));
