// Which alerts stand out on the map, in numbers.
import assert from "node:assert/strict";
import { test } from "node:test";
import { loudAlerts } from "../../../../tools/report/page/alert_marks.js";
import { agentsWithAlerts } from "../../../../tools/report/page/attention.js";
import { levelOf } from "../../../../tools/report/page/clusters.js";
import { Present } from "../../../../tools/report/page/present.js";
import { State } from "../../../../tools/report/page/state.js";
import { FAILED, IDLE } from "../../../../tools/report/page/words.js";
import { SCENARIO, begun } from "./small_run.mjs";

begun(); // from here on statuses have their numbers
const alert = (order, x, y, status = IDLE) => ({ order, x, y, status });
const orders = (items, level) => [...loudAlerts(items, level)].map(({ order }) => order).sort((a, b) => a - b);

/** So many alerts on a map of 1000 m by 1000 m, each somewhere else; the order has nothing to do with the place. */
function spread(n) {
  const side = Math.ceil(Math.sqrt(n));
  return Array.from({ length: n }, (_, i) => alert((i * 7919) % n, ((i % side) + 0.5) * (1000 / side), (Math.floor(i / side) + 0.5) * (1000 / side)));
}

test("up to ten alerts all stand out, wherever they are", () => {
  assert.deepEqual(orders([], 6), []);
  assert.deepEqual(orders([alert(0, 5, 5)], 6), [0]);
  assert.deepEqual(orders(Array.from({ length: 10 }, (_, i) => alert(i, 5, 5)), 6), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
});

test("of more the ten most urgent stand out, and the most urgent of each square of 128 to 256 pixels", () => {
  const crowd = Array.from({ length: 40 }, (_, i) => alert(i, 5, 5)).reverse();
  assert.deepEqual(orders(crowd, 6), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
  const beside = [alert(42, 129, 5), alert(41, 130, 6), alert(40, 127, 5)];
  assert.deepEqual(orders([...crowd, ...beside], 6), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 41]);
  assert.deepEqual(orders([...crowd, ...beside], 7), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9], "a level up they share a square");
});

test("300 alerts: few stand out while all of the map is seen, more as it is zoomed in, in the end all", () => {
  const found = [0.6, 1.2, 2.4, 9.6].map((perMetre) => orders(spread(300), levelOf(perMetre)).length);
  assert.ok(found[0] >= 10 && found[0] <= 35, String(found));
  assert.ok(found[1] > found[0] && found[2] > found[1] && found[2] < 300, String(found));
  assert.equal(found[3], 300);
});

test("who has failed takes no ring from who flies", () => {
  const failed = Array.from({ length: 12 }, (_, i) => alert(i, 5, 5, FAILED));
  assert.deepEqual(orders([...failed, alert(12, 5, 5)], 6), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 12]);
});

test("the order is that of the panel; what does not stand out may be in a cluster, unless it is selected", () => {
  const uavs = 15;
  const run = begun({ scenario: { ...SCENARIO, uavs, range_full_m: Array(uavs).fill(30000) }, now_ms: 600000,
    stops: Array.from({ length: uavs }, (_, i) => [i, 0, [0, 600 + 10 * i, 500, 5000 - 100 * i]]), spans: Array.from({ length: uavs }, (_, i) => [i, 0, [0, IDLE]]) });
  assert.deepEqual([...agentsWithAlerts(run, 1000).keys()].map(({ id }) => id), [14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0], "the least range comes first");
  const state = new State();
  state.runs = [run];
  const present = new Present(state);
  present.look(1000);
  const of = (key) => present.squares(9) && present.items.filter((item) => item.agent && item[key]).map(({ agent }) => agent.id);
  assert.equal(of("urgent").length, uavs);
  assert.deepEqual(of("loud"), [5, 6, 7, 8, 9, 10, 11, 12, 13, 14]);
  assert.deepEqual(of("alone"), of("loud"));
  state.select({ type: "agent", index: 2 });
  assert.deepEqual(of("loud"), [2, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14]);
});
