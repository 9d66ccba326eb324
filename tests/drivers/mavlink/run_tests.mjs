// node run_tests.mjs FILE...: runs these tests, or says why it cannot and exits with 77. MUSTER_DRIVERS=required makes that a
// failure.
import { spawnSync } from "node:child_process";
import { existsSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
if (!existsSync(join(here, "../../../drivers/mavlink/node_modules/node-mavlink"))) {
  console.log("SKIPPED: node-mavlink is not installed; scripts/test-drivers does it");
  process.exit(process.env.MUSTER_DRIVERS === "required" ? 1 : 77);
}
const tests = spawnSync(process.execPath, ["--test", ...process.argv.slice(2).map((name) => join(here, name))], { stdio: "inherit" });
process.exit(tests.status ?? 1);
