import { fit, oncePerFrame } from "./canvas.js";
import { element } from "./dom.js";
import { linear, roundTicks } from "./scale.js";
import { theme } from "./theme.js";

/** Between the canvas' border and the curves, in pixels. */
const BOX = { left: 52, top: 17, right: 25, bottom: 26 };
const LABEL_PX = 26;
const POINT_PX = 5;
const CLICK_PX = 3;
const SELECTION_PX = 12;

/** The index of the point nearest to x among ascending `xs`; -1 when there is none. */
export function nearest(xs, x) {
  let best = -1;
  for (let i = 0; i < xs.length; ++i) {
    if (best < 0 || Math.abs(xs[i] - x) < Math.abs(xs[best] - x)) best = i;
  }
  return best;
}

/**
 * Curves over one axis, on a canvas in `host`. A curve is { x, y, stroke, width, dash, stepped,
 * points }; where y is null, nothing is known. `options`: xTicks(range, pixels) returns [value,
 * text] pairs, behind(c, plot) draws below the curves, onHover(x or null), onDrag(left, right) in
 * pixels, onClick(x), onSelect(from, to) and onReset() tell what the pointer does.
 */
export class Plot {
  constructor(host, options) {
    this.host = host;
    this.options = options;
    this.curves = [];
    this.xRange = [0, 1];
    this.yRange = [0, 1];
    this.hoverX = null;
    this.canvas = element("canvas");
    this.line = element("div", { class: "plot-line", hidden: true });
    this.selection = element("div", { class: "plot-selection", hidden: true });
    this.over = element("div", { class: "plot-over" }, this.selection, this.line);
    this.over.style.inset = `${BOX.top}px ${BOX.right}px ${BOX.bottom}px ${BOX.left}px`;
    this.dots = [];
    host.append(this.canvas, this.over);
    this.redraw = oncePerFrame(() => this.#draw());
    this.#listen();
  }

  get width() {
    return Math.max(1, this.host.clientWidth - BOX.left - BOX.right);
  }

  get height() {
    return Math.max(1, this.host.clientHeight - BOX.top - BOX.bottom);
  }

  /** Values to pixels from the curves' left border. */
  get x() {
    return linear(this.xRange, [0, this.width]);
  }

  get y() {
    return linear(this.yRange, [this.height, 0]);
  }

  show(curves, yRange) {
    this.curves = curves;
    this.yRange = yRange;
    for (const dot of this.dots) dot.remove();
    this.dots = curves.map(({ stroke }) => element("div", { class: "plot-dot", hidden: true, style: `background: ${stroke}` }));
    this.over.append(...this.dots);
    this.hover(this.hoverX);
    this.redraw();
  }

  /** The pointer's line, and each curve's nearest point. */
  hover(x) {
    this.hoverX = x;
    const at = x === null ? NaN : this.x(x);
    this.line.hidden = !(at >= 0 && at <= this.width);
    this.line.style.transform = `translateX(${at}px)`;
    const { x: toX, y: toY } = this;
    this.curves.forEach((curve, i) => {
      const known = this.line.hidden ? -1 : nearest(curve.x, x);
      const left = toX(curve.x[known]);
      this.dots[i].hidden = known < 0 || curve.y[known] === null || left < 0 || left > this.width;
      if (!this.dots[i].hidden) this.dots[i].style.transform = `translate(${left}px, ${toY(curve.y[known])}px)`;
    });
  }

  #draw() {
    const { context: c, width } = fit(this.canvas);
    if (width === 0) return;
    c.translate(BOX.left, BOX.top);
    this.#clipped(c, () => this.options.behind(c, this));
    this.#drawAxes(c);
    for (const curve of this.curves) {
      const known = this.#places(curve);
      this.#clipped(c, () => drawCurve(c, curve, known));
      if (curve.points) this.#drawPoints(c, curve, known);
    }
  }

  #clipped(c, draw) {
    c.save();
    c.beginPath();
    c.rect(0, 0, this.width, this.height);
    c.clip();
    draw();
    c.restore();
  }

  #drawAxes(c) {
    const { x, y, width, height } = this;
    c.font = "11px system-ui, sans-serif";
    c.fillStyle = theme.muted;
    c.strokeStyle = theme.grid;
    c.lineWidth = 1;
    c.beginPath();
    c.textAlign = "center";
    c.textBaseline = "top";
    for (const [value, text] of this.options.xTicks(this.xRange, width)) {
      const px = Math.round(x(value)) + 0.5;
      c.moveTo(px, 0);
      c.lineTo(px, height);
      c.fillText(text, px, height + 7);
    }
    c.textAlign = "right";
    c.textBaseline = "middle";
    for (const value of roundTicks(this.yRange, height / LABEL_PX)) {
      const py = Math.round(y(value)) + 0.5;
      c.moveTo(0, py);
      c.lineTo(width, py);
      c.fillText(value >= 10000 ? `${value / 1000}k` : String(value), -4, py);
    }
    c.stroke();
  }

  /** Where a curve's points are that are known. */
  #places(curve) {
    const { x, y } = this;
    const places = [];
    for (let i = 0; i < curve.x.length; ++i) {
      if (curve.y[i] !== null) places.push([x(curve.x[i]), y(curve.y[i])]);
    }
    return places;
  }

  #drawPoints(c, { stroke }, places) {
    c.strokeStyle = stroke;
    c.fillStyle = "#fff";
    c.lineWidth = 1;
    for (const [px, py] of places) {
      if (px < 0 || px > this.width) continue;
      c.beginPath();
      c.arc(px, py, POINT_PX / 2 - 0.5, 0, 2 * Math.PI);
      c.fill();
      c.stroke();
    }
  }

  /** Shows what a drag selects. */
  mark(left, right) {
    this.selection.hidden = left === right;
    this.selection.style.left = `${left}px`;
    this.selection.style.width = `${right - left}px`;
  }

  /** A click, a drag that selects, or one too short for either. */
  #listen() {
    const { onHover, onDrag, onClick, onSelect, onReset } = this.options;
    let from = null;
    let dragged = false;
    const at = (event) => Math.min(this.width, Math.max(0, event.clientX - this.over.getBoundingClientRect().left));
    this.over.addEventListener("mousedown", (event) => {
      if (event.button !== 0) return;
      event.preventDefault();
      from = at(event);
      dragged = false;
      const move = (moved) => {
        if (Math.abs(at(moved) - from) > CLICK_PX) dragged = true;
        onDrag(Math.min(from, at(moved)), Math.max(from, at(moved)));
      };
      document.addEventListener("mousemove", move);
      document.addEventListener("mouseup", (up) => {
        document.removeEventListener("mousemove", move);
        onDrag(0, 0);
        const [left, right] = [Math.min(from, at(up)), Math.max(from, at(up))];
        if (right - left >= SELECTION_PX) onSelect(this.x.invert(left), this.x.invert(right));
      }, { once: true });
    });
    this.over.addEventListener("mousemove", (event) => onHover(this.x.invert(at(event))));
    this.over.addEventListener("mouseleave", () => onHover(null));
    this.over.addEventListener("click", (event) => {
      if (!dragged) onClick(this.x.invert(at(event)));
    });
    this.over.addEventListener("dblclick", onReset);
  }
}

function drawCurve(c, { stroke, width, dash, stepped }, places) {
  c.strokeStyle = stroke;
  c.lineWidth = width;
  c.lineJoin = "round";
  c.setLineDash(dash);
  c.beginPath();
  places.forEach(([px, py], i) => {
    if (stepped && i > 0) c.lineTo(px, places[i - 1][1]);
    c.lineTo(px, py);
  });
  c.stroke();
}
