// The names of streets on the base map: which have room, and how they stand.
import assert from "node:assert/strict";
import { test } from "node:test";
import { placeStreets } from "../../../../tools/report/page/layers/street_names.js";

const MAP = { x: (m) => m, y: (m) => 500 - m, width: 800, height: 500 }; // a pixel a metre
const street = (text, from, to, rank = 7) => ({ text, rank, from: { x: from[0], y: from[1] }, to: { x: to[0], y: to[1] } });
const named = (streets, map = MAP) => placeStreets(streets, (text) => 6 * text.length, map);
const texts = (streets, map) => named(streets, map).map(({ text }) => text);

test("a name stands in the middle of its street, along it, never upside down", () => {
  const [east] = named([street("Mill Lane", [100, 100], [300, 100])]);
  assert.deepEqual(east, { text: "Mill Lane", px: 200, py: 400, angle: 0 });
  const [west] = named([street("Mill Lane", [300, 100], [100, 100])]);
  assert.ok(Math.abs(west.angle) < 1e-9);
  const [up] = named([street("Mill Lane", [300, 300], [200, 200])]); // to the south-west: it is read to the north-east
  assert.ok(Math.abs(up.angle + Math.PI / 4) < 1e-9, `${up.angle}`);
});

test("a name that is longer than its street, or out of view, is left out", () => {
  assert.deepEqual(texts([street("Mill Lane", [100, 100], [153, 100])]), []);
  assert.deepEqual(texts([street("Mill Lane", [100, 100], [155, 100])]), ["Mill Lane"]);
  assert.deepEqual(texts([street("Mill Lane", [900, 100], [1100, 100])]), []);
});

test("where names would lie over each other the more important stays, then the longer", () => {
  const crossing = [street("Lane", [100, 200], [300, 200]), street("High Street", [200, 50], [200, 350], 6), street("Steps", [210, 150], [210, 250], 8)];
  assert.deepEqual(texts(crossing), ["High Street"]);
  assert.deepEqual(texts([...crossing, street("Mill Lane", [400, 200], [600, 200])]), ["High Street", "Mill Lane"]);
  assert.deepEqual(texts([street("Short", [100, 100], [200, 100]), street("Long", [100, 105], [250, 105])]), ["Long"]);
});

test("a street that goes on in the next tile is named again only far away", () => {
  const parts = [street("Mill Lane", [0, 100], [200, 100]), street("Mill Lane", [200, 100], [390, 100]), street("Mill Lane", [400, 100], [550, 100])];
  assert.deepEqual(named(parts).map(({ px }) => px), [100, 475]);
});

test("the smaller the map, the fewer kinds of streets are named", () => {
  const all = [street("A", [0, 0], [9000, 0], 6), street("B", [0, 3000], [9000, 3000]), street("C", [0, 6000], [9000, 6000], 8)];
  const at = (perMetre) => texts(all, { ...MAP, x: (m) => m * perMetre, y: (m) => 500 - m * perMetre, width: 5000, height: 5000 });
  assert.deepEqual(at(0.03), []);
  assert.deepEqual(at(0.05), ["A"]);
  assert.deepEqual(at(0.15).sort(), ["A", "B"]);
});
