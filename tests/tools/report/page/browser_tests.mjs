// node browser_tests.mjs WORK [FILE]: runs the tests of FILE in Debian's Chromium. If it cannot, it says why and exits with 77;
// MUSTER_BROWSER=required makes that a failure. WORK is where playwright-core goes. Without FILE it only puts it there.
import { spawnSync } from "node:child_process";
import { copyFileSync, existsSync, mkdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const [work, file] = process.argv.slice(2);

function skip(why) {
  console.log(`SKIPPED: ${why}`);
  process.exit(process.env.MUSTER_BROWSER === "required" ? 1 : 77);
}

const chromium = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find((path) => existsSync(path));
if (!chromium) skip("there is no Chromium here; scripts/test-page installs it");
if (!["playwright-core", "axe-core"].every((name) => existsSync(join(work, "node_modules", name)))) {
  mkdirSync(work, { recursive: true });
  for (const file of ["package.json", "package-lock.json", ".npmrc"]) copyFileSync(join(here, file), join(work, file));
  const npm = spawnSync("npm", ["ci", "--ignore-scripts", "--fetch-retries=1"], { cwd: work, encoding: "utf8" });
  if (npm.status !== 0) skip(`npm cannot fetch playwright-core and axe-core: ${(npm.stderr || String(npm.error)).trim().split("\n")[0]}`);
}
if (!file) process.exit(0);
const tests = spawnSync(process.execPath, ["--test", file], {
  stdio: "inherit", env: { ...process.env, MUSTER_CHROMIUM: chromium, MUSTER_WORK: work } });
process.exit(tests.status ?? 1);
