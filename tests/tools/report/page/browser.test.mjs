// The pages that muster report writes, in Chromium. Run by browser_tests.mjs.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { MUSTER_PROGRAM, MUSTER_SCENARIOS, browser, file, json, muster, open, picture, raw, scrub, soon, text } from "./support.mjs";

test("the figures are those of report.json", async (t) => {
  const page = await open(t, "a.html");
  const report = json("a/report.json");
  await page.keyboard.press("End");
  const weight = report.decisions.reduce((sum, d) => sum + d.weight, 0);
  for (const [key, value] of [["completion_rate", report.completion_rate], ["tasks_done", report.tasks_done],
    ["charges", report.charges], ["flown_m", report.flown_m], ["solve_s", report.decisions.at(-1).solve_s],
    ["lost", report.processes.reduce((sum, p) => sum + p.lost, 0)], ["weight", weight]]) {
    const shown = Number(await raw(page, key));
    assert.ok(Math.abs(shown - value) <= 1e-9 * Math.abs(value), `${key}: ${shown}, not ${value}`);
  }
  assert.equal(await raw(page, "digest"), report.digest);
  assert.equal(await text(page, "tasks_done"), `${report.tasks_done} of ${report.tasks_total}`);
  assert.equal(await text(page, "completion_rate"), `${(100 * report.completion_rate).toFixed(1)} %`);
  assert.equal(await text(page, "policy"), report.policy);
  assert.equal(await text(page, "seed"), String(report.seed));
  assert.equal(await text(page, "scenario"), report.scenario.name);
  assert.equal(await text(page, "log"), "complete");
});

test("the clock scrubs, and every part follows", async (t) => {
  const page = await open(t, "a.html");
  const report = json("a/report.json");
  const maps = new Set();
  await page.keyboard.press("d");
  for (const minutes of [0, 45, 90.5, 140, 180]) {
    await scrub(page, minutes);
    const s = minutes * 60;
    const clock = `${Math.floor(s / 3600)}:${String(Math.floor(s / 60) % 60).padStart(2, "0")}:${String(s % 60).padStart(2, "0")}`;
    assert.equal(await page.locator("#time-now").innerText(), clock);
    // The world counts a task at the first tick after its end.
    const tick = report.scenario.tick_s;
    const done = report.tasks.filter((task) => task.done_s !== undefined && Math.ceil(task.done_s / tick) * tick <= s).length;
    assert.match(await page.locator("#now-completion").innerText(), new RegExp(`^${done} of ${report.tasks_total} `));
    const decision = report.decisions.filter((d) => d.sim_s <= s).at(-1);
    assert.equal(Number(await raw(page, "decision_weight")), decision.weight);
    assert.equal(await page.locator("#decision-now").innerText(), `decision ${decision.index}`);
    assert.equal(Number(await raw(page, "tasks_done")), done, "the header follows the time");
    assert.equal(Number(await raw(page, "weight")), report.decisions.filter((d) => d.sim_s <= s).reduce((sum, d) => sum + d.weight, 0));
    maps.add(await picture(page, "map"));
  }
  assert.equal(maps.size, 5, "the map shows another picture at each time");
});

test("it plays, and stops at the end", async (t) => {
  const page = await open(t, "a.html");
  await page.locator("#speed").selectOption("3600");
  await page.keyboard.press("Space");
  await page.waitForFunction(() => window.muster.clock.t > 10 * 60000);
  await page.waitForFunction(() => window.muster.clock.t === window.muster.clock.max && !window.muster.clock.playing);
  assert.equal(await page.locator("#time-now").innerText(), "3:00:00");
  assert.equal(await page.locator("#play").getAttribute("aria-label"), "Play");
});

test("the keyboard steps, filters and selects nothing", async (t) => {
  const page = await open(t, "a.html");
  const now = () => page.locator("#time-now").innerText();
  await page.keyboard.press("Home");
  await page.keyboard.press("]");
  await page.keyboard.press("]");
  assert.equal(await now(), "0:20:00");
  await page.keyboard.press("ArrowRight");
  assert.equal(await now(), "0:20:30");
  await page.keyboard.press("[");
  assert.equal(await now(), "0:20:00");
  await page.keyboard.press("1");
  assert.match(await page.locator("#gantt-count").innerText(), /^70 of 100 /);
  await page.keyboard.press("1");
  await page.locator("#filter").fill("vehicle:1");
  assert.match(await page.locator("#gantt-count").innerText(), /^11 of 100 /); // 1 and 10 to 19
  await page.locator("#filter").fill("");
  await page.locator("h1").click();
  await page.keyboard.press("?");
  assert.ok(await page.locator("#help").isVisible());
});

test("events to come are pale, and a click on one goes there", async (t) => {
  const page = await open(t, "a.html");
  const report = json("a/report.json");
  await scrub(page, 90);
  await page.keyboard.press("e");
  await page.locator("#panel-body tr.later").first().waitFor();
  const past = await page.locator("#panel-body tbody tr:not(.later)").count();
  const kinds = ["sensing_done", "sensing_aborted", "charging_done", "charging_aborted", "agent_failed", "match_failed"];
  const all = kinds.reduce((sum, kind) => sum + report.events[kind], 0);
  assert.equal(await page.locator("#panel-body tbody tr").count(), all);
  const done = report.tasks.filter((task) => task.done_s <= 90 * 60).length;
  assert.ok(past >= done && past < all, `${past} of ${all}, ${done} tasks done`);
  const next = page.locator("#panel-body tr.later").first();
  const at = await next.locator("td").first().innerText();
  await next.click();
  assert.equal(await page.locator("#time-now").innerText(), at);
  assert.equal(await page.locator("#panel-body tr:not(.later) td:first-child").last().innerText(), at);
});

test("a click on the timeline goes there and shows the agent", async (t) => {
  const page = await open(t, "a.html");
  await page.locator("#gantt-scroll").scrollIntoViewIfNeeded();
  const box = await page.locator("#gantt-scroll").boundingBox();
  // Rows are 18 px high below an axis of 22; the first is uav:0.
  await page.mouse.click(box.x + box.width / 2, box.y + 22 + 18 * 2.5);
  await soon(async () => assert.match(await page.locator("#selection").innerText(), /^uav:2: /));
  const t1 = await page.evaluate(() => window.muster.clock.t);
  assert.ok(t1 > 60 * 60000 && t1 < 110 * 60000, String(t1));
  await page.keyboard.press("Escape");
  await soon(async () => assert.ok(!(await page.locator("#selection").isVisible())));
});

test("a drag over a curve looks closer, a click sets the time, a double click shows all", async (t) => {
  const page = await open(t, "a.html");
  await page.keyboard.press("Home");
  await page.locator("#plot-weight").scrollIntoViewIfNeeded();
  const box = await page.locator("#plot-weight .plot-over").boundingBox();
  const at = (share) => [box.x + share * box.width, box.y + box.height / 2];
  const view = () => page.evaluate(() => window.muster.state.view);
  await page.mouse.move(...at(0.25));
  await page.mouse.down();
  await page.mouse.move(...at(0.75), { steps: 3 });
  assert.equal(await page.locator(".plot-selection:visible").count(), 4);
  await page.mouse.up();
  const [from, to] = await view();
  assert.ok(Math.abs(from - 45 * 60000) < 60000 && Math.abs(to - 135 * 60000) < 60000, `${from} ${to}`);
  assert.equal(await page.evaluate(() => window.muster.clock.t), 0, "the drag's end is no click");
  await page.mouse.click(...at(0.5));
  const now = await page.evaluate(() => window.muster.clock.t);
  assert.ok(Math.abs(now - 90 * 60000) < 60000, String(now));
  await page.mouse.dblclick(...at(0.5));
  assert.equal(await view(), null);
});

test("the map is zoomed by the wheel and moved by a drag, which selects nothing", async (t) => {
  const page = await open(t, "a.html");
  const box = await page.locator("#map").boundingBox();
  const maps = [await picture(page, "map")];
  await page.mouse.move(box.x + 600, box.y + 200);
  await page.mouse.wheel(0, -600);
  maps.push(await picture(page, "map"));
  await page.mouse.down();
  const written = await page.evaluate(() => {
    window.written = 0;
    new MutationObserver((changes) => { window.written += changes.length; }).observe(document.getElementById("map-cursor"), { childList: true });
    return document.getElementById("map-cursor").textContent;
  });
  await page.mouse.move(box.x + 660, box.y + 240, { steps: 3 });
  assert.equal(await page.evaluate(() => window.written), 0, "the map goes with the pointer: what is below it is not looked for");
  assert.equal(await page.locator("#map-cursor").innerText(), written);
  await page.mouse.up();
  await page.mouse.move(box.x + 640, box.y + 240);
  assert.notEqual(await page.locator("#map-cursor").innerText(), written);
  maps.push(await picture(page, "map"));
  assert.equal(new Set(maps).size, 3);
  assert.ok(!(await page.locator("#selection").isVisible()));
  await page.locator("#map-reset").click();
  await page.mouse.move(box.x + 600, box.y - 5);
  assert.equal(await picture(page, "map"), maps[0]);
});

test("a phone shows all of it without scrolling sideways", async (t) => {
  const page = await open(t, "a.html", { viewport: { width: 360, height: 740 }, deviceScaleFactor: 3, isMobile: true, hasTouch: true });
  for (const tab of ["decision", "events", "processes"]) {
    await page.locator(`#panel-tabs button[data-tab=${tab}]`).tap();
    const [wide, shown] = await page.evaluate(() => [document.documentElement.scrollWidth, window.innerWidth]);
    assert.equal(shown, 360);
    assert.ok(wide <= 360, `${wide} px wide on ${tab}`);
  }
  const opened = await page.evaluate(() => window.muster.clock.t);
  await page.locator("#play").tap();
  await page.waitForFunction((t) => window.muster.clock.t > t, opened);
});

test("dark and light follow the system", async (t) => {
  const colours = [];
  for (const colorScheme of ["dark", "light"]) {
    const page = await open(t, "a.html", { colorScheme });
    colours.push(await page.evaluate(() => getComputedStyle(document.documentElement).backgroundColor.match(/\d+/g).map(Number)));
  }
  assert.ok(Math.max(...colours[0]) < 64 && Math.min(...colours[1]) > 192, JSON.stringify(colours));
});

test("several runs are compared", async (t) => {
  const page = await open(t, "ab.html");
  const reports = [json("a/report.json"), json("b/report.json")];
  const rows = await page.locator("#comparison-body .wide").first().locator("tbody tr").allInnerTexts();
  assert.equal(rows.length, 2);
  reports.forEach((report, i) => {
    assert.ok(rows[i].includes(`${(100 * report.completion_rate).toFixed(1)} %`), rows[i]);
    assert.ok(rows[i].includes(report.digest.slice(0, 12)), rows[i]);
  });
  const same = (a, b) => JSON.stringify(a.actions) === JSON.stringify(b.actions);
  const first = reports[0].decisions.findIndex((d, i) => !same(d, reports[1].decisions[i]));
  assert.ok(rows[1].includes(`decision ${first}`), rows[1]);
  await page.locator("#tabs button").nth(1).click();
  await page.keyboard.press("End");
  assert.equal(Number(await raw(page, "tasks_done")), reports[1].tasks_done);
  await page.locator("#axis").selectOption("decision");
  assert.equal(await page.locator("#plot-weight canvas").count(), 1);
  await page.locator("#comparison-body summary").click();
  assert.equal(await page.locator("#comparison-body .tall tbody tr").count(), reports[0].decisions.length);
});

test("two thousand agents fit in a canvas of bounded size, down to the last", async (t) => {
  muster("scenario", "--preset", "Random_29", "--scale", "5", "--limit", "20", "--online-min", "10:", "--out", file("big.json"));
  muster("simulate", file("big.json"), "--policy", "greedy-nearest", "--log", "--out", file("big"));
  muster("report", file("big"), "--out", file("big.html"));
  const page = await open(t, "big.html");
  assert.match(await page.locator("#gantt-count").innerText(), /^2000 of 2000 /);
  const height = await page.locator("#gantt").evaluate((canvas) => canvas.height);
  assert.ok(height < 2000, String(height));
  await page.locator("#gantt-scroll").evaluate((box) => { box.scrollTop = box.scrollHeight; });
  const box = await page.locator("#gantt-scroll").boundingBox();
  await page.locator("#gantt-scroll").click({ position: { x: box.width / 2, y: box.height - 6 } });
  await soon(async () => assert.match(await page.locator("#selection").innerText(), /^vehicle:399: /));
});

test("names from a file are text, never markup", async (t) => {
  const name = "<img src=x onerror=alert(1)></script><b>$&";
  const scenario = JSON.parse(readFileSync(join(MUSTER_SCENARIOS, "random_1.json"), "utf8"));
  writeFileSync(file("evil.json"), JSON.stringify({ ...scenario, name, limit_min: 20 }));
  muster("simulate", file("evil.json"), "--policy", "greedy-nearest", "--log", "--out", file("evil"));
  muster("report", file("evil"), "--out", file("evil.html"));
  const page = await open(t, "evil.html");
  assert.equal(await text(page, "scenario"), name);
  assert.equal(await page.locator("img").count(), 0);
});

test("a mission that runs is shown until its end, with the numbers of its report", async (t) => {
  const run = spawn(MUSTER_PROGRAM, ["run", join(MUSTER_SCENARIOS, "random_1.json"), "--limit", "60", "--rate", "600", "--live=0", "--out", file("live")], { stdio: ["ignore", "ignore", "pipe"] });
  const ended = new Promise((resolve) => run.on("exit", (code) => resolve(code)));
  t.after(() => run.kill("SIGKILL"));
  let said = "";
  const url = await new Promise((resolve) => run.stderr.on("data", (data) => {
    said += data;
    const found = said.match(/live at (http:\S+)/);
    if (found) resolve(found[1]);
  }));
  const page = await (await browser().newContext()).newPage();
  const wrong = [];
  const asked = new Set();
  page.on("console", (message) => wrong.push(message.text()));
  page.on("pageerror", (error) => wrong.push(String(error)));
  page.on("request", (request) => asked.add(request.url()));
  await page.goto(url);
  // A slow browser may find the mission over already.
  await page.waitForFunction(() => ["live", "ended"].includes(document.getElementById("live-state").textContent));
  await page.waitForFunction(() => window.muster.clock.t > 0 && window.muster.clock.follow);
  await page.waitForFunction(() => document.getElementById("live-state").textContent === "ended");
  await page.waitForFunction(() => window.muster.state.run.report?.log.complete);
  while (!said.includes("the page stays")) await new Promise((resolve) => run.stderr.once("data", resolve));
  const report = json("live/report.json");
  await page.waitForFunction(() => document.getElementById("time-now").innerText === "1:00:00");
  assert.equal(Number(await raw(page, "tasks_done")), report.tasks_done);
  assert.equal(await raw(page, "digest"), report.digest);
  assert.deepEqual([...asked].filter((other) => !other.startsWith("data:")), [url, `${url}events`]);
  run.kill("SIGINT");
  assert.equal(await ended, 0);
  await page.waitForFunction(() => document.getElementById("live-state").textContent === "closed");
  assert.deepEqual(wrong, []);
});
