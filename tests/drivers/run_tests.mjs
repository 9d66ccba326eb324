// node run_tests.mjs DRIVER FILE...: runs these tests of drivers/DRIVER, or says why it cannot and exits with 77.
// MUSTER_DRIVERS=required makes that a failure.
import { existsSync, readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

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
// All in this process, which takes half the processor time of one for each file: what they share is loaded, and compiled, once.
for (const name of files) await import(pathToFileURL(join(here, driver, name)));
