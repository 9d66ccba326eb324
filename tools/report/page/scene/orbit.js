import { ALL_FREE } from "../free_part.js";
import { SIZE } from "./plane.js";

const NEAREST = 3;
const FURTHEST = 4 * SIZE;
const LOWEST = 1.5; // radians from above
const TURN = 0.006; // radians a pixel
const DRAG_PX = 4;
const FITS = 12;
const FILLED = 0.93; // of the free part of the canvas
const LEAST_PX = 40; // that are free each way

/** How much is seen from top to bottom. */
export const FIELD_DEG = 38;

const START = { azimuth: -0.45, polar: 0.92 };

/** A camera that looks at a place on the ground from around it; drags, the wheel, two fingers and keys move it. */
export class Orbit {
  constructor(canvas, changed) {
    this.canvas = canvas;
    this.changed = changed;
    this.pointers = new Map();
    this.travelled = 0;
    this.free = ALL_FREE; // how many pixels at each side are covered by what floats on the canvas
    this.reset(SIZE, SIZE);
    this.#bind();
  }

  /** All of an area so wide and deep, with things up to `tall` above it. */
  reset(wide, deep, tall = 0) {
    Object.assign(this, START, { wide, deep, tall });
    this.fit();
  }

  /** The size of the canvas' free part, and how far its middle is from that of the canvas: pixels. */
  get #room() {
    const { free: { left, right, top, bottom }, canvas: { clientWidth: width, clientHeight: height } } = this;
    return { wide: Math.max(LEAST_PX, width - left - right), high: Math.max(LEAST_PX, height - top - bottom), dx: (left - right) / 2, dy: (top - bottom) / 2 };
  }

  /** As near as shows all, in the middle, for the canvas' free part as it is. */
  fit() {
    const { wide, high } = this.#room;
    const perPixel = Math.tan((FIELD_DEG * Math.PI) / 360) / Math.max(1, this.canvas.clientHeight);
    const [tanX, tanY] = [wide * perPixel, high * perPixel];
    const [sinA, cosA, sinP, cosP] = [Math.sin(this.azimuth), Math.cos(this.azimuth), Math.sin(this.polar), Math.cos(this.polar)];
    const [back, right, up] = [[sinP * sinA, cosP, sinP * cosA], [cosA, 0, -sinA], [-cosP * sinA, sinP, -cosP * cosA]];
    const along = (v, axis) => v[0] * axis[0] + v[1] * axis[1] + v[2] * axis[2];
    this.target = [0, 0, 0];
    this.distance = SIZE;
    for (let i = 0; i < FITS; ++i) {
      const seen = { x: [Infinity, -Infinity], y: [Infinity, -Infinity] };
      for (let corner = 0; corner < 8; ++corner) {
        const place = [(corner & 1 ? 0.5 : -0.5) * this.wide, corner & 2 ? this.tall : 0, (corner & 4 ? 0.5 : -0.5) * this.deep];
        const from = place.map((v, axis) => v - this.target[axis]);
        const far = Math.max(1, this.distance - along(from, back));
        for (const [key, axis, tan] of [["x", right, tanX], ["y", up, tanY]]) {
          const at = along(from, axis) / (far * tan);
          seen[key] = [Math.min(seen[key][0], at), Math.max(seen[key][1], at)];
        }
      }
      const middle = ({ x, y }) => [((x[0] + x[1]) / 2) * tanX * this.distance, ((y[0] + y[1]) / 2) * tanY * this.distance];
      const [dx, dy] = middle(seen);
      this.target = this.target.map((v, axis) => v + dx * right[axis] + dy * up[axis]);
      this.distance *= Math.max(seen.x[1] - seen.x[0], seen.y[1] - seen.y[0]) / 2 / FILLED;
    }
    this.moved = false;
  }

  aim(camera) {
    const flat = this.distance * Math.sin(this.polar);
    camera.position.set(this.target[0] + flat * Math.sin(this.azimuth), this.target[1] + this.distance * Math.cos(this.polar),
      this.target[2] + flat * Math.cos(this.azimuth));
    camera.lookAt(...this.target);
    // What is looked at is in the middle of the free part.
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const { dx, dy } = this.#room;
    camera.setViewOffset(width, height, -dx, -dy, width, height);
  }

  turn(azimuth, polar) {
    this.azimuth += azimuth;
    this.polar = Math.min(LOWEST, Math.max(0.02, this.polar + polar));
    this.#did();
  }

  zoom(factor) {
    this.distance = Math.min(FURTHEST, Math.max(NEAREST, this.distance * factor));
    this.#did();
  }

  /** By so many pixels of the canvas, over the ground. */
  pan(dx, dy) {
    const perPixel = (this.distance * 0.9) / Math.max(1, this.canvas.clientHeight);
    const [cos, sin] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
    this.target[0] -= (dx * cos + dy * sin) * perPixel;
    this.target[2] -= (dy * cos - dx * sin) * perPixel;
    this.followed?.();
    this.#did();
  }

  /** Looks at a place, from as near as `distance` at least. */
  lookAt(target, distance = Infinity) {
    this.target = [...target];
    this.distance = Math.min(this.distance, distance);
    this.#did();
  }

  #did() {
    this.moved = true;
    this.changed();
  }

  #bind() {
    const { canvas, pointers } = this;
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const perNotch = event.deltaMode === 1 ? 0.05 : event.deltaMode ? 1 : 0.0016;
      this.zoom(2 ** (event.deltaY * perNotch * (event.ctrlKey ? 10 : 1)));
    }, { passive: false });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("pointerdown", (event) => {
      if (pointers.size === 2) return;
      if (pointers.size === 0) this.travelled = 0;
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      const last = pointers.get(event.pointerId);
      if (!last) return;
      const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
      this.travelled += Math.hypot(dx, dy);
      const apart = () => {
        const [a, b] = [...pointers.values()];
        return Math.hypot(a.x - b.x, a.y - b.y) || 1;
      };
      const before = pointers.size === 2 ? apart() : 0;
      pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      if (pointers.size === 2) {
        this.zoom(before / apart());
        this.pan(dx / 2, dy / 2);
      } else if (event.shiftKey || event.buttons === 2) this.pan(dx, dy);
      else this.turn(-dx * TURN, -dy * TURN);
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
    canvas.addEventListener("click", (event) => {
      if (this.travelled > DRAG_PX) event.stopImmediatePropagation();
      this.travelled = 0;
    }, true);
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = 40;
    const move = event.shiftKey
      ? { ArrowLeft: () => this.pan(step, 0), ArrowRight: () => this.pan(-step, 0), ArrowUp: () => this.pan(0, step), ArrowDown: () => this.pan(0, -step) }
      : { ArrowLeft: () => this.turn(-0.12, 0), ArrowRight: () => this.turn(0.12, 0), ArrowUp: () => this.turn(0, -0.08), ArrowDown: () => this.turn(0, 0.08) };
    const action = { ...move, "+": () => this.zoom(0.85), "=": () => this.zoom(0.85), "-": () => this.zoom(1 / 0.85) }[event.key];
    if (!action) return;
    event.preventDefault();
    event.stopPropagation(); // elsewhere these keys move the time
    action();
  }
}
