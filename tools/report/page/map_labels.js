const FONT = "11px system-ui, sans-serif";
const HEIGHT = 12;

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

export function drawLabels(c, labels, size, halo, taken) {
  c.save();
  c.font = FONT;
  c.textAlign = "left";
  c.lineJoin = "round";
  c.lineWidth = 3;
  c.strokeStyle = halo;
  for (const { text, left, bottom, colour } of placeLabels(labels, (of) => c.measureText(of).width, size, taken)) {
    c.strokeText(text, left, bottom);
    c.fillStyle = colour;
    c.fillText(text, left, bottom);
  }
  c.restore();
}
