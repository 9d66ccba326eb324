import { Sprites } from "./sprites.js";

const FONT = "11px system-ui, sans-serif";
const HEIGHT = 12;
const HALO_PX = 3;
const pictures = new Sprites();

/**
 * Texts beside places, the first ones first, none over another: each goes to the first of four sides where there is
 * room, and is left out where there is none. `labels`: [{ text, px, py, gap, colour }]; `taken`: boxes that are not free.
 */
export function placeLabels(labels, widthOf, { width, height }, taken = []) {
  const blocks = [...taken];
  const placed = [];
  const free = (box) => box.left >= 0 && box.top >= 0 && box.left + box.wide <= width && box.top + HEIGHT <= height
    && blocks.every((b) => box.left + box.wide < b.left || b.left + b.wide < box.left || box.top + HEIGHT < b.top || b.top + b.high < box.top);
  for (const label of labels) {
    const wide = widthOf(label.text);
    const { px, py, gap } = label;
    const box = [[px + gap, py - HEIGHT - 1], [px + gap, py + 1], [px - gap - wide, py - HEIGHT - 1], [px - gap - wide, py + 1]]
      .map(([left, top]) => ({ left, top, wide, high: HEIGHT })).find(free);
    if (!box) continue;
    blocks.push(box);
    placed.push({ ...label, left: box.left, bottom: box.top + HEIGHT - 2 });
  }
  return placed;
}

/** How wide texts are in a font, in pixels, each measured once: measured(c, text). */
export function widthsIn(font) {
  const widths = new Map();
  return (c, text) => {
    if (!widths.has(text)) {
      c.font = font;
      widths.set(text, c.measureText(text).width);
    }
    return widths.get(text);
  };
}

const measured = widthsIn(FONT);

function drawText(c, text, colour, halo) {
  c.font = FONT;
  c.textAlign = "left";
  c.lineJoin = "round";
  c.lineWidth = HALO_PX;
  c.strokeStyle = halo;
  c.strokeText(text, 0, 0);
  c.fillStyle = colour;
  c.fillText(text, 0, 0);
}

/** Draws labels where they have room. They are stamped, as symbols are: to draw a text and its halo anew takes much longer. */
export function drawLabels(c, labels, size, halo, taken) {
  c.save();
  for (const { text, left, bottom, colour } of placeLabels(labels, (of) => measured(c, of), size, taken)) {
    const reach = { left: HALO_PX, right: measured(c, text) + HALO_PX, top: HEIGHT + HALO_PX, bottom: HALO_PX + 2 };
    pictures.stampBox(c, `${colour} ${halo} ${text}`, reach, left, bottom, (s) => drawText(s, text, colour, halo));
  }
  c.restore();
}
