import { byId, number } from "./dom.js";
import { PHONE } from "./folding.js";
import { say } from "./language.js";

const KEPT = "muster.sheet"; // in the browser's storage
const DRAG_PX = 6;

/** How far the sheet is drawn up: to its figures, to half of the screen, to the header. */
export const HEIGHTS = ["peek", "half", "full"];

/** Of heights in pixels, in the order of HEIGHTS, the name of the nearest. */
export const nearestHeight = (heights, px) =>
  HEIGHTS[heights.reduce((best, height, i) => (Math.abs(height - px) < Math.abs(heights[best] - px) ? i : best), 0)];

/** On a phone: the sheet at the bottom, with figures, card and what needs attention. It is drawn up by drag, click and keyboard. */
export class Sheet {
  constructor(state, attention) {
    this.state = state;
    this.attention = attention;
    this.phone = matchMedia(PHONE);
    this.box = byId("side");
    this.handle = byId("sheet-handle");
    this.root = document.documentElement;
    this.#set(this.#kept());
    this.#place();
    this.phone.addEventListener("change", () => this.#place());
    this.handle.addEventListener("pointerdown", (event) => this.#grab(event));
    this.handle.addEventListener("pointermove", (event) => this.#drag(event));
    this.handle.addEventListener("pointerup", () => this.#drop());
    this.handle.addEventListener("pointercancel", () => this.#drop());
    this.handle.addEventListener("click", () => this.#click());
    this.handle.addEventListener("keydown", (event) => this.#key(event));
    state.on("attention", () => this.#tell());
    state.on("selection", () => this.#onSelection());
    new IntersectionObserver(([{ intersectionRatio }]) => this.root.toggleAttribute("data-below", intersectionRatio < 0.25), { threshold: 0.25 })
      .observe(byId("map-panel"));
  }

  get height() {
    return this.root.dataset.sheet;
  }

  /** To the next height, after the last one the first. */
  next() {
    this.#keep(HEIGHTS[(HEIGHTS.indexOf(this.height) + 1) % HEIGHTS.length]);
  }

  #set(height) {
    this.raised = false; // for a card, and not by the user
    this.root.dataset.sheet = height;
    this.handle.setAttribute("aria-expanded", String(height !== "peek"));
    this.state.emit("fold");
  }

  #keep(height) {
    this.#set(height);
    try {
      localStorage.setItem(KEPT, height);
    } catch { /* a browser that keeps nothing */ }
  }

  #kept() {
    try {
      return HEIGHTS.find((height) => height === localStorage.getItem(KEPT)) ?? "peek";
    } catch {
      return "peek"; // a browser that keeps nothing
    }
  }

  /** The figures stand in the header or, on a phone, in the sheet. */
  #place() {
    const isPhone = this.phone.matches;
    if (isPhone) byId("sheet-top").append(byId("summary"));
    else byId("language").before(byId("summary"));
    if (isPhone) byId("side-body").tabIndex = 0; // it scrolls
    else byId("side-body").removeAttribute("tabindex");
    this.state.emit("fold");
  }

  #tell() {
    const { length } = this.attention.found;
    byId("sheet-words").textContent = say("Needs attention: {n}", { n: length ? number(length) : say("nothing") });
  }

  #onSelection() {
    const { selected } = this.state;
    this.root.toggleAttribute("data-card", Boolean(selected));
    if (!this.phone.matches) return;
    if (!selected) {
      if (this.raised) this.#set("peek");
      return;
    }
    byId("side-body").scrollTop = 0;
    if (this.height !== "peek") return;
    this.#set("half");
    this.raised = true;
  }

  #grab(event) {
    this.held = { y: event.clientY, high: this.box.offsetHeight, moved: false };
    this.handle.setPointerCapture(event.pointerId);
  }

  #drag(event) {
    if (!this.held) return;
    const by = this.held.y - event.clientY;
    this.held.moved ||= Math.abs(by) > DRAG_PX;
    if (this.held.moved) this.box.style.height = `${Math.max(60, this.held.high + by)}px`;
  }

  #drop() {
    const moved = this.held?.moved ?? false;
    this.held = null;
    this.dragged = moved;
    if (!moved) return;
    const at = this.box.offsetHeight;
    this.box.style.height = "";
    const heights = HEIGHTS.map((height) => {
      this.root.dataset.sheet = height;
      return this.box.offsetHeight;
    });
    this.#keep(nearestHeight(heights, at));
  }

  /** The click at a drag's end is none. */
  #click() {
    if (!this.dragged) this.next();
    this.dragged = false;
  }

  #key(event) {
    const by = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (!by) return;
    event.preventDefault();
    event.stopPropagation();
    this.#keep(HEIGHTS[Math.min(2, Math.max(0, HEIGHTS.indexOf(this.height) + by))]);
  }
}
