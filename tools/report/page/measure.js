// Distances and areas on the map: clicks are corners, and their line is measured as the crow flies.
import { byId, number } from "./dom.js";
import { say } from "./language.js";

/** Metres along a line of places. */
export function lengthOf(corners) {
  return corners.slice(1).reduce((sum, { x, y }, i) => sum + Math.hypot(x - corners[i].x, y - corners[i].y), 0);
}

/** Square metres within corners (Gauss's area formula). */
export function areaOf(corners) {
  return Math.abs(corners.reduce((sum, { x, y }, i) => {
    const next = corners[(i + 1) % corners.length];
    return sum + x * next.y - next.x * y;
  }, 0)) / 2;
}

const metres = (m) => (m < 1000 ? `${number(m)} m` : `${number(m / 1000, 2)} km`);
const squareMetres = (m2) => (m2 < 1e5 ? `${number(m2)} m²` : `${number(m2 / 1e6, 2)} km²`);

/** "3.42 km; the last part 1.20 km; 0.80 km² within" */
export function measureText(corners) {
  if (corners.length < 2) return say(corners.length === 0 ? "Click the first place on the map." : "Click the next place.");
  const parts = [metres(lengthOf(corners))];
  if (corners.length > 2) parts.push(say("the last part {way}", { way: metres(lengthOf(corners.slice(-2))) }), say("{area} within", { area: squareMetres(areaOf(corners)) }));
  return parts.join("; ");
}

/** The tool of the map: on, each click adds a corner. */
export class Measure {
  constructor(state, map) {
    this.state = state;
    this.map = map;
    this.taken = null; // what the map tells clicks to while this measures
    this.corners = [];
    byId("measure").addEventListener("click", () => this.toggle());
    byId("measure-back").addEventListener("click", () => this.#set(this.corners.slice(0, -1)));
    byId("measure-again").addEventListener("click", () => this.#set([]));
    byId("measure-stop").addEventListener("click", () => this.stop());
  }

  /** Whether the map's clicks are its own: an order may have taken them over. */
  get on() {
    return this.taken !== null && this.map.picking === this.taken;
  }

  toggle() {
    if (this.on) return this.stop();
    this.state.look("map");
    this.taken = (place) => this.#set([...this.corners, place]);
    this.map.pick(this.taken, () => this.#leave());
    byId("measure").setAttribute("aria-pressed", "true");
    byId("measure-box").hidden = false;
    return this.#set([]);
  }

  stop() {
    this.map.pick(null);
    this.map.mark(null);
  }

  #leave() {
    this.taken = null;
    byId("measure").setAttribute("aria-pressed", "false");
    byId("measure-box").hidden = true;
  }

  #set(corners) {
    this.corners = corners;
    this.map.mark(null, Object.assign([...corners], { open: true }));
    byId("measure-text").textContent = measureText(corners);
    byId("measure-back").hidden = corners.length === 0;
    byId("measure-again").hidden = corners.length === 0;
  }
}
