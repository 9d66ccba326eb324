// Names on the map: where they stand, and that a text is drawn once and stamped from then on.
import assert from "node:assert/strict";
import { test } from "node:test";
import { drawLabels, placeLabels } from "../../../../tools/report/page/map_labels.js";

const SIZE = { width: 200, height: 100 };

/** A context that notes what is done to it. */
function noting() {
  const done = { strokeText: 0, fillText: 0, measureText: 0, drawImage: [] };
  return { done, save() {}, restore() {}, scale() {}, translate() {}, strokeText() { ++done.strokeText; }, fillText() { ++done.fillText; },
    measureText(text) { ++done.measureText; return { width: 6 * text.length }; }, drawImage(picture, ...place) { done.drawImage.push([picture.width, picture.height, ...place]); } };
}

test("names go to the first side that has room, none over another", () => {
  const label = (text, px, py) => ({ text, px, py, gap: 5 });
  const at = (labels, taken) => placeLabels(labels, (text) => 6 * text.length, SIZE, taken).map(({ text, left, bottom }) => [text, left, bottom]);
  assert.deepEqual(at([label("U8", 50, 50)]), [["U8", 55, 47]]);
  assert.deepEqual(at([label("U8", 50, 50), label("W46", 50, 50)]), [["U8", 55, 47], ["W46", 55, 61]]);
  assert.deepEqual(at([label("U8", 195, 50)]), [["U8", 178, 47]], "left of it at the right edge");
  assert.deepEqual(at([label("U8", 50, 50)], [{ left: 0, top: 0, wide: 200, high: 100 }]), []);
});

test("a text is measured and drawn once, and stamped on whole pixels from then on", () => {
  const made = [];
  globalThis.window = { devicePixelRatio: 2 };
  globalThis.OffscreenCanvas = class {
    constructor(width, height) { Object.assign(this, { width, height, context: noting() }); made.push(this); }
    getContext() { return this.context; }
    transferToImageBitmap() { return { width: this.width, height: this.height }; }
  };
  const c = noting();
  const draw = (px, colour = "#333") => drawLabels(c, [{ text: "U8", px, py: 50, gap: 5, colour }], SIZE, "#fff");
  for (const px of [50, 50.2, 57.7]) draw(px);
  assert.equal(made.length, 1);
  assert.deepEqual([made[0].context.done.strokeText, made[0].context.done.fillText, c.done.strokeText, c.done.fillText, c.done.measureText], [1, 1, 0, 0, 1]);
  // 12 pixels of text between halos of 3 pixels; the screen has two pixels for each of them.
  assert.deepEqual(c.done.drawImage, [[36, 40, 52, 32, 18, 20], [36, 40, 52, 32, 18, 20], [36, 40, 59.5, 32, 18, 20]]);
  draw(50, "#c00");
  assert.equal(made.length, 2, "another colour is another picture");
});
