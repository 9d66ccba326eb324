import { fit, oncePerFrame } from "./canvas.js";
import { ClusterKeys } from "./cluster_keys.js";
import { agentsWithRoom, apart, clusterWords, levelOf, roomIn } from "./clusters.js";
import { describe } from "./describe.js";
import { byId } from "./dom.js";
import { bindDrag } from "./drag.js";
import { ALL_FREE, freePart } from "./free_part.js";
import { homeView, wholeView } from "./home_view.js";
import { say } from "./language.js";
import { badgeOf } from "./layers/clusters.js";
import { BELOW, STILL } from "./layers/below.js";
import { LAYERS, PRESENT, makeLegend } from "./layers/index.js";
import { placeOf } from "./layers/selected.js";
import { placeWords } from "./place.js";
import { Present, selectedOf } from "./present.js";
import { frameOf, linear } from "./scale.js";
import { Sprites } from "./sprites.js";
import { Still } from "./still.js";
import { UAV, VEHICLE } from "./words.js";
import { MOST, bindZoom } from "./zoom.js";

const MARGIN = 26;
const NEAR_PX = 12;
const SOURCE_PX = 16; // of the line that says whose map it is
const FLY_SCALE = 2;
const FLY_MS = 350;
const EDGE_PX = 20; // a symbol whose middle is so far outside is still seen
const MOST_WAYS = 4000; // of more agents, the ways of those in view alone are drawn
const AROUND = 1.3; // what a click on a cluster shows: the cluster, and some more

const moved = (scale, by) => Object.assign((value) => scale(value) + by, { invert: (place) => scale.invert(place - by) });

/** A map that is larger by so many pixels on each side. */
const widened = (map, wide, high) => ({ ...map, x: moved(map.x, wide), y: moved(map.y, high), width: map.width + 2 * wide, height: map.height + 2 * high });

/** The map: everything where it is at the clock's time. */
export class MapView {
  constructor(state, clock) {
    this.state = state;
    this.clock = clock;
    this.canvas = byId("map");
    this.tip = byId("map-tip");
    this.chosen = null; // what the user looks at; null: what is there
    this.paper = matchMedia("print"); // a sheet shows what is there
    this.whole = false; // with nothing chosen: all of the area instead
    this.free = ALL_FREE; // how many pixels at each side are covered by what floats on the map
    this.present = new Present(state);
    this.sprites = new Sprites();
    this.stills = { ground: new Still(), present: new Still() };
    this.changes = 0; // of anything but the view
    this.clusters = [];
    this.pointed = null; // the key of the cluster that the keyboard is at
    this.keys = new ClusterKeys(this);
    this.fitLegend = makeLegend(byId("map-legend"));
    this.move = oncePerFrame(() => this.#draw()); // the same from another view
    this.draw = () => {
      ++this.changes;
      this.move();
    };
    this.drops = null; // what becomes of an agent that is dropped: drops(agent, goal, place); null: agents cannot be dragged
    bindDrag(this.canvas, { grab: (event) => this.#grab(event), moved: (drag) => this.#drag(drag), dropped: (agent, event) => this.#drop(agent, event) });
    this.isHeld = bindZoom(this.canvas, () => this.view, (view) => this.#look(view));
    this.canvas.addEventListener("pointermove", (event) => this.#hover(event));
    this.canvas.addEventListener("pointerleave", () => {
      this.tip.hidden = true;
      byId("map-cursor").textContent = "";
    });
    this.canvas.addEventListener("click", (event) => this.#click(event));
    this.canvas.addEventListener("dblclick", () => this.home());
    clock.subscribe(this.draw);
    state.on("fly", () => this.#fly());
    state.on("theme", () => this.sprites.clear());
    state.on("run data theme", () => this.stills.ground.clear());
    state.on("run data selection classes theme trails differ layers rival", this.draw);
    state.on("run data", () => this.#showSource());
    document.addEventListener("basemap", () => {
      this.stills.ground.clear();
      this.draw();
    });
    state.on("fold wall", () => this.#measure());
    this.paper.addEventListener("change", () => this.#measure());
    const sizes = new ResizeObserver(() => this.#measure());
    for (const id of ["map", "map-tools", "legend-box", "side"]) sizes.observe(byId(id));
  }

  /** What is there; where the map shows that already, all of the area, and the other way. */
  reset() {
    const whole = this.chosen === null && !this.whole;
    this.home();
    this.whole = whole;
  }

  /** What is there. */
  home() {
    this.whole = false;
    this.#look(null);
  }

  /** Looks how much of the map is covered. */
  #measure() {
    const free = freePart(this.state);
    if (!free) return;
    this.free = free;
    this.draw();
  }

  /** What is at scale 1, with the whole area in view, at x is at left + k x; y alike with top. */
  get view() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (this.chosen && !this.paper.matches) return this.chosen;
    const map = { ...this.#whole(width, height), width, height, margin: MARGIN, free: this.free };
    return this.whole ? wholeView(this.state.run, map) : homeView(this.state.run, map);
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
    this.move();
  }

  /** Takes what is selected to the middle, near enough to tell it from its neighbours. */
  #fly() {
    const { run, selected } = this.state;
    this.goTo(selected && placeOf(run, selected, this.clock.t));
  }

  /** The same with a place in metres, to zoom `k` where that is given. */
  goTo(place, zoom = null) {
    const { run } = this.state;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!place || width === 0) return;
    const { view } = this;
    const { x, y } = this.#scales(width, height, view);
    const k = zoom ?? Math.max(view.k, FLY_SCALE);
    const at = (scale, from, offset) => (scale(from) - offset) / view.k; // at scale 1
    const { width_m: w, height_m: h } = run.scenario;
    const { free } = this;
    const [across, down] = [[free.left, width - free.right], [free.top, height - free.bottom]];
    // The area's border comes no further in than that of the map's free part, where the area is larger than that.
    const within = ([from, to], there, low, high) => ((high - low) * k > to - from
      ? Math.min(from + MARGIN - k * low, Math.max(to - MARGIN - k * high, (from + to) / 2 - k * there)) : (from + to - k * (low + high)) / 2);
    const left = within(across, at(x, place.x, view.left), at(x, 0, view.left), at(x, w, view.left));
    const top = within(down, at(y, place.y, view.top), at(y, h, view.top), at(y, 0, view.top));
    const to = { k, left, top };
    const isInside = (px, [from, until]) => px > from + 0.15 * (until - from) && px < until - 0.15 * (until - from);
    const inView = isInside(x(place.x), across) && isInside(y(place.y), down);
    if (zoom === null && inView && view.k >= FLY_SCALE) return;
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
      this.move();
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

  #draw() {
    const { run } = this.state;
    const { context: c, width, height } = fit(this.canvas);
    if (!run || width === 0) return;
    const t = this.clock.t;
    const { view } = this;
    const { x, y, perMetre } = this.#scales(width, height, view);
    const crowd = run.agents.filter(({ vacant }) => !vacant).length + run.tasks.filter(({ vacant }) => !vacant).length;
    const size = Math.max(3.4, Math.min(6, 100 / Math.sqrt(crowd))) * Math.min(1.4, Math.max(1, view.k ** 0.2));
    const r = Math.round(size * 5) / 5;
    if (r !== this.radius) this.sprites.clear();
    this.radius = r;
    const { free } = this;
    const room = run.baseMap?.info.source ? height - SOURCE_PX : height;
    const frame = frameOf({ x, y, width: width - free.right, height: room - free.bottom, left: free.left, top: free.top }, run.scenario);
    this.shown = { run, state: this.state, t, x, y, r, width, height, perMetre, k: view.k, free, frame,
      sprites: this.sprites, place: this.marked, area: this.area, drag: this.dragged, inView: (px, py) => this.#inView(px, py) };
    const began = performance.now();
    if (this.present.look(t)) this.fitLegend(run, { t, extra: this.state.extra, rival: this.state.rivalRun });
    Object.assign(this.shown, this.#within(0, 0), { pointed: this.pointed });
    Object.assign(this, { near: this.shown.near, sites: this.shown.sites, points: this.shown.points, clusters: this.shown.clusters });
    byId("map-crowd").hidden = this.clusters.length === 0;
    const gathered = performance.now();
    this.#paint(c);
    this.took = { data: gathered - began, draw: performance.now() - gathered };
    this.keys.follow();
  }

  #paint(c) {
    const { shown, state, stills: { ground, present } } = this;
    const { perMetre, r, width, height } = shown;
    const layers = LAYERS.filter((layer) => state.showsLayer(layer) && (!layer.shows || layer.shows(shown)));
    const draw = (list, context, map = shown) => list.forEach((layer) => layer.draw(context, map));
    const still = layers.filter((layer) => STILL.includes(layer));
    const key = [perMetre, r, width, height, window.devicePixelRatio].join();
    if (still.length > 1) ground.draw(c, shown, `${key} ${still.map(({ id }) => id)}`, (on, wide, high) => draw(still, on, widened(shown, wide, high)));
    else draw(still, c); // the ground alone
    draw(layers.filter((layer) => BELOW.includes(layer) && !still.includes(layer)), c);
    present.draw(c, shown, `${key} ${this.changes}`, (on, wide, high) => {
      on.save();
      on.translate(wide, high);
      draw(layers.filter((layer) => PRESENT.includes(layer)), on, { ...shown, ...this.#around(wide, high) });
      on.restore();
    });
    draw(layers.filter((layer) => !BELOW.includes(layer) && !PRESENT.includes(layer)), c);
  }

  /** The squares in view or at most so many pixels outside: { all, squares (those), room (for symbols in each), edges, box (in metres) }. */
  #squaresWithin(wide, high) {
    const { x, y, width, height, perMetre } = this.shown;
    const level = levelOf(perMetre);
    const all = this.present.squares(level);
    const edges = { left: -EDGE_PX - wide, right: width + EDGE_PX + wide, top: -EDGE_PX - high, bottom: height + EDGE_PX + high };
    const box = { west: x.invert(edges.left), east: x.invert(edges.right), south: y.invert(edges.bottom), north: y.invert(edges.top) };
    return { all, squares: all.within(box), room: roomIn(level, perMetre), edges, box };
  }

  /** Gives an item its place on the screen. */
  #put(item) {
    return Object.assign(item, { px: this.shown.x(item.x), py: this.shown.y(item.y) });
  }

  /** What is drawn with the view and so many pixels around it: #within, the agents whose `ways` are seen, and the `edges`. */
  #around(wide, high) {
    return { ...this.#within(wide, high), ways: this.#waysWithin(wide, high), edges: this.#squaresWithin(wide, high).edges };
  }

  /** What is there: agents as `near`, tasks as `sites`, charging `points`, and `clusters` of those that have no room. */
  #within(wide, high) {
    const { all, squares, room, edges: { left, right, top, bottom } } = this.#squaresWithin(wide, high);
    const seen = squares.flatMap((square) => apart(square, room)).map((item) => this.#put(item))
      .filter(({ px, py }) => px > left && py > top && px < right && py < bottom);
    return { near: seen.filter(({ agent }) => agent), sites: seen.filter(({ task }) => task), points: seen.filter(({ point }) => point),
      clusters: squares.filter(({ crowd }) => crowd.length > room).map((square) => all.clusterOf(square)) };
  }

  /** Whose ways are drawn: those that have room. Who is not there may have a way that is. */
  #waysWithin(wide, high) {
    const { all, squares, room, box } = this.#squaresWithin(wide, high);
    const roomy = this.present.agents > MOST_WAYS ? agentsWithRoom(squares, room) : all.roomyAgents(room);
    return roomy.filter((item) => this.present.wayMeets(item, box)).map((item) => this.#put(item));
  }

  #inView(px, py) {
    return px > -EDGE_PX && py > -EDGE_PX && px < this.shown.width + EDGE_PX && py < this.shown.height + EDGE_PX;
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
    const found = this.drops && !this.picking ? this.#find(event) : null;
    return found?.type === "agent" ? this.state.run.agents[found.index] : null;
  }

  #drag(drag) {
    if (drag) {
      const { offsetX, offsetY } = drag.event;
      const goal = this.#goal(drag.agent, drag.event);
      this.dragged = { agent: drag.agent, to: [goal?.px ?? offsetX, goal?.py ?? offsetY] };
      this.#say(say(goal ? "{agent} to {goal}" : "{agent} goes here", {
        agent: drag.agent.label, goal: goal && describe(this.state.run, goal.what, this.clock.t) }), offsetX, offsetY);
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
    else if (!this.#enterAt(event)) this.state.select(this.#find(event), event.shiftKey);
  }

  /** Enters the cluster at the pointer, unless a symbol is over it; whether there is one. */
  #enterAt(event) {
    const cluster = this.#find(event) ? null : this.#clusterAt(event);
    if (cluster) this.enter(cluster);
    return cluster !== null;
  }

  /** Takes the map to a cluster, so near that it parts. Where the map cannot go nearer, its members are selected in turn. */
  enter({ box, items }) {
    const { width, height, perMetre } = this.shown;
    const { k } = this.view;
    const place = { x: (box.west + box.east) / 2, y: (box.south + box.north) / 2 };
    const fits = Math.min((width - this.free.left) / (AROUND * (box.east - box.west)), height / (AROUND * (box.north - box.south))) / perMetre;
    if (k < MOST) return this.goTo(place, Math.min(MOST, k * Math.max(2, fits)));
    return this.state.select(selectedOf(this.present.after(items)));
  }

  /** What is nearest to the pointer, agents first; null when nothing is near. */
  #find(event) {
    if (!this.shown) return null;
    const far = ({ px, py }) => Math.hypot(px - event.offsetX, py - event.offsetY);
    const nearest = (items) => items.reduce((best, item) => (far(item) < (best ? far(best) : NEAR_PX) ? item : best), null);
    const found = nearest(this.near) ?? nearest([...this.sites, ...this.points]);
    return found && selectedOf(found);
  }

  /** The clusters in view with their badges: { cluster, left, top, wide, high }. */
  badges() {
    return this.clusters.map((cluster) => ({ cluster, ...badgeOf(cluster, this.shown) }));
  }

  /** The cluster whose badge is at the pointer; null: none is. */
  #clusterAt({ offsetX, offsetY }) {
    return this.badges().find(({ left, top, wide, high }) =>
      offsetX >= left && offsetX <= left + wide && offsetY >= top && offsetY <= top + high)?.cluster ?? null;
  }

  #hover(event) {
    if (!this.shown) return;
    if (this.isHeld()) { // the map goes with the pointer: what is below it stays the same
      this.tip.hidden = true;
      return;
    }
    const found = this.#find(event);
    const cluster = found ? null : this.#clusterAt(event);
    const words = found ? describe(this.state.run, found, this.clock.t) : cluster ? clusterWords(cluster) : "";
    this.canvas.style.cursor = this.picking ? "crosshair" : words ? "pointer" : "grab";
    byId("map-cursor").textContent = placeWords(this.state.run, { x: this.shown.x.invert(event.offsetX), y: this.shown.y.invert(event.offsetY) });
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
