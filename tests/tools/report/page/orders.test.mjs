// Orders from a live page, in Chromium, to a server that stands in for a mission. Run by browser_tests.mjs.
import assert from "node:assert/strict";
import { join } from "node:path";
import { before, test } from "node:test";
import { LOOKS, MUSTER_SCENARIOS, accessible, browser, drawn, file, muster, picture, soon } from "./support.mjs";
import { TOKEN, livePage, liveRun, serve } from "./stub_server.mjs";

const MINUTES = 61;
let html;

before(async () => {
  muster("simulate", join(MUSTER_SCENARIOS, "random_1.json"), "--policy", "mpq", "--log", "--out", file("o"));
  muster("report", file("o"), "--reasons", "0", "--out", file("o.html"));
  html = await livePage("o");
});

/** A live page; whatever goes wrong in it fails the test at the end, but for what `expected` matches. */
async function openLive(t, url, options = {}, expected = null) {
  const context = await browser().newContext({ viewport: { width: 1440, height: 900 }, colorScheme: "light", reducedMotion: "reduce", ...options });
  const page = await context.newPage();
  const wrong = [];
  page.on("console", (message) => wrong.push(`${message.type()}: ${message.text()}`));
  page.on("pageerror", (error) => wrong.push(String(error)));
  page.on("dialog", (dialog) => wrong.push(`dialog ${dialog.message()}`));
  t.after(async () => {
    await context.close();
    assert.deepEqual(wrong.filter((line) => !expected?.test(line)), []);
  });
  await page.goto(url);
  await page.waitForFunction(() => document.getElementById("live-state").textContent === "live");
  await page.waitForFunction(() => window.muster.clock.follow && window.muster.clock.t > 0);
  return page;
}

const taken = (order, more = {}) => [200, { id: order.id, taken: { tick: 122, sim_s: 3660, ...more } }];
const openTask = (run) => {
  const busy = new Set(run.tasks.filter(([, , rows]) => rows.some((v, i) => i % 2 === 0 && v <= run.now_ms)).map(([id]) => id));
  return run.scenario.task_times.findIndex((_, id) => !busy.has(id));
};
const select = (page, name) => page.evaluate((sel) => {
  const [type, id] = sel.split(":");
  const { state } = window.muster;
  state.flyTo(type === "task" ? { type, id: Number(id) } : { type: "agent", index: state.run.agents.findIndex((a) => a.label === sel) });
}, name);
const press = (page, name) => page.locator("#order").getByRole("button", { name, exact: true }).click();

for (const [width, height, colorScheme] of LOOKS) {
  test(`a task is added by a click on the map, asked back, at ${width} x ${height}, ${colorScheme}`, async (t) => {
    const run = liveRun("o.html", MINUTES);
    const id = run.scenario.task_times.length - 2;
    const { url, given, tell } = await serve(html, run, (order) => taken(order, { task: id }));
    const phone = width < 500;
    const page = await openLive(t, `${url}#token=${TOKEN}`, { viewport: { width, height }, colorScheme, isMobile: phone, hasTouch: phone });
    assert.ok(!(await page.evaluate(() => location.hash)).includes(TOKEN), "the address may be passed on");
    assert.equal(await page.locator("#control-state").innerText(), "CONTROL");
    await accessible(page, "with control");
    if (phone) await page.locator("[data-fold=tools]").tap();
    await drawn(page);
    const map = await page.locator("#map").boundingBox();
    await page.locator("#order-add").click();
    await soon(async () => assert.ok(await page.locator("#pick-hint").isVisible()));
    await drawn(page);
    assert.deepEqual(await page.locator("#map").boundingBox(), map, "the map stays where it is");
    const [x, y] = await page.evaluate(() => {
      const { shown } = window.muster.parts.map;
      return [shown.x(7000), shown.y(3000)];
    });
    await page.locator("#map").click({ position: { x, y } });
    await page.locator("#order").waitFor();
    const place = await page.evaluate(() => ["x", "y"].map((name) => Number(document.querySelector(`#order input[name=${name}]`).value)));
    assert.ok(Math.abs(place[0] - 7) < 0.2 && Math.abs(place[1] - 3) < 0.2, place.join());
    await page.locator("#order select[name=priority]").selectOption("emergency");
    await page.locator("#order input[name=due]").fill("20");
    await page.locator("#order input[name=name]").fill("school");
    await page.locator("#order input[name=note]").fill("third floor");
    await accessible(page, "a new task");
    await press(page, "Next");
    await soon(async () => assert.match(await page.locator("#order .asked").innerText(), /^Add a task at 7\.\d, [23]\.\d km: 3\.0 km of range, priority emergency, due 1:21:00, name school, note third floor\.$/));
    assert.equal(given.length, 0, "nothing is sent before it was asked back");
    await accessible(page, "asked back");
    await press(page, "Give the order");
    await soon(async () => assert.match(await page.locator("#order-latest").innerText(), /taken, at 1:01:00$/));
    assert.equal(given.length, 1);
    const [{ id: orderId, ...order }] = given;
    assert.match(orderId, /^page-/);
    assert.deepEqual(order, { order: "task_add", task: { x_km: place[0], y_km: place[1], cost_km: 3, priority: 3, due_min: 81, name: "school", note: "third floor" } });
    // The mission has it: it is on the map, in the table, and among what needs attention.
    const count = () => page.evaluate(() => window.muster.state.run.tasksTotal);
    const before = await count();
    tell({ task_rows: [[id, place[0] * 1000, place[1] * 1000, 3000, 3660000, 4860000, null, 3, "school", "third floor"]], tasks: [[id, 1, [3660000, 0]]], now_ms: 3690000 });
    await page.waitForFunction((n) => window.muster.state.run.tasksTotal === n, before + 1);
    await soon(async () => assert.match(await page.locator("#attention-list .a-risk").first().innerText(), new RegExp(`task ${id}, emergency`)));
    if (phone) await page.locator("#sheet-handle").tap();
    await page.locator("#attention-list .a-risk").first().click();
    await soon(async () => assert.equal(await page.locator("#card-title").innerText(), `task ${id} school`));
    await soon(async () => assert.match(await page.locator("#card-facts").innerText(), /third floor/));
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width);
    await accessible(page, "with the new task");
  });
}

test("the mission decides at once when it is asked to, by keyboard too", async (t) => {
  const { url, given } = await serve(html, liveRun("o.html", MINUTES), (order) => taken(order));
  const watching = await openLive(t, url);
  assert.ok(!(await watching.locator("#order-decide").isVisible()), "who may not order is not offered it");
  const page = await openLive(t, `${url}#token=${TOKEN}`);
  await page.getByRole("button", { name: "Decide now" }).click();
  await soon(async () => assert.equal(await page.locator("#order .asked").innerText(), "Decide now: all who are free are sent anew, and who is under way goes on."));
  await accessible(page, "asked back");
  await press(page, "Cancel");
  assert.equal(given.length, 0, "who thinks better of it orders nothing");
  await page.locator("#order-decide").focus();
  await page.keyboard.press("Enter");
  await page.locator("#order").getByRole("button", { name: "Give the order", exact: true }).focus();
  await page.keyboard.press("Enter");
  await soon(async () => assert.match(await page.locator("#order-latest").innerText(), /Order: decide now: taken, at 1:01:00$/));
  const [{ id, ...order }] = given;
  assert.match(id, /^page-/);
  assert.deepEqual([order, given.length], [{ order: "decide_now" }, 1]);
});

test("a task is changed, held, resumed and cancelled; what is refused says why", async (t) => {
  const run = liveRun("o.html", MINUTES);
  const task = openTask(run);
  const answers = [taken, taken, taken, (order) => [409, { id: order.id, refused: "task 1 is done" }], taken];
  const { url, given, tell } = await serve(html, run, (order) => answers.shift()(order));
  const page = await openLive(t, `${url}#token=${TOKEN}`, {}, /status of 409/);
  const choices = () => page.locator("#card-orders button").allInnerTexts();
  const latest = (wanted) => soon(async () => assert.match(await page.locator("#order-latest").innerText(), wanted));
  await select(page, `task:${task}`);
  await soon(async () => assert.deepEqual(await choices(), ["Change …", "Hold", "Cancel task", "Pin or forbid …"]));

  await page.getByRole("button", { name: "Change …" }).click();
  await press(page, "Next");
  await soon(async () => assert.match(await page.locator("#order .wrong").innerText(), /Nothing is other/));
  await page.locator("#order select[name=priority]").selectOption("high");
  await press(page, "Next");
  await press(page, "Back");
  assert.equal(await page.locator("#order select[name=priority]").inputValue(), "2", "what was written stays");
  await press(page, "Next");
  await press(page, "Give the order");
  await latest(new RegExp(`change task ${task}: priority high: taken`));
  tell({ task_rows: [[task, 5000, 5000, 3000, 0, null, null, 2, ""]] });
  await soon(async () => assert.match(await page.locator("#card-facts").innerText(), /high/));

  await page.getByRole("button", { name: "Hold" }).click();
  await press(page, "Give the order");
  await latest(/hold task \d+: taken/);
  tell({ tasks: [[task, 0, [3660000, 7]]], now_ms: 3690000 });
  await soon(async () => assert.deepEqual(await choices(), ["Change …", "Resume", "Cancel task"]));
  await soon(async () => assert.match(await page.locator("#card-facts").innerText(), /held/));
  await soon(async () => assert.ok(await page.locator("#legend-held").isVisible()));
  await accessible(page, "a held task");

  await page.getByRole("button", { name: "Resume" }).click();
  await press(page, "Give the order");
  await latest(/resume task \d+: taken/);
  tell({ tasks: [[task, 1, [3690000, 0]]] });
  await soon(async () => assert.deepEqual(await choices(), ["Change …", "Hold", "Cancel task", "Pin or forbid …"]));

  await page.getByRole("button", { name: "Cancel task" }).click();
  await soon(async () => assert.match(await page.locator("#order .asked").innerText(), /nobody will do it/));
  await press(page, "Cancel");
  assert.equal(given.length, 3, "who thinks better of it orders nothing");
  for (const wanted of [/cancel task \d+: refused, task 1 is done/, /cancel task \d+: taken/]) {
    await page.getByRole("button", { name: "Cancel task" }).click();
    await press(page, "Give the order");
    await latest(wanted);
  }
  tell({ tasks: [[task, 2, [3720000, 6]]], now_ms: 3720000 });
  await soon(async () => assert.deepEqual(await choices(), []));
  await page.locator("#tab-orders").click();
  const list = await page.locator("#order-list li").allInnerTexts();
  assert.equal(list.length, 5);
  assert.match(list[0], /cancel task \d+: taken/);
  assert.match(list[1], /cancel task \d+: refused, task 1 is done/);
  await accessible(page, "the list of orders");
  assert.deepEqual(given.map(({ order, task: which, priority }) => [order, which, priority]), [["task_change", task, 2], ["task_hold", task, undefined],
    ["task_resume", task, undefined], ["task_cancel", task, undefined], ["task_cancel", task, undefined]]);
  assert.equal(new Set(given.map(({ id }) => id)).size, 5);
});

test("an agent is recalled and leaves; an order that is not answered is asked for again", async (t) => {
  const run = liveRun("o.html", MINUTES);
  let asked = 0;
  const { url, given } = await serve(html, run, (order) => {
    if (order.asked) return ++asked < 2 ? [202, { id: order.asked, pending: true }] : taken({ id: order.asked }, { agent: "uav:2" });
    return order.order === "agent_recall" ? [202, { id: order.id, pending: true }] : taken(order, { agent: "uav:2" });
  });
  const page = await openLive(t, `${url}#token=${TOKEN}`);
  // A UAV that is under way.
  const agent = await page.evaluate(() => window.muster.state.run.agents.find(({ kind, spans }) => kind === 0 && spans.at(-1) === 2).label);
  await select(page, agent);
  await page.getByRole("button", { name: "Recall" }).click();
  await press(page, "Give the order");
  await soon(async () => assert.match(await page.locator("#order-latest").innerText(), new RegExp(`recall ${agent}: taken`)));
  assert.deepEqual([asked, given[1].asked], [2, given[0].id]);
  await page.getByRole("button", { name: "Let it leave" }).click();
  await soon(async () => assert.match(await page.locator("#order .asked").innerText(), /goes when what it is at is done/));
  await press(page, "Give the order");
  await soon(async () => assert.match(await page.locator("#order-latest").innerText(), new RegExp(`let ${agent} leave: taken`)));
  const { id, ...order } = given.at(-1);
  assert.deepEqual(order, { order: "agent_leave", agent });
});

test("several are selected by Shift, and each is given the order that is asked back once", async (t) => {
  const run = liveRun("o.html", MINUTES);
  const { url, given } = await serve(html, run, (order) => taken(order));
  const page = await openLive(t, `${url}#token=${TOKEN}`);
  const labels = await page.evaluate(() => window.muster.state.run.agents.filter(({ kind, spans }) => kind === 0 && spans.at(-1) === 2).map(({ label }) => label).slice(0, 3));
  assert.equal(labels.length, 3, "UAVs that are under way");
  for (const label of labels) {
    await page.keyboard.press("/");
    await page.keyboard.type(label);
    await page.keyboard.press("Shift+Enter");
  }
  await soon(async () => assert.equal(await page.locator("#card-title").innerText(), labels[2]));
  assert.equal(await page.locator("#card-others li").count(), 2);
  await page.waitForFunction((sel) => location.hash.includes(sel), `sel=${[...labels].reverse().join()}`);
  // A click with Shift on the map selects one of them no longer.
  await page.keyboard.press("f");
  await page.waitForFunction((label) => window.muster.parts.map.near.some(({ agent }) => agent.label === label), labels[0]);
  const at = await page.evaluate((label) => {
    const { px, py } = window.muster.parts.map.near.find(({ agent }) => agent.label === label);
    return { x: px, y: py };
  }, labels[0]);
  await page.locator("#map").click({ position: at, modifiers: ["Shift"] });
  await soon(async () => assert.equal(await page.locator("#card-others li").count(), 1));
  await accessible(page, "two are selected");
  await page.locator("#card-all").getByRole("button", { name: "Recall: 2" }).click();
  await soon(async () => assert.equal(await page.locator("#order-title").innerText(), "Give these 2 orders?"));
  assert.match(await page.locator("#order .asked").innerText(), new RegExp(`recall ${labels[2]}: .*\n.*recall ${labels[1]}: `));
  await accessible(page, "two orders are asked back");
  await press(page, "Give the orders");
  await soon(async () => assert.equal(given.length, 2));
  assert.deepEqual(given.map(({ order, agent }) => [order, agent]), [["agent_recall", labels[2]], ["agent_recall", labels[1]]]);
  assert.notEqual(given[0].id, given[1].id);
  await page.locator("#card-others").getByRole("button", { name: `${labels[1]}:` }).click();
  await soon(async () => assert.equal(await page.locator("#card-title").innerText(), labels[1]));
  await page.keyboard.press("Escape");
  await soon(async () => assert.ok(!(await page.locator("#card").isVisible())));
});

test("who does a task is decided on its card, who charges and who goes where on an agent's", async (t) => {
  const run = liveRun("o.html", MINUTES);
  const { url, given, tell } = await serve(html, run, (order) => taken(order));
  const page = await openLive(t, `${url}#token=${TOKEN}`);
  const task = openTask(run);
  const here = await page.evaluate(() => [0, 1].map((kind) => window.muster.state.run.agents.find((agent) => agent.kind === kind && ![0, 6].includes(agent.spans.at(-1))).label));
  await select(page, `task:${task}`);
  await soon(async () => assert.match(await page.locator("#card-why").innerText(), /lost: uav:1 and worker:2 could sense it/));
  await page.getByRole("button", { name: "Pin or forbid …" }).click();
  await press(page, "Next");
  await soon(async () => assert.match(await page.locator("#order .wrong").innerText(), /A UAV, a worker or both/));
  await page.locator("#order select[name=uav]").selectOption(here[0]);
  await page.locator("#order select[name=worker]").selectOption(here[1]);
  await accessible(page, "a pin");
  await press(page, "Next");
  await soon(async () => assert.match(await page.locator("#order .asked").innerText(), new RegExp(`Let ${here[0]} and ${here[1]} do task ${task}: nobody else`)));
  await soon(async () => assert.match(await page.locator("#order .effect").innerText(), /0\.420 less than without/));
  await press(page, "Give the order");
  await soon(async () => assert.match(await page.locator("#order-latest").innerText(), /taken/));
  const ids = here.map((label) => Number(label.split(":")[1]));
  tell({ directives: [[3660000, null, "p1", "chief", "pin", `pin: ${here[0]} and ${here[1]} to task ${task}`, ...ids, -1, task]], now_ms: 3690000 });
  await soon(async () => assert.match(await page.locator("#card-facts").innerText(), new RegExp(`directed\\s+pin: ${here[0]} and ${here[1]} to task ${task}, by chief`)));
  await page.getByRole("button", { name: "Release: pin" }).click();
  await press(page, "Give the order");
  await soon(async () => assert.equal(given.length, 2));

  await select(page, here[0]);
  await page.getByRole("button", { name: "Charge now" }).click();
  await press(page, "Give the order");
  await page.getByRole("button", { name: "Go to …" }).click();
  await soon(async () => assert.match(await page.locator("#pick-hint").innerText(), /where it is to go/));
  await drawn(page);
  const [x0, x1, y0, y1] = await page.evaluate(() => {
    const { x, y } = window.muster.parts.map.shown;
    return [x(0), x(1000), y(0), y(1000)];
  });
  await page.locator("#map").click({ position: { x: 400, y: 200 } });
  await press(page, "Give the order");
  await soon(async () => assert.equal(given.length, 4));
  const [pin, release, charge, go] = given.map(({ id, ...order }) => order);
  assert.deepEqual(pin, { order: "pin", task, agents: here });
  assert.deepEqual(release, { order: "release", directive: "p1" });
  assert.deepEqual(charge, { order: "charge_now", agents: [here[0]] });
  assert.deepEqual([go.order, go.agent], ["go_to", here[0]]);
  assert.ok(Math.abs(go.x_km - (400 - x0) / (x1 - x0)) < 0.2 && Math.abs(go.y_km - (200 - y0) / (y1 - y0)) < 0.2, JSON.stringify(go));
});

test("agents are dragged to tasks, charging points and places; after Escape, and without control, nobody is", async (t) => {
  const run = liveRun("o.html", MINUTES);
  const { url, given } = await serve(html, run, (order) => taken(order));
  const page = await openLive(t, `${url}#token=${TOKEN}`);
  const task = openTask(run);
  await drawn(page);
  const [uav, at, to, charge, free] = await page.evaluate((id) => {
    const { state, parts: { map } } = window.muster;
    const { near, shown, sites } = map;
    // A UAV that no other agent is near to, and a place with nothing near.
    const alone = (px, py, most) => [...near, ...sites].filter((one) => Math.hypot(one.px - px, one.py - py) < 14).length <= most;
    const one = near.find(({ agent, status, px, py }) => agent.kind === 0 && ![0, 6].includes(status)
      && near.filter((other) => Math.hypot(other.px - px, other.py - py) < 14).length === 1);
    const site = sites.find((other) => other.task.id === id);
    const points = state.run.charging.map((point) => [shown.x(point.x), shown.y(point.y), point.id]).filter(([px, py]) => alone(px, py, 0));
    let place = [map.free.left + 60, map.free.top + 60];
    while (!alone(...place, 0) || points.some(([px, py]) => Math.hypot(px - place[0], py - place[1]) < 20)) place = [place[0] + 7, place[1] + 3];
    return [one.agent.label, [one.px, one.py], [site.px, site.py], points[0], place];
  }, task);
  const box = await page.locator("#map").boundingBox();
  const view = () => page.evaluate(() => JSON.stringify(window.muster.parts.map.view));
  const before = await view();
  const drag = async (from, goal, key = null, on = page) => {
    await on.mouse.move(box.x + from[0], box.y + from[1]);
    await on.mouse.down();
    await on.mouse.move(box.x + (from[0] + goal[0]) / 2, box.y + (from[1] + goal[1]) / 2);
    await on.mouse.move(box.x + goal[0], box.y + goal[1]);
    if (key) await on.keyboard.press(key);
    const words = await on.locator("#map-tip").innerText().catch(() => "");
    await on.mouse.up();
    return words;
  };
  assert.match(await drag(at, to), new RegExp(`^${uav} to task ${task}`));
  await page.locator("#order").waitFor();
  assert.equal(await page.locator("#order select[name=uav]").inputValue(), uav, "the form knows who was dragged");
  await press(page, "Next");
  await press(page, "Give the order");
  await soon(async () => assert.equal(given.length, 1));
  assert.match(await drag(at, charge), new RegExp(`^${uav} to charging point ${charge[2]}`));
  await soon(async () => assert.match(await page.locator("#order .asked").innerText(), new RegExp(`^Charge ${uav} now at charging point ${charge[2]}`)));
  await press(page, "Give the order");
  await soon(async () => assert.equal(given.length, 2));
  assert.equal(await drag(at, free), `${uav} goes here`);
  await press(page, "Give the order");
  await soon(async () => assert.equal(given.length, 3));
  const [pin, now, go] = given.map(({ id, ...order }) => order);
  assert.deepEqual(pin, { order: "pin", task, agents: [uav] });
  assert.deepEqual(now, { order: "charge_now", agents: [uav], charge: charge[2] });
  assert.deepEqual([go.order, go.agent], ["go_to", uav]);

  await drag(at, to, "Escape");
  assert.ok(!(await page.locator("#order").isVisible()), "Escape drags nobody");
  assert.equal(await view(), before, "the map stays where it is");
  await drag(free, [free[0] + 60, free[1]]);
  assert.notEqual(await view(), before, "the map itself is still moved");
  const watching = await openLive(t, url);
  await drawn(watching);
  await drag(at, to, null, watching);
  assert.ok(!(await watching.locator("#order").isVisible()), "without control nobody is dragged");
});

test("without a token a page is read-only, with a wrong one it becomes so, and without a connection nothing is lost", async (t) => {
  const run = liveRun("o.html", MINUTES);
  const { url, given } = await serve(html, run, taken);
  const task = openTask(run);
  const only = await openLive(t, url);
  assert.equal(await only.locator("#control-state").innerText(), "READ-ONLY");
  await select(only, `task:${task}`);
  for (const id of ["order-add", "card-orders", "tab-orders"]) assert.ok(!(await only.locator(`#${id}`).isVisible()), id);
  await only.keyboard.press("a");
  assert.ok(!(await only.locator("#pick-hint").isVisible()));

  const wrong = await openLive(t, `${url}#token=wrong`, {}, /status of 403/);
  await select(wrong, `task:${task}`);
  await wrong.getByRole("button", { name: "Hold" }).click();
  await press(wrong, "Give the order");
  await soon(async () => assert.match(await wrong.locator("#order-latest").innerText(), /refused, this page may not give orders/));
  await soon(async () => assert.equal(await wrong.locator("#control-state").innerText(), "READ-ONLY"));
  assert.equal(given.length, 0);

  const right = await openLive(t, `${url}#token=${TOKEN}`, {}, /ERR_FAILED/);
  await right.route("**/orders", (route) => route.abort());
  await select(right, `task:${task}`);
  await right.getByRole("button", { name: "Hold" }).click();
  await press(right, "Give the order");
  await soon(async () => assert.match(await right.locator("#order-latest").innerText(), /no answer, no connection/));
  await right.unroute("**/orders");
  await right.locator("#order-latest").getByRole("button", { name: "Send again" }).click();
  await soon(async () => assert.match(await right.locator("#order-latest").innerText(), /taken/));
  assert.equal(given.length, 1);
  await right.reload();
  await right.waitForFunction(() => document.getElementById("control-state").textContent === "control");
});

test("an order that waits for its tick is undone, at the second try after the connection has failed", async (t) => {
  const run = liveRun("o.html", MINUTES);
  let withdrawal = null;
  const { url, given } = await serve(html, run, (order) => {
    if (order.order === "withdraw") withdrawal = order;
    if (order.order === "withdraw") return taken(order);
    const id = order.asked ?? order.id;
    return withdrawal ? [409, { id, refused: `withdrawn by order ${withdrawal.id}` }] : [202, { id, pending: true }];
  });
  const page = await openLive(t, `${url}#token=${TOKEN}`, {}, /ERR_FAILED|status of 409/);
  await select(page, `task:${openTask(run)}`);
  await page.getByRole("button", { name: "Hold" }).click();
  await press(page, "Give the order");
  const undo = page.locator("#order-latest").getByRole("button", { name: "Undo" });
  await undo.waitFor();
  await accessible(page, "an order that can be undone");
  await page.route("**/orders", (route) => route.abort());
  await undo.click();
  await soon(async () => assert.ok(await undo.isEnabled()));
  await page.unroute("**/orders");
  await undo.click();
  await soon(async () => assert.match(await page.locator("#order-latest").innerText(), /: withdrawn$/));
  assert.equal(withdrawal.withdraws, given[0].id);
});

test("a place is typed in; outside the area it is refused before it is asked back", async (t) => {
  const { url, given } = await serve(html, liveRun("o.html", MINUTES), taken);
  const page = await openLive(t, `${url}#token=${TOKEN}`);
  await page.keyboard.press("a");
  await page.keyboard.press("Escape");
  await soon(async () => assert.ok(!(await page.locator("#pick-hint").isVisible())));
  await page.keyboard.press("a");
  await page.locator("#pick-enter").click();
  await page.locator("#order input[name=x]").fill("-1");
  await press(page, "Next");
  await soon(async () => assert.match(await page.locator("#order .wrong").innerText(), /outside the area/));
  await page.locator("#order input[name=x]").fill("2.5");
  await page.locator("#order input[name=cost]").fill("0");
  await press(page, "Next");
  await soon(async () => assert.match(await page.locator("#order .wrong").innerText(), /more than 0 km/));
  await page.locator("#order input[name=cost]").fill("1");
  await page.locator("#order input[name=cost]").press("Enter");
  await soon(async () => assert.match(await page.locator("#order .asked").innerText(), /^Add a task at 2\.5/));
  await page.keyboard.press("Escape");
  assert.equal(given.length, 0);
});

test("vacant tasks are nowhere, and a UAV that joins appears", async (t) => {
  const run = liveRun("o.html", MINUTES);
  const { scenario } = run;
  const last = scenario.uavs - 1;
  scenario.vacant = [1, 0, 0];
  for (const key of ["stops", "spans"]) run[key] = run[key].filter(([index]) => index !== last);
  const { url, tell } = await serve(html, run, taken);
  const page = await openLive(t, `${url}#token=${TOKEN}`);
  await soon(async () => assert.match(await page.locator("#gantt-count").innerText(), /^99 of 99 /));
  assert.equal(await page.locator('[data-key="agents"]').innerText(), "29 + 50 + 20");
  await soon(async () => assert.match(await page.locator("#task-count").innerText(), /of 120 tasks/));
  const before = await picture(page, "map");
  tell({ agent_rows: [[last, 30000]], stops: [[last, 0, [3660000, 5000, 5000, 30000]]], spans: [[last, 0, [3660000, 1]]],
    events: [0, [["agent_joined", 3660000, last, -1, -1, -1, -1, "", "k3-17 by page"]]], now_ms: 3690000 });
  await soon(async () => assert.match(await page.locator("#gantt-count").innerText(), /^100 of 100 /));
  await soon(async () => assert.equal(await page.locator('[data-key="agents"]').innerText(), "30 + 50 + 20"));
  assert.notEqual(await picture(page, "map"), before);
  await page.keyboard.press("e");
  await soon(async () => assert.match(await page.locator("#panel-body").innerText(), /agent joined\tuav:29\tk3-17 by page/));
});

test("alerts are acknowledged until they are over", async (t) => {
  const run = liveRun("o.html", MINUTES);
  const task = openTask(run);
  run.scenario.task_times[task] = [0, 3700000, null, 3, ""];
  const { url, tell } = await serve(html, run, taken);
  const page = await openLive(t, url);
  const alert = page.locator("#attention-list .a-risk", { hasText: `task ${task},` });
  await soon(async () => assert.equal(await alert.count(), 1));
  await page.getByRole("button", { name: `Acknowledge task ${task}` }).click();
  await soon(async () => assert.equal(await alert.count(), 0));
  await soon(async () => assert.match(await page.locator("#attention-count").innerText(), /1 acknowledged$/));
  await accessible(page, "with an acknowledged alert");
  await page.locator("#attention-again").click();
  await soon(async () => assert.equal(await alert.count(), 1));
  await page.getByRole("button", { name: `Acknowledge task ${task}` }).click();
  await soon(async () => assert.equal(await alert.count(), 0));
  tell({ tasks: [[task, 0, [3690000, 6]]], now_ms: 3690000 });
  await soon(async () => assert.doesNotMatch(await page.locator("#attention-count").innerText(), /acknowledged/));
  tell({ tasks: [[task, 1, [3720000, 0]]], now_ms: 3720000 });
  await soon(async () => assert.equal(await alert.count(), 1, "it is an alert again"));
});
