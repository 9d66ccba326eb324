// Missions that are unlike those of the data sets, in Chromium: names of any kind and length, areas of a hundred metres, no
// task at all. Run by browser_tests.mjs.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { before, test } from "node:test";
import { accessible, drawn, file, json, muster, open, soon, text } from "./support.mjs";

const LONG = "Hospital Nord, évacuation des étages supérieurs, accès par la rue du Quai seulement, poids maximal douze tonnes, pont fermé";
const NAMES = [LONG, "مدرسة الشمال، الجناح الشرقي", "🚑 Brücke 7 👩‍🚒", "<img src=x onerror=alert(1)>", "</script><script>alert(2)</script>", "\"quotes\" & 'apostrophes' \\ ]", "X".repeat(120)];

function made(name, scenario) {
  writeFileSync(file(`${name}.json`), JSON.stringify(scenario));
  muster("simulate", file(`${name}.json`), "--policy", "horizon", "--log", "--out", file(name));
  muster("report", file(name), "--reasons", "0", "--out", file(`${name}.html`));
}

before(() => {
  muster("scenario", "--seed", "5", "--uavs", "4", "--workers", "6", "--vehicles", "3", "--tasks", "60", "--priorities", "1,6,2,1", "--due", "30", "--out", file("timed.json"));
  const timed = json("timed.json");
  timed.tasks.forEach((task, i) => { task.name = NAMES[i % NAMES.length]; });
  made("names", { ...timed, name: `</title><script>alert(3)</script> 🚁 مهمة ${"Long".repeat(40)}` });
  muster("scenario", "--area", "0.1x0.1", "--placement", "continuous", "--uavs", "2", "--workers", "2", "--vehicles", "1", "--tasks", "5", "--charging-points", "1", "--out", file("tiny.json"));
  made("tiny", json("tiny.json"));
  const one = json("tiny.json");
  made("none", { ...one, version: 2, tasks: [], room: { tasks: 3, uavs: 0, workers: 0, vehicles: 0 } });
});

const box = (page, id) => page.locator(id).boundingBox();

for (const [width, height] of [[1440, 900], [1024, 768], [390, 844]]) {
  test(`long names are cut or wrapped, and push nothing out of sight, at ${width} x ${height}`, async (t) => {
    const phone = width < 500;
    const page = await open(t, "names.html", { viewport: { width, height }, isMobile: phone, hasTouch: phone, reducedMotion: "reduce" }, "#t=4800&sel=task:0");
    await page.locator("#card").waitFor();
    await drawn(page);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), width);
    const [bar, card, title, facts] = await Promise.all(["footer", "#card", "#card-title", "#card-facts"].map((id) => box(page, id)));
    assert.ok(card.y >= 0 && card.y + card.height <= bar.y, `card from ${card.y} to ${card.y + card.height}, bar from ${bar.y}`);
    assert.ok(title.y + title.height <= facts.y + 1, `title to ${title.y + title.height}, facts from ${facts.y}`);
    assert.ok(await page.evaluate(() => {
      const { scrollWidth, clientWidth } = document.getElementById("card");
      return scrollWidth <= clientWidth;
    }), "the card scrolls sideways");
    if (!phone) {
      const legend = await box(page, "#map-legend");
      assert.ok(legend.y + legend.height <= bar.y, `legend to ${legend.y + legend.height}, bar from ${bar.y}`);
    }
    const figures = await page.locator("#figures .tile").evaluateAll((tiles) => tiles.map((tile) => tile.offsetTop));
    assert.equal(new Set(figures).size, 1, "figures stand in one line");
    await accessible(page, "with long names");
  });
}

test("a task's name is in the table, in what needs attention and found, whatever it is made of", async (t) => {
  const page = await open(t, "names.html", {}, "#t=4800");
  const names = page.locator("#task-table .task-name bdi");
  await soon(async () => assert.ok((await names.allInnerTexts()).includes(NAMES[3])));
  assert.equal(await page.locator("img").count(), 0);
  const heads = await page.locator("#task-table th:not([hidden])").allInnerTexts();
  assert.deepEqual(heads, ["task", "priority", "due", "now", "who", "until, since", "in the end"]);
  await page.locator("#task-find").fill("brücke");
  await soon(async () => assert.ok((await names.allInnerTexts()).every((name) => name === NAMES[2]) && await names.count() > 0));
  await page.locator("#task-find").fill("");
  await page.locator("#task-table th button", { hasText: "priority" }).click();
  await soon(async () => assert.equal(await page.locator("#task-table tbody tr:first-child td:nth-child(2)").innerText(), "emergency"));
  // A row that has the focus keeps it, though its name has quotes.
  const row = page.locator("#attention-list .alarm").first();
  await row.evaluate((node, name) => {
    node.dataset.attention = `undone task 5: ${name}`;
    node.focus();
  }, NAMES[5]);
  await page.evaluate(() => window.muster.clock.seek(6000000));
  await drawn(page);
  const plain = await open(t, "a.html", {}, "#t=4800");
  assert.deepEqual(await plain.locator("#task-table th:not([hidden])").allInnerTexts(), ["task", "now", "who", "until, since", "in the end", "takes"]);
});

/** What is written on the map. */
const written = (page) => page.evaluate(() => new Promise((resolve) => {
  let texts = [];
  const { fillText: write, clearRect: clear } = CanvasRenderingContext2D.prototype;
  CanvasRenderingContext2D.prototype.clearRect = function (...area) {
    if (this.canvas.id === "map") texts = [];
    return clear.call(this, ...area);
  };
  CanvasRenderingContext2D.prototype.fillText = function (...line) {
    if (this.canvas.id === "map") texts.push(line[0]);
    return write.call(this, ...line);
  };
  window.muster.clock.seek(window.muster.clock.t);
  requestAnimationFrame(() => requestAnimationFrame(() => resolve(texts)));
}));

test("an area of a hundred metres has numbers, a scale that fits and places to the metre", async (t) => {
  const page = await open(t, "tiny.html", {}, "#t=1800");
  const texts = await written(page);
  for (const number of ["0", "0.06", "0.1"]) assert.ok(texts.filter((line) => line === number).length >= 2, `${number}: ${texts}`);
  assert.ok(texts.includes("20 m"), texts.join());
  const map = await box(page, "#map");
  const [x, y] = await page.evaluate(() => [window.muster.parts.map.shown.x(50), window.muster.parts.map.shown.y(50)]);
  await page.mouse.move(map.x + x, map.y + y);
  assert.match(await page.locator("#map-cursor").innerText(), /^0\.0[45]\d, 0\.0[45]\d km$/);
});

test("a mission without any task says so", async (t) => {
  const page = await open(t, "none.html");
  await soon(async () => assert.equal(await page.locator("#moment").innerText(), "Opened at 0:00:00, the mission has no task."));
  assert.equal(await text(page, "completion_rate"), "–");
  assert.equal(await text(page, "tasks_done"), "0 of 0");
  await accessible(page, "without tasks");
});
