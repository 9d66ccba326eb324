import { fit, oncePerFrame } from "./canvas.js";
import { describe } from "./describe.js";
import { byId } from "./dom.js";
import { bindDrag } from "./drag.js";
import { homeView } from "./home_view.js";
import { MOST_SYMBOLS, cellWords, countCells } from "./layers/crowd.js";
import { LAYERS, makeLegend } from "./layers/index.js";
import { placeOf } from "./layers/selected.js";
import { placeWords } from "./place.js";
import { placeAt, statusAt, taskStatusAt } from "./run.js";
import { frameOf, linear } from "./scale.js";
import { Sprites } from "./sprites.js";
import { OFFLINE, UAV, UNREPORTED, VEHICLE } from "./words.js";
import { bindZoom } from "./zoom.js";

const MARGIN = 26;
const NEAR_PX = 12;
const SOURCE_PX = 16; // of the line that says whose map it is
const FLY_SCALE = 2;
const FLY_MS = 350;

/** The map: everything where it is at the clock's time. */
export class MapView {
  constructor(state, clock) {
    this.state = state;
    this.clock = clock;
    this.canvas = byId("map");
    this.tip = byId("map-tip");
    this.chosen = null; // what the user looks at; null: what is there
    this.sprites = new Sprites();
    this.fitLegend = makeLegend(byId("map-legend"));
    this.draw = oncePerFrame(() => this.#draw());
    this.drops = null; // what becomes of an agent that is dropped: drops(agent, goal, place); null: agents cannot be dragged
    bindDrag(this.canvas, { grab: (event) => this.#grab(event), moved: (drag) => this.#drag(drag), dropped: (agent, event) => this.#drop(agent, event) });
    bindZoom(this.canvas, () => this.view, (view) => this.#look(view));
    this.canvas.addEventListener("pointermove", (event) => this.#hover(event));
    this.canvas.addEventListener("pointerleave", () => {
      this.tip.hidden = true;
      byId("map-cursor").textContent = "";
    });
    this.canvas.addEventListener("click", (event) => this.#click(event));
    this.canvas.addEventListener("dblclick", () => this.reset());
    clock.subscribe(this.draw);
    state.on("fly", () => this.#fly());
    state.on("theme", () => this.sprites.clear());
    state.on("run data selection classes theme trails differ layers", this.draw);
    state.on("run data", () => this.#showSource());
    document.addEventListener("basemap", this.draw);
    new ResizeObserver(this.draw).observe(this.canvas);
  }

  reset() {
    this.#look(null);
  }

  /** What is at scale 1, with the whole area in view, at x is at left + k x; y alike with top. */
  get view() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    return this.chosen ?? homeView(this.state.run, { ...this.#whole(width, height), width, height, margin: MARGIN });
  }

  set view(view) {
    this.chosen = view;
  }

  /** Says on the map whose map it is: licences want that. */
  #showSource() {
    const source = this.state.run.baseMap?.info.source ?? "";
    byId("map-source").hidden = !source;
    byId("map-source").textContent = source;
  }

  #look(view) {
    this.gliding = null;
    this.view = view;
    this.draw();
  }

  /** Takes what is selected to the middle, near enough to tell it from its neighbours. */
  #fly() {
    const { run, selected } = this.state;
    this.goTo(selected && placeOf(run, selected, this.clock.t));
  }

  /** The same with a place in metres. */
  goTo(place) {
    const { run } = this.state;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!place || width === 0) return;
    const { view } = this;
    const { x, y } = this.#scales(width, height, view);
    const k = Math.max(view.k, FLY_SCALE);
    const at = (scale, from, offset) => (scale(from) - offset) / view.k; // at scale 1
    const { width_m: w, height_m: h } = run.scenario;
    // The area's border comes no further in than the map's, where the area is larger than the map.
    const within = (middle, low, high, room) => ((high - low) * k > room
      ? Math.min(MARGIN - k * low, Math.max(room - MARGIN - k * high, middle)) : (room - k * (low + high)) / 2);
    const left = within(width / 2 - k * at(x, place.x, view.left), at(x, 0, view.left), at(x, w, view.left), width);
    const top = within(height / 2 - k * at(y, place.y, view.top), at(y, h, view.top), at(y, 0, view.top), height);
    const to = { k, left, top };
    const inView = x(place.x) > 0.15 * width && x(place.x) < 0.85 * width && y(place.y) > 0.15 * height && y(place.y) < 0.85 * height;
    if (inView && view.k >= FLY_SCALE) return;
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) this.#look(to);
    else this.#glide(view, to, performance.now());
  }

  #glide(from, to, since) {
    this.gliding = to;
    const step = (now) => {
      if (this.gliding !== to) return;
      const share = Math.min(1, Math.max(0, now - since) / FLY_MS);
      const ease = share * (2 - share);
      const mix = (key) => from[key] + ease * (to[key] - from[key]);
      this.view = share === 1 ? to : { k: mix("k"), left: mix("left"), top: mix("top") };
      this.draw();
      if (share < 1) requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  /** Metres to pixels, with the whole area in view. */
  #whole(width, height) {
    const { width_m: w, height_m: h } = this.state.run.scenario;
    const perMetre = Math.min((width - 2 * MARGIN) / w, (height - 2 * MARGIN) / h);
    const left = (width - w * perMetre) / 2;
    const bottom = (height + h * perMetre) / 2;
    return { x: linear([0, w], [left, left + w * perMetre]), y: linear([0, h], [bottom, bottom - h * perMetre]), perMetre };
  }

  /** The same in `view`. */
  #scales(width, height, view) {
    const { width_m: w, height_m: h } = this.state.run.scenario;
    const { x, y, perMetre } = this.#whole(width, height);
    const within = (scale, ends, offset) => linear(ends, ends.map((m) => offset + view.k * scale(m)));
    return { x: within(x, [0, w], view.left), y: within(y, [0, h], view.top), perMetre: perMetre * view.k };
  }

  #visible(agent) {
    return this.state.classes[agent.kind];
  }

  #draw() {
    const { run } = this.state;
    const { context: c, width, height } = fit(this.canvas);
    if (!run || width === 0) return;
    const t = this.clock.t;
    const { view } = this;
    const { x, y, perMetre } = this.#scales(width, height, view);
    const crowd = run.agents.filter(({ vacant }) => !vacant).length + run.tasks.filter(({ vacant }) => !vacant).length;
    const size = Math.max(2.2, Math.min(6, 90 / Math.sqrt(crowd))) * Math.min(2, Math.max(1, view.k ** 0.35));
    const r = Math.round(size * 5) / 5;
    if (r !== this.radius) this.sprites.clear();
    this.radius = r;
    const room = run.baseMap?.info.source ? height - SOURCE_PX : height;
    this.shown = { run, state: this.state, t, x, y, r, width, height, perMetre, k: view.k, frame: frameOf({ x, y, width, height: room }, run.scenario),
      sprites: this.sprites, place: this.marked, area: this.area, drag: this.dragged, inView: (px, py) => this.#inView(px, py) };
    this.#gather(x, y, t);
    const { near, drawn, sites, cells } = this;
    // A city's ways are drawn of those in view alone.
    Object.assign(this.shown, { near, sites, cells, ways: drawn.length > MOST_SYMBOLS ? near : drawn });
    for (const layer of LAYERS) {
      if (!this.state.off.has(layer.id) && (!layer.shows || layer.shows(this.shown))) layer.draw(c, this.shown);
    }
  }

  /** Finds who and what is in view, in `drawn` and `sites`; where they are too many for symbols of their own, `cells`. */
  #gather(x, y, t) {
    const { run } = this.state;
    this.drawn = []; // who is not in view may have a way that is
    this.near = [];
    for (const agent of run.agents) {
      if (!this.#visible(agent)) continue;
      const status = statusAt(agent, t);
      if (status === OFFLINE) continue;
      const place = placeAt(agent, t);
      if (!place) continue;
      const one = { agent, status, place, px: x(place.x), py: y(place.y) };
      this.drawn.push(one);
      if (this.#inView(one.px, one.py)) this.near.push(one);
    }
    this.sites = [];
    for (const task of run.tasks) {
      const px = x(task.x);
      const py = y(task.y);
      const status = taskStatusAt(task, t);
      if (status !== UNREPORTED && !this.state.off.has("tasks") && this.#inView(px, py)) this.sites.push({ task, status, px, py });
    }
    const crowd = this.near.length + this.sites.length > MOST_SYMBOLS;
    this.cells = crowd ? countCells(this.near, this.sites, this.shown) : null;
    byId("map-crowd").hidden = !crowd;
    this.fitLegend(run);
  }

  #inView(px, py) {
    return px > -20 && py > -20 && px < this.shown.width + 20 && py < this.shown.height + 20;
  }

  /**
   * Takes the next clicks as places, told to `taken({ x, y })` in metres; null: clicks select again. `left()`: somebody else takes
   * them from then on, or nobody.
   */
  pick(taken, left = null) {
    const before = this.left;
    this.left = left;
    this.picking = taken;
    before?.();
    this.canvas.classList.toggle("picking", taken !== null);
  }

  /** Marks a place, or the corners of an area, that is being asked about; null: none. */
  mark(place, area = null) {
    this.marked = place;
    this.area = area;
    this.draw();
  }

  #grab(event) {
    const found = this.drops && !this.picking && !this.cells ? this.#find(event) : null;
    return found?.type === "agent" ? this.state.run.agents[found.index] : null;
  }

  #drag(drag) {
    if (drag) {
      const { offsetX, offsetY } = drag.event;
      const goal = this.#goal(drag.agent, drag.event);
      this.dragged = { agent: drag.agent, to: [goal?.px ?? offsetX, goal?.py ?? offsetY] };
      this.#say(goal ? `${drag.agent.label} to ${describe(this.state.run, goal.what, this.clock.t)}` : `${drag.agent.label} goes here`, offsetX, offsetY);
    } else {
      this.dragged = null;
      this.tip.hidden = true;
    }
    this.draw();
  }

  #drop(agent, event) {
    if (!this.drops || !this.#inView(event.offsetX, event.offsetY)) return;
    const { x, y } = this.shown;
    this.drops(agent, this.#goal(agent, event)?.what ?? null, { x: x.invert(event.offsetX), y: y.invert(event.offsetY) });
  }

  /** The task or, for UAVs, the charging point that an agent is dragged to: { what, px, py }; null: a place. */
  #goal({ kind }, event) {
    const { x, y } = this.shown;
    const goals = [...(kind === VEHICLE ? [] : this.sites.map(({ task, px, py }) => ({ what: { type: "task", id: task.id }, px, py }))),
      ...(kind === UAV ? this.state.run.charging.map((point) => ({ what: { type: "charge", id: point.id }, px: x(point.x), py: y(point.y) })) : [])];
    const far = ({ px, py }) => Math.hypot(px - event.offsetX, py - event.offsetY);
    const nearest = goals.reduce((best, goal) => (!best || far(goal) < far(best) ? goal : best), null);
    return nearest && far(nearest) < NEAR_PX ? nearest : null;
  }

  #click(event) {
    if (this.picking && this.shown) this.picking({ x: this.shown.x.invert(event.offsetX), y: this.shown.y.invert(event.offsetY) });
    else this.state.select(this.#find(event));
  }

  /** What is nearest to the pointer, agents first; null when nothing is near. */
  #find(event) {
    if (!this.shown) return null;
    const { run } = this.state;
    const { x, y } = this.shown;
    let best = null;
    let nearest = NEAR_PX ** 2;
    const look = (px, py, found) => {
      const d = (px - event.offsetX) ** 2 + (py - event.offsetY) ** 2;
      if (d < nearest) {
        nearest = d;
        best = found;
      }
    };
    for (const { agent, px, py } of this.near) look(px, py, { type: "agent", index: agent.index });
    if (best) return best;
    for (const { task, px, py } of this.sites) look(px, py, { type: "task", id: task.id });
    for (const point of run.charging) look(x(point.x), y(point.y), { type: "charge", id: point.id });
    return best;
  }

  #hover(event) {
    const found = this.cells ? null : this.#find(event);
    const words = found ? describe(this.state.run, found, this.clock.t) : this.cells ? cellWords(this.cells, event.offsetX, event.offsetY) : "";
    this.canvas.style.cursor = this.picking ? "crosshair" : found || words ? "pointer" : "grab";
    if (this.shown) byId("map-cursor").textContent = placeWords(this.state.run, { x: this.shown.x.invert(event.offsetX), y: this.shown.y.invert(event.offsetY) });
    this.#say(words, event.offsetX, event.offsetY);
  }

  /** Words beside the pointer; "": none. */
  #say(words, x, y) {
    this.tip.hidden = !words;
    if (!words) return;
    this.tip.textContent = words;
    const left = Math.min(x + 14, this.shown.width - this.tip.offsetWidth - 6);
    this.tip.style.transform = `translate(${Math.max(4, left)}px, ${Math.max(4, y - 34)}px)`;
  }
}
