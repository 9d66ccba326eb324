// node build.mjs OUT: bundles src/ and its libraries into one template page, OUT.
import { readFile, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, "page.html");

async function bundle(entry) {
  const result = await build({
    entryPoints: [join(here, "src", entry)],
    bundle: true,
    minify: true,
    write: false,
    format: "iife",
    target: ["chrome110", "firefox115", "safari16.4"],
    legalComments: "none",
    logLevel: "warning",
  });
  return result.outputFiles[0].text;
}

const [script, style, page] = await Promise.all([
  bundle("main.js"), bundle("style.css"), readFile(join(here, "src/index.html"), "utf8")]);
const licences = "uPlot, (c) Leon Sorokin, MIT licence; d3-scale, d3-selection, d3-zoom, (c) Mike Bostock, ISC licence";
await writeFile(out, page
  .replace("/*STYLE*/", () => style)
  .replace("/*SCRIPT*/", () => `/* contains ${licences} */\n${script.replaceAll("</script", "<\\/script")}`));
