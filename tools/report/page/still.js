const MARGIN = 0.25; // of the map's width and height, on each side

/** Layers that look the same wherever the map is moved to: while it is moved, they are copied from a picture larger than the view. */
export class Still {
  constructor() {
    this.canvas = null;
    this.key = null;
  }

  /** They have changed. */
  clear() {
    this.key = null;
  }

  /**
   * Draws what `paint(context, wide, high)` paints for the view and so many pixels around it; the view's corner is at (wide, high)
   * of the context. It is the same for the same `key`.
   */
  draw(c, { x, y, width, height }, key, paint) {
    if (key !== this.key) {
      this.key = key;
      this.painted = null;
      paint(c, 0, 0);
      return;
    }
    const at = { left: x(0), top: y(0), width, height };
    const ratio = c.getTransform().a;
    if (!this.painted || !covers(this.painted, at)) this.#paint(at, ratio, paint);
    const { left, top, wide, high } = this.painted;
    const onPixel = (place) => Math.round(place * ratio) / ratio;
    c.drawImage(this.canvas, onPixel(at.left - left) - wide, onPixel(at.top - top) - high, this.canvas.width / ratio, this.canvas.height / ratio);
  }

  #paint(at, ratio, paint) {
    const [wide, high] = [at.width, at.height].map((size) => Math.round(size * MARGIN * ratio) / ratio);
    this.canvas ??= document.createElement("canvas");
    this.canvas.width = Math.round((at.width + 2 * wide) * ratio);
    this.canvas.height = Math.round((at.height + 2 * high) * ratio);
    const c = this.canvas.getContext("2d");
    c.scale(ratio, ratio);
    paint(c, wide, high);
    this.painted = { ...at, wide, high };
  }
}

/** Whether a picture holds what is in view now. */
const covers = ({ left, top, wide, high, width, height }, at) =>
  Math.abs(at.left - left) <= wide && Math.abs(at.top - top) <= high && at.width === width && at.height === height;
