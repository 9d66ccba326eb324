// What an incident commander does with the page, in Chromium. Run by browser_tests.mjs.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { before, test } from "node:test";
import { inflateSync } from "node:zlib";
import { LOOKS, MUSTER_SCENARIOS, accessible, file, json, muster, namesOf, open, picture, raw, scrub, soon } from "./support.mjs";

const now = (page) => page.locator("#time-now").innerText();

before(() => {
  // A run with faults: packets lost for ten minutes, and a UAV that is silent, so it fails.
  muster("run", join(MUSTER_SCENARIOS, "random_1.json"), "--policy", "mpq", "--quiet", "--limit", "120",
    "--fault", "loss:*@30+5=0.3", "--fault", "agent_silent:uav:3@50+10", "--out", file("faulty"));
  muster("report", file("faulty"), "--out", file("faulty.html"));
});

for (const [width, height, colorScheme] of LOOKS) {
  test(`attention, card and tasks at ${width} x ${height}, ${colorScheme}`, async (t) => {
    const phone = width < 500;
    const page = await open(t, "a.html", { viewport: { width, height }, colorScheme, isMobile: phone, hasTouch: phone, reducedMotion: "reduce" });
    await accessible(page, "as it opens");
    const map = await page.locator("#map").boundingBox();
    if (phone) await page.locator("#sheet-handle").tap();
    await page.locator("#attention-list .alarm").first().click();
    await page.locator("#card").waitFor();
    const card = await page.locator("#card").boundingBox();
    assert.ok(card.y >= 0 && card.y + card.height <= height, `the card is in view: ${JSON.stringify(card)}`);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width);
    const after = await page.locator("#map").boundingBox();
    assert.deepEqual([after.width, after.height], [map.width, map.height], "the card does not shrink the map");
    await accessible(page, "with a card");
    for (const tab of width === 1440 ? ["decision", "events", "processes"] : []) {
      await page.locator(`#panel-tabs [data-tab=${tab}]`).click();
      await accessible(page, tab);
    }
  });
}

test("the page opens at its most telling moment and says which", async (t) => {
  const calm = await open(t, "a.html");
  await soon(async () => assert.match(await calm.locator("#moment").innerText(), /^Opened at \d:\d\d:\d\d, progress slackens from here: \d+ of 120 tasks done, \d+ at 3:00\.$/));
  await soon(async () => assert.ok((await calm.locator("#moment").innerText()).includes(await now(calm))));
  await scrub(calm, 10);
  await soon(async () => assert.ok(!(await calm.locator("#moment").isVisible())));
  const faulty = await open(t, "faulty.html");
  await soon(async () => assert.match(await faulty.locator("#moment").innerText(), /^Opened at 0:30:\d\d, the first failure: flag\d: loss \*\.$/));
});

test("a link opens a moment and a selection, and the back button goes through selections", async (t) => {
  const page = await open(t, "a.html", {}, "#t=4800&sel=uav:2");
  await soon(async () => assert.equal(await now(page), "1:20:00"));
  await soon(async () => assert.equal(await page.locator("#card-title").innerText(), "uav:2"));
  await page.locator("#panel-tabs [data-tab=tasks]").click();
  await page.locator("#task-table tr[data-task='4']").click();
  await soon(async () => assert.equal(await page.evaluate(() => location.hash), "#t=4800&sel=task:4"));
  await scrub(page, 100);
  await page.waitForFunction(() => location.hash === "#t=6000&sel=task:4");
  await page.goBack();
  await soon(async () => assert.equal(await page.locator("#card-title").innerText(), "uav:2"));
  await soon(async () => assert.equal(await now(page), "1:20:00"));
  await page.goForward();
  await soon(async () => assert.equal(await page.locator("#card-title").innerText(), "task 4"));
  await soon(async () => assert.equal(await now(page), "1:40:00"));
  await page.evaluate(() => { location.hash = "#t=60&sel=worker:999"; });
  await page.waitForFunction(() => window.muster.clock.t === 60000);
  await soon(async () => assert.ok(!(await page.locator("#card").isVisible()), "what the run does not have is not selected"));
});

test("tasks are sorted, filtered and chosen with the keyboard", async (t) => {
  const page = await open(t, "a.html");
  const { tasks } = json("a/report.json");
  await page.keyboard.press("End");
  const rows = page.locator("#task-table tbody tr");
  const ids = async () => (await rows.evaluateAll((list) => list.map((row) => Number(row.dataset.task))));
  await soon(async () => assert.equal((await ids()).length, tasks.length));
  await page.locator("#task-filter").selectOption("never");
  await soon(async () => assert.deepEqual(await ids(), tasks.filter((task) => task.status !== "done").map((task) => task.id)));
  await page.locator("#task-filter").selectOption("done");
  await page.locator("th button", { hasText: "in the end" }).click();
  const byTime = tasks.filter((task) => task.status === "done").sort((a, b) => a.done_s - b.done_s || a.id - b.id).map((task) => task.id);
  await soon(async () => assert.deepEqual(await ids(), byTime));
  await soon(async () => assert.equal(await page.locator("th[aria-sort=ascending]").innerText(), "in the end ▲".replace(" ▲", "")));
  await page.locator("th button", { hasText: "in the end" }).click();
  await soon(async () => assert.equal((await ids())[0] === byTime.at(-1) || tasks[(await ids())[0]].done_s === tasks[byTime.at(-1)].done_s, true));
  await page.locator("#task-find").fill("uav:3");
  await soon(async () => {
    for (const row of await rows.allInnerTexts()) assert.match(row, /uav:3/);
  });
  await page.locator("#task-find").fill("");
  await soon(async () => assert.equal((await ids()).length, byTime.length));
  await rows.first().focus();
  await page.keyboard.press("ArrowDown");
  await page.keyboard.press("ArrowDown");
  await page.keyboard.press("Enter");
  const third = (await ids())[2];
  await soon(async () => assert.equal(await page.locator("#card-title").innerText(), `task ${third}`));
  await soon(async () => assert.equal(Number(await page.locator("#task-table tr[aria-selected=true]").getAttribute("data-task")), third));
  await soon(async () => assert.equal(await page.locator("#card-facts dd").first().innerText(),
    `done at ${clock(tasks[third].done_s)} by uav:${tasks[third].uav} and worker:${tasks[third].worker}`));
});

const clock = (s) => `${Math.floor(s / 3600)}:${String(Math.floor(s / 60) % 60).padStart(2, "0")}:${String(Math.floor(s) % 60).padStart(2, "0")}`;

test("an agent's card says where to, with whom, and when it is there", async (t) => {
  const page = await open(t, "a.html");
  const report = json("a/report.json");
  // A pair that was sent to sense and did: of it, the UAV just after it was sent.
  const decision = report.decisions.find((d) => d.actions.some((a) => a.kind === 7 && report.tasks[a.task].uav === a.uav && report.tasks[a.task].done_s - d.sim_s > 300));
  const action = decision.actions.find((a) => a.kind === 7 && report.tasks[a.task].uav === a.uav && report.tasks[a.task].done_s - decision.sim_s > 300);
  await page.evaluate(([t0, uav]) => { location.hash = `#t=${t0 + 31}&sel=uav:${uav}`; }, [decision.sim_s, action.uav]);
  await page.waitForFunction((uav) => document.getElementById("card-title").textContent === `uav:${uav}`, action.uav);
  const facts = await page.locator("#card-facts").innerText();
  assert.ok(facts.includes(`task ${action.task}`), facts);
  assert.ok(facts.includes(`worker:${action.worker}`), facts);
  assert.ok(facts.includes(clock(report.tasks[action.task].done_s)), facts);
  await soon(async () => assert.ok((await page.locator("#card-more").innerText()).includes(`decision ${decision.index}: uav:${action.uav} and worker:${action.worker} sense task ${action.task}`)));
  await page.locator("#card-facts button", { hasText: `worker:${action.worker}` }).click();
  await soon(async () => assert.equal(await page.locator("#card-title").innerText(), `worker:${action.worker}`));
});

test("what needs attention follows the time, failures before tasks before waiting", async (t) => {
  const page = await open(t, "faulty.html");
  await scrub(page, 32);
  const groups = () => page.locator("#attention-list h3").allInnerTexts();
  await soon(async () => assert.match((await groups())[0], /^Faults in force 1$/));
  await scrub(page, 55);
  await soon(async () => assert.match((await groups())[0], /^Agents failed 1$/));
  await page.locator(".a-failed").click();
  await soon(async () => assert.equal(await page.locator("#card-title").innerText(), "uav:3"));
  await soon(async () => assert.match(await page.locator("#card-facts").innerText(), /failed/));
  await page.keyboard.press("End");
  const titles = await groups();
  assert.ok(titles.some((title) => /^Not done \d+$/.test(title)), titles.join());
  const report = json("faulty/report.json");
  const undone = report.tasks.filter((task) => task.status !== "done").length;
  assert.ok(titles.includes(`Not done ${undone}`), `${undone}: ${titles}`);
  await page.locator(".more").first().click();
  await soon(async () => assert.equal(await page.locator("#task-table tbody tr").count(), undone));
});

test("a packet fault is one row that says its kind, a failed agent a tick and no line", async (t) => {
  const page = await open(t, "faulty.html");
  await page.keyboard.press("e");
  const rows = await page.locator("#panel-body tbody tr").allInnerTexts();
  assert.equal(rows.filter((row) => /\tloss applied\t/.test(row)).length, 1, rows.filter((row) => /loss/.test(row)).join("\n"));
  assert.match(rows.find((row) => /loss applied/.test(row)), /\* at \d+ processes/);
  // The row of pixels in which a band of one agent is drawn, at the chart's right end.
  await page.keyboard.press("Home");
  const red = await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => {
    const canvas = document.querySelector("#plot-completion canvas");
    const data = canvas.getContext("2d").getImageData(0, 18, canvas.width, 1).data;
    let count = 0;
    for (let i = 0; i < data.length; i += 4) if (data[i] > 180 && data[i + 1] < 120 && data[i + 2] < 80 && data[i + 3] > 100) ++count;
    resolve(count);
  }))));
  assert.ok(red >= 1 && red < 12, `${red} red pixels`);
});

test("filters count what they show, and the legend names every mark", async (t) => {
  const page = await open(t, "a.html");
  await scrub(page, 60);
  const sum = async () => (await page.locator("#statuses b").allInnerTexts()).reduce((total, n) => total + Number(n), 0);
  const all = await sum();
  const uavs = Number((await page.locator(".k0 b").innerText()).match(/\d+/)[0]);
  await page.keyboard.press("1");
  await soon(async () => assert.equal(await page.locator(".k0 b").innerText(), "hidden"));
  await soon(async () => assert.equal(await sum(), all - uavs));
  await page.keyboard.press("1");
  await page.locator("#filter").fill("uav:");
  await soon(async () => assert.equal(await sum(), uavs));
  const legend = await page.locator("#map-legend").innerText();
  for (const word of ["open", "reserved", "being sensed", "done", "charging point", "idle", "waiting", "failed", "trail", "on the way to"]) assert.ok(legend.includes(word), word);
});

test("runs of different policies share no axis of weights; completion is told in percent of all", async (t) => {
  const page = await open(t, "ab.html");
  await soon(async () => assert.equal(await page.locator("#plot-weight .plot-dot").count(), 2, "weight and bound of one run"));
  await soon(async () => assert.match(await page.locator("#chart-panel").innerText(), /mpq only/));
  await soon(async () => assert.equal(await page.locator("#plot-completion .plot-dot").count(), 2, "completion of both"));
  const heads = await page.locator("#comparison-body th").allInnerTexts();
  assert.ok(!heads.some((head) => /weight/.test(head)) && heads.includes("mean response") && heads.includes("waiting") && heads.includes("flown"), heads.join());
});

test("LIVE is not in the failures' colour", async (t) => {
  const page = await open(t, "a.html");
  const [live, failed] = await page.evaluate(() => {
    const badge = document.getElementById("live-state");
    badge.dataset.state = "live";
    const probe = document.createElement("i");
    probe.style.color = "var(--failed)";
    document.body.append(probe);
    return [getComputedStyle(badge).backgroundColor, getComputedStyle(probe).color];
  });
  assert.notEqual(live, failed);
});

test("the figures of the header are those of the chosen time", async (t) => {
  const page = await open(t, "faulty.html");
  await soon(async () => assert.equal(Number(await raw(page, "failed")), 0));
  await page.keyboard.press("End");
  await soon(async () => assert.equal(Number(await raw(page, "failed")), 1));
});

/** The run that a page holds. */
const embedded = (name) => JSON.parse(inflateSync(Buffer.from(readFileSync(file(name), "utf8").match(/x-muster-run">([^<]*)</)[1], "base64")));

test("the reason why a task is not done opens in place, in the policy's own terms", async (t) => {
  muster("simulate", join(MUSTER_SCENARIOS, "random_1.json"), "--policy", "horizon", "--log", "--out", file("h"));
  muster("report", file("h"), "--reasons", "1", "--out", file("h1.html"));
  muster("report", file("h"), "--reasons", "1000", "--out", file("h.html"));
  const undone = json("h/report.json").tasks.filter((task) => task.status !== "done").length;
  assert.deepEqual(["h1.html", "h.html"].map((name) => embedded(name).reasons.tasks.length), [1, undone]);
  const page = await open(t, "h.html", {}, "#t=7200");
  const row = page.locator(".a-risk").first();
  const id = (await row.locator("b").innerText()).replace("task ", "");
  const said = muster("explain", file("h"), "--task", id, "--decision", "12");
  await row.click();
  await soon(async () => assert.equal(await page.locator("#card-why h3").innerText(), "Why not, at decision 12"));
  const first = said.match(/^decision +12 +\S+ +(.*)$/m)[1].replace(/task:/g, "task ");
  await soon(async () => assert.equal(await page.locator("#card-why > p").first().innerText(), first));
  await soon(async () => assert.match(await page.locator("#card-why").innerText(), /All decisions/));
  await page.locator("#card-why summary").click();
  await soon(async () => assert.match(await page.locator("#card-why").innerText(), /in tasks/));
});

test("the map has north, a scale in its frame, the cursor's coordinates, and a drawing from a file below it", async (t) => {
  muster("simulate", join(MUSTER_SCENARIOS, "haiti.json"), "--policy", "mpq", "--limit", "60", "--log", "--out", file("haiti"));
  const coast = { type: "Feature", properties: { name: "coast" }, geometry: { type: "LineString", coordinates: [[-72.4, 18.5], [-72.3, 18.6], [-72.2, 18.5]] } };
  writeFileSync(file("coast.json"), JSON.stringify(coast));
  muster("report", file("haiti"), "--out", file("plain.html"));
  muster("report", file("haiti"), "--background", file("coast.json"), "--out", file("coast.html"));
  const maps = [];
  for (const name of ["plain.html", "coast.html"]) {
    const page = await open(t, name, {}, "#t=1800");
    maps.push(await picture(page, "map"));
    const box = await page.locator("#map").boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    assert.match(await page.locator("#map-cursor").innerText(), /^\d+\.\d, \d+\.\d km \(18\.\d{3}° N 72\.\d{3}° W\)$/);
  }
  assert.notEqual(maps[0], maps[1]);
  assert.throws(() => muster("report", file("a"), "--background", file("coast.json"), "--out", file("no.html")), /has no origin/);
});

test("printed, it is one page with the map, what needs attention and the tasks", async (t) => {
  const page = await open(t, "a.html");
  await page.emulateMedia({ media: "print" });
  for (const id of ["attention", "map", "detail-panel"]) assert.ok(await page.locator(`#${id}`).isVisible(), id);
  for (const id of ["gantt-panel", "chart-panel"]) assert.ok(!(await page.locator(`#${id}`).isVisible()), id);
  const pdf = (await page.pdf({ format: "A4", landscape: true, scale: 0.7 })).toString("latin1");
  assert.equal(pdf.match(/\/Type\s*\/Page\b/g).length, 1);
});

test("behind every chart is a table of its numbers", async (t) => {
  const page = await open(t, "ab.html", {}, "#t=4800&sel=uav:2");
  const report = json("a/report.json");
  const rows = (place) => page.locator(`${place} tbody tr`).evaluateAll((list) => list.map((row) => [...row.cells].map((cell) => cell.innerText)));
  const charts = page.locator("#charts details");
  assert.equal(await charts.count(), 4);
  for (let i = 0; i < 4; ++i) await charts.nth(i).locator("summary").click();
  await soon(async () => assert.equal(await page.locator("#charts table").count(), 4));
  const done = (await rows("#charts .chart:nth-child(1)")).at(-1);
  assert.equal(done[0], "3:00:00");
  assert.equal(done[1], (100 * report.completion_rate).toFixed(1));
  assert.equal(await page.locator("#charts .chart:nth-child(1) thead th").nth(1).innerText(), "a: % done");
  const weights = await rows("#charts .chart:nth-child(2)");
  assert.equal(weights.length, report.decisions.length);
  assert.equal(weights[3][1].replaceAll(",", ""), report.decisions[3].weight.toFixed(1));
  for (const i of [0, 1]) await page.locator("#gantt-tables summary").nth(i).click();
  await soon(async () => assert.equal(await page.locator("#gantt-tables table").count(), 2));
  const agents = await rows("#gantt-tables details:nth-child(2)");
  assert.equal(agents.length, 100);
  await page.locator("#filter").fill("uav:2");
  await soon(async () => assert.ok((await rows("#gantt-tables details:nth-child(2)")).every(([name]) => name.startsWith("uav:2"))));
  await page.locator("#card figure summary").click();
  await soon(async () => assert.equal((await rows("#card figure"))[0][1], "30.0"));
  await accessible(page, "with all tables open");
});

test("what another run decided otherwise is on the map, and names stand once", async (t) => {
  const page = await open(t, "ab.html", {}, "#t=4800");
  const before = await picture(page, "map");
  await page.locator("#differ").selectOption({ label: "b" });
  await soon(async () => assert.notEqual(await picture(page, "map"), before));
  await accessible(page, "with differences");
  await page.locator("#differences tbody button").first().click();
  await soon(async () => assert.ok(await page.locator("#card").isVisible()));
  await page.locator("#differ").selectOption({ label: "none" });
  await soon(async () => assert.ok(!(await page.locator("#differences").isVisible())));

  const faulty = await open(t, "faulty.html", {}, "#t=7000&sel=uav:3");
  const named = await namesOf(faulty);
  const names = async () => (await named()).map(({ text }) => text);
  await soon(async () => assert.ok((await names()).includes("uav:3")));
  assert.equal((await names()).filter((name) => name === "uav:3").length, 1);
});
