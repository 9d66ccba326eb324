// node peer.mjs WORK WAY_LENGTHS MAP.osm.pbf: asks Valhalla for the shortest ways of WORK/lengths.csv, which the program WAY_LENGTHS has
// written for WORK/scenario.json, on foot and by car, on the same map, and compares. WORK has node_modules, too.
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

const SAME_PLACE_M = 2;
/** Of the middle of a piece of our way from the road that they know there; they round lines off. */
const SAME_ROAD_M = 8;
const [work, wayLengths, map] = process.argv.slice(2);
const require = createRequire(join(work, "package.json"));
const { Actor } = require("@valhallajs/valhallajs");

const config = join(work, "valhalla.json");
const tiles = join(work, "tiles");
const valhalla = (...args) => execFileSync("npx", ["valhalla", ...args], { cwd: work, encoding: "utf8", stdio: ["ignore", "pipe", "pipe"], maxBuffer: 1 << 28 });
if (!existsSync(tiles)) {
  const made = JSON.parse(valhalla("build_config", "--mjolnir-tile-dir", tiles));
  for (const part of Object.values(made)) if (part?.logging) part.logging.type = "";  // it tells of every route
  writeFileSync(config, JSON.stringify(made));
  valhalla("build_tiles", "-c", config, map);
}
const actor = await Actor.fromConfigFile(config);
const [head, ...lines] = readFileSync(join(work, "lengths.csv"), "utf8").trim().split("\n");
const names = head.split(",");
const pairs = lines.map((line) => Object.fromEntries(line.split(",").map((cell, i) => [names[i], Number(cell)])));

/** Metres between two places that are near each other. */
function apart(a, b) {
  const north = (b.lat - a.lat) * 111_200;
  const east = (b.lon - a.lon) * 111_200 * Math.cos(a.lat * Math.PI / 180);
  return Math.hypot(north, east);
}

/** Whether Valhalla, too, takes the place to be on the road that it was drawn on. */
async function isThere(place, costing) {
  const [{ edges }] = await actor.locate({ locations: [place], costing, verbose: true });
  return (edges ?? []).some((edge) => apart(place, { lat: edge.correlated_lat, lon: edge.correlated_lon }) <= SAME_PLACE_M);
}

/** Whether they, too, may use all roads of our way, and pass through them: some are for residents only. */
async function isOpenToThem(pair, kind, costing) {
  const ends = [[pair.from_lat, pair.from_lon], [pair.to_lat, pair.to_lon]];
  const corners = execFileSync(wayLengths, [join(work, "scenario.json"), ...ends.flat().map(String)], { encoding: "utf8" }).trim().split("\n")
    .map((line) => line.split(",")).filter(([of]) => of === kind).map(([, lat, lon]) => [Number(lat), Number(lon)]);
  const way = [ends[0], ...corners, ends[1]];
  for (let i = 1; i < way.length; ++i) {
    const place = { lat: (way[i - 1][0] + way[i][0]) / 2, lon: (way[i - 1][1] + way[i][1]) / 2 };
    const [{ edges }] = await actor.locate({ locations: [place], costing, verbose: true });
    const there = (edges ?? []).filter((edge) => apart(place, { lat: edge.correlated_lat, lon: edge.correlated_lon }) <= SAME_ROAD_M);
    if (!there.some(({ edge }) => costing === "pedestrian" || !edge.destination_only)) return false;
  }
  return true;
}

async function theirs(from, to, costing) {
  try {
    const { trip } = await actor.route({ locations: [from, to], costing, costing_options: { [costing]: { shortest: true, ...(costing === "auto" ? { ignore_restrictions: true } : {}) } },
      units: "kilometers", directions_type: "none" });
    return trip.summary.length * 1000;
  } catch (error) {
    return String(error.message ?? error).includes("442") || /No path/.test(String(error)) ? Infinity : Promise.reject(error);
  }
}

for (const [ours, costing] of [["worker_m", "pedestrian"], ["vehicle_m", "auto"]]) {
  const rows = [];
  let elsewhere = 0;
  const neither = [];
  for (const pair of pairs) {
    const from = { lat: pair.from_lat, lon: pair.from_lon };
    const to = { lat: pair.to_lat, lon: pair.to_lon };
    if (!await isThere(from, costing) || !await isThere(to, costing)) {
      elsewhere += 1;
      continue;
    }
    const m = await theirs(from, to, costing);
    if (!Number.isFinite(m) || !Number.isFinite(pair[ours])) {
      neither.push({ ...pair, m });
      continue;
    }
    rows.push({ ...pair, m, off: pair[ours] / m - 1 });
  }
  const within = (share) => rows.filter((row) => Math.abs(row.off) <= share).length;
  let closed = 0;
  for (const row of rows.filter(({ off }) => Math.abs(off) > 0.01)) {
    row.isClosed = !await isOpenToThem(row, ours.replace("_m", ""), costing);
    closed += row.isClosed ? 1 : 0;
  }
  console.log(`${costing}: ${pairs.length} pairs, ${elsewhere} not on the same road, ${neither.length} without a way for one of the two; of ${rows.length}:`);
  for (const share of [0.001, 0.01, 0.05]) console.log(`  within ${share * 100} %: ${(100 * within(share) / rows.length).toFixed(1)} %`);
  console.log(`  of those beyond 1 % ${closed} go by roads that are closed to them; of the others within 1 %: ${(100 * within(0.01) / (rows.length - closed)).toFixed(1)} %`);
  console.log(`  all together: ours ${(rows.reduce((sum, row) => sum + row[ours], 0) / rows.reduce((sum, row) => sum + row.m, 0)).toFixed(4)} times theirs`);
  const open = rows.filter(({ isClosed }) => !isClosed);
  open.sort((a, b) => Math.abs(b.off) - Math.abs(a.off));
  for (const row of open.slice(0, 10)) {
    console.log(`  ${(100 * row.off).toFixed(1)} %: ours ${row[ours].toFixed(0)} m, theirs ${row.m.toFixed(0)} m, ${row.from_lat},${row.from_lon} (way ${row.from_id}) to ${row.to_lat},${row.to_lon} (way ${row.to_id})`);
  }
  for (const row of neither.slice(0, 5)) {
    console.log(`  ours ${row[ours]} m, theirs ${row.m} m: ${row.from_lat},${row.from_lon} (way ${row.from_id}) to ${row.to_lat},${row.to_lon} (way ${row.to_id})`);
  }
}
