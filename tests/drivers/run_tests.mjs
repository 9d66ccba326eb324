// node run_tests.mjs DRIVER FILE...: runs these tests of drivers/DRIVER, or says why it cannot and exits with 77.
// MUSTER_DRIVERS=required makes that a failure.
import { spawnSync } from "node:child_process";
import { existsSync, readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const [driver, ...files] = process.argv.slice(2);
const folder = join(here, "../../drivers", driver);
const { dependencies, devDependencies } = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
const needed = Object.keys({ ...dependencies, ...devDependencies });
const missing = needed.filter((name) => !existsSync(join(folder, "node_modules", name)));
if (missing.length) {
  console.log(`SKIPPED: ${missing.join(", ")} is not installed; scripts/test-drivers does it`);
  process.exit(process.env.MUSTER_DRIVERS === "required" ? 1 : 77);
}
const tests = spawnSync(process.execPath, ["--test", ...files.map((name) => join(here, driver, name))], { stdio: "inherit" });
process.exit(tests.status ?? 1);
