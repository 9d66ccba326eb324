// What a commander has to find out, by clicks and by reading alone, and in how many steps. Run by browser_tests.mjs.
import assert from "node:assert/strict";
import { before, test } from "node:test";
import { browser, file, json, muster, open, scrub, soon, startMission } from "./support.mjs";
import { TOKEN, livePage, liveRun, serve } from "./stub_server.mjs";

/** Counts what is clicked; opening the page and reading are no steps. */
function hand(page) {
  let steps = 0;
  return {
    click: async (locator, position) => { ++steps; await locator.click({ position }); },
    choose: async (locator, label) => { ++steps; await locator.selectOption({ label }); },
    fill: async (locator, text) => { ++steps; await locator.fill(text); },
    goTo: async (minutes) => { ++steps; await scrub(page, minutes); },
    steps: () => steps,
  };
}
const facts = async (page) => Object.fromEntries(await page.locator("#card-facts").evaluate((list) => [...list.querySelectorAll("dt")].map((name) => [name.innerText, name.nextElementSibling.innerText])));
const done = (t, steps, most) => {
  t.diagnostic(`${steps} steps`);
  assert.ok(steps <= most, `${steps} steps`);
};

before(() => {
  // More hands than tasks: somebody is free for one more.
  muster("scenario", "--preset", "Random_1", "--seed", "2", "--tasks", "30", "--online-min", "180:", "--out", file("few.json"));
});

test("which task is most at risk, and why: one step", async (t) => {
  const page = await open(t, "a.html");
  const you = hand(page);
  await you.click(page.locator("#attention-list .a-risk, #attention-list .a-undone").first());
  await soon(async () => assert.match(await page.locator("#card-title").innerText(), /^task \d+$/));
  await soon(async () => assert.match(await page.locator("#card-why").innerText(), /Why not[\s\S]*decision/i));
  done(t, you.steps(), 1);
});

test("where is uav:7 going and when is it there: three steps", async (t) => {
  const page = await open(t, "a.html", {}, "#t=0");
  const you = hand(page);
  await you.goTo(70.5);
  await you.fill(page.locator("#filter"), "uav:7");
  await you.click(page.locator("#gantt-scroll"), { x: 30, y: 22 + 9 }); // the name of the first row
  await soon(async () => assert.equal(await page.locator("#card-title").innerText(), "uav:7"));
  const told = await facts(page);
  assert.match(told.now, /task \d+|charging point \d+|km/);
  done(t, you.steps(), 3);
});

test("who waits longest: one step", async (t) => {
  const page = await open(t, "a.html", {}, "#t=0");
  const you = hand(page);
  // The moment before the longest wait of the mission ends.
  const longest = await page.evaluate(() => {
    const { run } = window.muster.state;
    const waits = run.agents.flatMap(({ label, spans }) => Array.from({ length: spans.length / 2 }, (_, i) => ({ label, from: spans[2 * i], status: spans[2 * i + 1], to: spans[2 * i + 2] ?? run.nowMs })))
      .filter(({ status }) => run.words.statuses[status] === "waiting");
    return waits.reduce((a, b) => (b.to - b.from > a.to - a.from ? b : a));
  });
  assert.ok(longest.to - longest.from > 300000, JSON.stringify(longest));
  await scrub(page, (longest.to - 1000) / 60000);
  await you.click(page.locator("#attention-list .a-wait").first());
  await soon(async () => assert.equal(await page.locator("#card-title").innerText(), longest.label));
  assert.match((await facts(page)).now, /waiting/);
  done(t, you.steps(), 1);
});

test("what changed between two runs at 1:20: two steps", async (t) => {
  const page = await open(t, "ab.html");
  const you = hand(page);
  await you.goTo(80);
  await you.choose(page.locator("#differ"), "b");
  const decisions = ["a", "b"].map((name) => json(`${name}/report.json`).decisions.find((d) => d.sim_s === 4800));
  const [here, there] = decisions.map((decision) => {
    const by = new Map();
    for (const a of decision.actions) {
      if (a.kind < 3) continue;
      for (const kind of ["uav", "worker", "vehicle"]) if (a[kind] >= 0) by.set(`${kind}:${a[kind]}`, [a.kind, a.uav, a.worker, a.vehicle, a.task, a.charge, a.x_m, a.y_m].map(Math.round).join());
    }
    return by;
  });
  const differ = [...new Set([...here.keys(), ...there.keys()])].filter((name) => here.get(name) !== there.get(name));
  assert.ok(differ.length > 0);
  await soon(async () => assert.match(await page.locator("#differences h3").innerText(), new RegExp(`^Decision 8, 1:20:00: ${differ.length} agents are commanded otherwise than in b$`)));
  const names = await page.locator("#differences tbody tr td:first-child").allInnerTexts();
  assert.deepEqual([...names].sort(), [...differ].sort());
  done(t, you.steps(), 2);
});

/** An emergency at a place of the map, with the hands of whoever commands: until its card says who goes. */
async function addEmergency(t, url, told) {
  const context = await browser().newContext({ viewport: { width: 1440, height: 900 }, reducedMotion: "reduce" });
  t.after(() => context.close());
  const page = await context.newPage();
  await page.goto(url);
  await page.waitForFunction(() => document.getElementById("control-state").textContent === "control");
  const you = hand(page);
  const dialog = (name) => page.locator("#order").getByRole("button", { name, exact: true });
  await you.click(page.locator("#order-add"));
  const { width, height } = await page.locator("#map").boundingBox();
  await you.click(page.locator("#map"), { x: Math.round(width / 2), y: Math.round(height / 2) });
  await you.choose(page.locator("#order select[name=priority]"), "emergency");
  await you.click(dialog("Next"));
  await you.click(dialog("Give the order"));
  await soon(async () => assert.match(await page.locator("#order-latest").innerText(), /taken/));
  await told?.();
  await you.click(page.locator("#order-latest button"));
  await soon(async () => assert.match(await page.locator("#card-title").innerText(), /^task \d+/));
  await page.waitForFunction(() => /(reserved for|sensed by|done at .* by) uav:\d+ and worker:\d+/.test(document.getElementById("card-facts").innerText), null, { timeout: 60_000 });
  assert.equal((await facts(page)).priority, "emergency");
  done(t, you.steps(), 6);
}

test("add an emergency at a place and see who goes: six steps", async (t) => {
  muster("simulate", file("few.json"), "--policy", "mpq", "--log", "--out", file("few"));
  muster("report", file("few"), "--reasons", "0", "--out", file("few.html"));
  const run = liveRun("few.html", 61);
  const id = run.scenario.task_times.length - 1;
  const { url, given, tell } = await serve(await livePage("few"), run, (order) => [200, { id: order.id, taken: { tick: 122, sim_s: 3660, task: id } }]);
  await addEmergency(t, `${url}#token=${TOKEN}`, () => {
    const { x_km: x, y_km: y, priority } = given[0].task;
    tell({ task_rows: [[id, 1000 * x, 1000 * y, 3000, 3660000, null, null, priority, ""]], tasks: [[id, 1, [3660000, 0, 4200000, 1]]], now_ms: 4230000,
      activities: [run.activities[1].length / 6, [0, 4, 7, id, 4800000, 4980000]] });
  });
});

test("the same with a mission that runs", { skip: muster("run", "--help").includes("--control") ? false : "muster run takes no orders yet" }, async (t) => {
  const { url } = await startMission(t, file("few.json"), "--rate", "120", "--out", file("ordered"));
  await addEmergency(t, url);
});

test("a mission whose tasks are reported and expire", async (t) => {
  muster("scenario", "--preset", "Random_1", "--seed", "4", "--arrivals", "steady:0.8", "--priorities", "0.3,0.4,0.2,0.1",
    "--due", "25", "--expires", "50", "--out", file("timed.json"));
  muster("simulate", file("timed.json"), "--policy", "mpq", "--log", "--out", file("timed"));
  muster("report", file("timed"), "--out", file("timed.html"));
  const tasks = json("timed.json").tasks;
  const page = await open(t, "timed.html", {}, "#t=3600");
  await soon(async () => assert.ok(await page.locator("#legend-expired").isVisible()));
  const known = tasks.filter((task) => (task.reported_min ?? 0) <= 60);
  const expired = known.filter((task) => task.expires_min <= 60);
  assert.ok(expired.length > 5 && known.length < tasks.length, `${expired.length} of ${known.length}`);
  // Those of higher priority come first.
  const first = await page.locator("#attention-list .a-undone").first().innerText();
  const id = Number(/task (\d+)/.exec(first)[1]);
  assert.match(first, /expired/);
  const most = Math.max(...json("timed/report.json").tasks.filter(({ id: x, status }) => status === "expired" && tasks[x].expires_min <= 60)
    .map(({ id: x }) => tasks[x].priority ?? 1));
  assert.equal(tasks[id].priority ?? 1, most);
  await page.locator("#attention-list .a-undone").first().click();
  await soon(async () => assert.equal(await page.locator("#card-title").innerText(), `task ${id}`));
  const told = await facts(page);
  assert.equal(told.priority, ["low", "normal", "high", "emergency"][most]);
  assert.match(told.expires, /must begin before \d:\d\d/);
  // Nobody knows of the others yet.
  const shown = await page.evaluate((at) => window.muster.state.run.tasks.filter((task) => task.reported > at).length, 3600_000);
  assert.equal(shown, tasks.length - known.length);
  await soon(async () => assert.ok((await page.locator("main").innerText()).includes(`${known.length} of ${tasks.length} tasks`)));
});
