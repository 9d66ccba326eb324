// node pictures.mjs MUSTER WORK IMAGES [NAME]: takes the pictures of docs/guide/report.md, or that one. WORK holds playwright-core.
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const [program, work, images] = process.argv.slice(2, 5).map((path) => resolve(path));
const only = process.argv[5];
const { chromium } = createRequire(join(work, "package.json"))("playwright-core");
const folder = mkdtempSync(join(tmpdir(), "muster-pictures-"));
const at = (name) => join(folder, name);
const muster = (...args) => execFileSync(program, args, { stdio: ["ignore", "ignore", "inherit"] });

async function take(browser, name, page, { width, height, scheme = "light", hash = "" }, then = async () => {}) {
  if (only && name !== only) return;
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: scheme, deviceScaleFactor: width < 500 ? 2 : 1 });
  const tab = await context.newPage();
  await tab.goto(`file://${at(page)}${hash}`);
  await tab.locator("html[data-ready]").waitFor({ state: "attached" });
  await then(tab);
  await tab.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const session = await context.newCDPSession(tab);
  const { data } = await session.send("Page.captureScreenshot", { format: "webp", quality: 80 });
  writeFileSync(join(images, name), Buffer.from(data, "base64"));
  await context.close();
}

try {
  muster("scenario", "--preset", "Random_29", "--seed", "1", "--out", at("r29.json"));
  muster("simulate", at("r29.json"), "--policy", "horizon", "--log", "--out", at("a"), "--fault", "loss:*@60+20=0.2",
    "--fault", "process_killed:uav@90", "--fault", "agent_silent:uav:7@100+30");
  muster("report", at("a"), "--out", at("a.html"));
  muster("scenario", "--preset", "Random_1", "--seed", "1", "--out", at("r1.json"));
  for (const policy of ["rollout-steps", "certified", "mpq"]) muster("simulate", at("r1.json"), "--policy", policy, "--log", "--out", at(policy));
  muster("report", at("rollout-steps"), at("certified"), at("mpq"), "--out", at("three.html"));
  muster("report", at("mpq"), "--out", at("mpq.html"));
  for (const name of ["haiti", "haiti_2010"]) {
    muster("simulate", fileURLToPath(new URL(`../../../../scenarios/${name}.json`, import.meta.url)), "--policy", "horizon", "--log", "--out", at(name));
    muster("report", at(name), "--reasons", "0", "--out", at(`${name}.html`));
  }
  const executablePath = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find((path) => {
    try { execFileSync(path, ["--version"], { stdio: "ignore" }); return true; } catch { return false; }
  });
  const browser = await chromium.launch({ executablePath, chromiumSandbox: process.getuid() !== 0,
    args: ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"] });
  await take(browser, "report.webp", "a.html", { width: 1440, height: 1300, hash: "#t=6600&sel=uav:7" });
  await take(browser, "report-phone.webp", "a.html", { width: 390, height: 844, scheme: "dark", hash: "#t=6600" });
  await take(browser, "report-comparison.webp", "three.html", { width: 1440, height: 1200, hash: "#t=6000" },
    (tab) => tab.locator("#comparison").evaluate((part) => part.scrollIntoView({ block: "end" })));
  await take(browser, "report-coast.webp", "haiti.html", { width: 1440, height: 900, hash: "#t=3600&sel=uav:11" });
  await take(browser, "report-roads.webp", "haiti_2010.html", { width: 1440, height: 900, hash: "#t=4200" });
  if (process.env.MUSTER_OSM) { // an extract of Liechtenstein, for the page of base maps
    const examples = "/usr/share/doc/tilemaker/examples";
    execFileSync("tilemaker", ["--input", process.env.MUSTER_OSM, "--output", at("li.mbtiles"), "--config", `${examples}/config-openmaptiles.json`,
      "--process", `${examples}/process-openmaptiles.lua`], { stdio: "ignore" });
    execFileSync("sqlite3", [at("li.mbtiles"), "insert into metadata values ('attribution', '© OpenStreetMap contributors')"]);
    muster("scenario", "--origin", "47.05,9.47", "--area", "18x25", "--roads", process.env.MUSTER_OSM, "--out", at("li.json"));
    muster("simulate", at("li.json"), "--limit", "120", "--log", "--out", at("li"));
    muster("report", at("li"), "--reasons", "0", "--coast", "none", "--tiles", at("li.mbtiles"), "--out", at("li.html"));
    await take(browser, "base-map.webp", "li.html", { width: 1440, height: 900, hash: "#t=5400&sel=uav:4" }, (tab) => tab.evaluate(() => {
      window.muster.parts.map.goTo({ x: 4200, y: 12000 }, 6);
      return new Promise((resolve) => { setTimeout(resolve, 1000); });
    }));
  }
  const drawn = (tab) => tab.waitForFunction(() => document.getElementById("scene").dataset.drawn);
  await take(browser, "report-scene.webp", "mpq.html", { width: 1440, height: 900, hash: "#t=4860&sel=uav:25&look=scene" }, drawn);
  await take(browser, "report-space-time.webp", "mpq.html", { width: 1440, height: 900, scheme: "dark", hash: "#t=6000&sel=uav:25&look=time" }, drawn);
  await browser.close();
} finally {
  rmSync(folder, { recursive: true });
}
