// node planted_test.mjs: plants defects in the page and in drivers, and expects the rules of eslint.config.mjs to find each. The
// same code without the defects must pass. Exits with 77 where ESLint is not installed (scripts/lint-js does it).
import { deepEqual } from "node:assert/strict";
import { existsSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
if (!existsSync(join(here, "node_modules/eslint"))) {
  console.log("SKIPPED: scripts/lint-js installs ESLint");
  process.exit(77);
}
const { ESLint } = await import("eslint");
const eslint = new ESLint({ cwd: join(here, "../.."), overrideConfigFile: join(here, "eslint.config.mjs") });

/** Expects these rules alone to find something in `code`, were it in that file; null is the parser. */
async function expectFound(filePath, code, ...rules) {
  const [{ messages }] = await eslint.lintText(code, { filePath });
  deepEqual([...new Set(messages.map((message) => message.ruleId))], rules, `${filePath}: ${code}`);
}

const PAGE = "tools/report/page/planted.js";
const DRIVER = "drivers/mavlink/planted.mjs";
const PHONE = "drivers/phone/page/planted.mjs";
for (const file of [PAGE, DRIVER, PHONE]) {
  await expectFound(file, "export const last = (list) => [...list].sort().findLast((one) => one === list[0]);\n");
  await expectFound(file, "const unused = 1;\n", "no-unused-vars");
  await expectFound(file, "export const x = missing;\n", "no-undef");
  await expectFound(file, "export const sorted = (list) => list.toSorted();\n", "no-restricted-properties");
  await expectFound(file, "export const grouped = (list, key) => Object.groupBy(list, key);\n", "no-restricted-properties");
  await expectFound(file, "export const isVowel = (text) => /[a&&e]/v.test(text);\n", null);
  await expectFound(file, "export const isOne = (x) => x == 1;\n", "eqeqeq");
  await expectFound(file, "export const x = 1;\nexport const f = (x) => x;\n", "no-shadow");
  await expectFound(file, `export function long(x) {\n${"  x();\n".repeat(80)}}\n`, "max-lines-per-function");
  await expectFound(file, "export const x = 'one';\n", "@stylistic/quotes");
  await expectFound(file, "export const x = 1\n", "@stylistic/semi");
  await expectFound(file, "export function f() {\n    return 1;\n}\n", "@stylistic/indent");
  await expectFound(file, `export const sum = 1${" + 1".repeat(40)};\n`, "@stylistic/max-len");
}
// Pages and programs have globals of their own.
await expectFound(PAGE, "export const width = window.innerWidth;\n");
await expectFound(DRIVER, "export const width = window.innerWidth;\n", "no-undef");
await expectFound(DRIVER, "export const name = process.title;\n");
await expectFound(PAGE, "export const name = process.title;\n", "no-undef");
await expectFound(PHONE, "export const name = process.title;\n", "no-undef");
