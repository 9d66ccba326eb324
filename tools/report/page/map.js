import { agentShape, cross, fit, oncePerFrame } from "./canvas.js";
import { coastOf } from "./coast.js";
import { differencesAt } from "./differences.js";
import { describe } from "./describe.js";
import { byId } from "./dom.js";
import { placeAt, statusAt, taskStatusAt } from "./run.js";
import { nameOf } from "./link.js";
import { MOST_SYMBOLS, cellWords, countCells, drawCells } from "./map_crowd.js";
import { drawDegrees, drawGrid, drawGround, drawScale, frameOf, scaleBoxes } from "./map_frame.js";
import { drawLabels } from "./map_labels.js";
import { placeWords } from "./place.js";
import { linear } from "./scale.js";
import { Sprites } from "./sprites.js";
import { rowAt } from "./time.js";
import { theme } from "./theme.js";
import { BEING_SENSED, CANCELLED, DONE, EXPIRED, FAILED, HELD, IDLE, MOVING, OFFLINE, RESERVED, UAV, UNREPORTED, WAITING } from "./words.js";
import { WHOLE, bindZoom } from "./zoom.js";

const MARGIN = 26;
const NEAR_PX = 12;
const LABEL_PX = 6000; // of the map for each name
const FLY_SCALE = 2;
const FLY_MS = 350;

/** Where what is selected is at t; null when that is not known. */
function placeOf(run, selected, t) {
  if (selected.type === "agent") return placeAt(run.agents[selected.index], t);
  return (selected.type === "task" ? run.tasks : run.charging)[selected.id] ?? null;
}

/** The map: everything where it is at the clock's time. */
export class MapView {
  constructor(state, clock) {
    this.state = state;
    this.clock = clock;
    this.canvas = byId("map");
    this.tip = byId("map-tip");
    this.view = WHOLE;
    this.sprites = new Sprites();
    this.draw = oncePerFrame(() => this.#draw());
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
    state.on("run data selection classes theme trails differ", this.draw);
    new ResizeObserver(this.draw).observe(this.canvas);
  }

  reset() {
    this.#look(WHOLE);
  }

  #look(view) {
    this.gliding = null;
    this.view = view;
    this.draw();
  }

  /** Takes what is selected to the middle, near enough to tell it from its neighbours. */
  #fly() {
    const { run, selected } = this.state;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const place = selected && placeOf(run, selected, this.clock.t);
    if (!place || width === 0) return;
    const { x, y } = this.#scales(width, height);
    const { view } = this;
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

  /** Metres to pixels, with the whole area in view at scale 1. */
  #scales(width, height) {
    const { width_m: w, height_m: h } = this.state.run.scenario;
    const perMetre = Math.min((width - 2 * MARGIN) / w, (height - 2 * MARGIN) / h);
    const left = (width - w * perMetre) / 2;
    const bottom = (height + h * perMetre) / 2;
    const { k, left: viewLeft, top: viewTop } = this.view;
    const x = linear([0, w], [viewLeft + k * left, viewLeft + k * (left + w * perMetre)]);
    const y = linear([0, h], [viewTop + k * bottom, viewTop + k * (bottom - h * perMetre)]);
    return { x, y, perMetre: perMetre * k };
  }

  #visible(agent) {
    return this.state.classes[agent.kind];
  }

  #draw() {
    const { run } = this.state;
    const { context: c, width, height } = fit(this.canvas);
    if (!run || width === 0) return;
    const t = this.clock.t;
    const { x, y, perMetre } = this.#scales(width, height);
    this.shown = { x, y, width, height };
    drawGround(c, run, this.shown);
    drawGrid(c, run, this.shown);
    const frame = frameOf(this.shown, run.scenario);
    Object.assign(this.shown, { perMetre, frame });
    drawDegrees(c, run, this.shown, frame);
    const crowd = run.agents.length + run.tasks.length;
    const size = Math.max(2.2, Math.min(6, 90 / Math.sqrt(crowd))) * Math.min(2, Math.max(1, this.view.k ** 0.35));
    const r = Math.round(size * 5) / 5;
    if (r !== this.radius) this.sprites.clear();
    this.radius = r;
    this.#gather(x, y, t);
    if (this.cells) drawCells(c, this.cells);
    else {
      this.#drawTrails(c, x, y, t);
      this.#drawSites(c, x, y, r);
      this.#drawAgents(c, x, y, r);
    }
    this.#drawDifferences(c, x, y, t, r);
    this.#drawSelected(c, x, y, t, r);
    this.#drawLabels(c, x, y, t, r);
    this.#drawMarked(c, x, y, r);
    drawScale(c, perMetre, frame);
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
      if (status !== UNREPORTED && this.#inView(px, py)) this.sites.push({ task, status, px, py });
    }
    const crowd = this.near.length + this.sites.length > MOST_SYMBOLS;
    this.cells = crowd ? countCells(this.near, this.sites, this.shown) : null;
    byId("map-crowd").hidden = !crowd;
    byId("legend-expired").hidden = !run.timed;
    for (const name of ["held", "cancelled"]) byId(`legend-${name}`).hidden = !run.hasOrders;
    byId("legend-water").hidden = !coastOf(run)?.water;
    byId("coast-source").textContent = `water (${run.coast?.source})`;
  }

  #drawTrails(c, x, y, t) {
    const { trailMs } = this.state;
    if (trailMs === 0) return;
    const from = t - trailMs;
    c.lineWidth = 1.3;
    c.globalAlpha = this.state.run.agents.length > 500 ? 0.3 : 0.5;
    for (let kind = 0; kind < 3; ++kind) {
      if (!this.state.classes[kind]) continue;
      c.strokeStyle = theme.kinds[kind];
      c.beginPath();
      for (const { agent } of this.#ways()) if (agent.kind === kind) this.#trail(c, x, y, agent, from, t);
      c.stroke();
    }
    c.globalAlpha = 1;
  }

  /** Whose ways are drawn: all, or in a city those in view. */
  #ways() {
    return this.drawn.length > MOST_SYMBOLS ? this.near : this.drawn;
  }

  #trail(c, x, y, agent, from, t) {
    const { stops } = agent;
    const start = placeAt(agent, Math.max(from, stops[0] ?? 0));
    const now = placeAt(agent, t);
    if (!start) return;
    c.moveTo(x(start.x), y(start.y));
    for (let i = (rowAt(stops, 4, from) + 1) * 4; i < stops.length && stops[i] < t; i += 4) {
      c.lineTo(x(stops[i + 1]), y(stops[i + 2]));
    }
    c.lineTo(x(now.x), y(now.y));
  }

  #drawSites(c, x, y, r) {
    const { run } = this.state;
    for (const point of run.charging) {
      const px = x(point.x);
      const py = y(point.y);
      if (this.#inView(px, py)) this.sprites.stamp(c, `charging ${r}`, r * 2 + 3, px, py, (s) => chargingPoint(s, r));
    }
    for (const { status, px, py } of [...this.sites].sort((a, b) => b.status - a.status)) {
      this.sprites.stamp(c, `task${status} ${r}`, r * 2 + 3, px, py, (s) => taskMark(s, status, r));
    }
  }

  #inView(px, py) {
    return px > -20 && py > -20 && px < this.shown.width + 20 && py < this.shown.height + 20;
  }

  #drawAgents(c, x, y, r) {
    const crowded = this.state.run.agents.length > 500;
    // where those who move are going
    if (!crowded) c.setLineDash([3, 4]);
    c.lineWidth = 1;
    c.globalAlpha = crowded ? 0.25 : 0.6;
    for (let kind = 0; kind < 3; ++kind) {
      c.strokeStyle = theme.kinds[kind];
      c.beginPath();
      for (const { agent, status, place, px, py } of this.#ways()) {
        if (agent.kind !== kind || status !== MOVING) continue;
        c.moveTo(px, py);
        c.lineTo(x(place.toX), y(place.toY));
      }
      c.stroke();
    }
    c.setLineDash([]);
    c.globalAlpha = 1;
    // vehicles lowest, UAVs on top
    for (const kind of [2, 1, 0]) {
      for (const { agent, status, place, px, py } of this.near) {
        if (agent.kind !== kind) continue;
        const turn = kind === UAV ? turnOf(status, place) : 0;
        this.sprites.stamp(c, `agent ${kind} ${status} ${turn} ${r}`, r * 2.1 + 3, px, py,
          (s) => agentMark(s, kind, status, turn, r));
      }
    }
  }

  /** Who is commanded otherwise in another run: a ring, and a line to where that run sends it, in that run's colour. */
  #drawDifferences(c, x, y, t, r) {
    const { run, runs, other } = this.state;
    if (other === null) return;
    c.strokeStyle = theme.runs[other % theme.runs.length];
    c.lineWidth = 1.6;
    const there = new Map(differencesAt(run, runs[other], t).map((pair) => [pair.agent, pair.there]));
    for (const { agent, px, py } of this.#ways()) {
      if (!there.has(agent)) continue;
      c.beginPath();
      c.arc(px, py, r * 1.8, 0, 2 * Math.PI);
      c.stroke();
      const command = there.get(agent);
      if (!command) continue;
      c.beginPath();
      c.setLineDash([7, 3]);
      c.moveTo(px, py);
      c.lineTo(x(command.x), y(command.y));
      c.stroke();
      c.setLineDash([]);
    }
  }

  /** Names: of what is selected first; of agents, then tasks to do, while few enough are in view. */
  #drawLabels(c, x, y, t, r) {
    const { run, selected } = this.state;
    const labels = [];
    const put = (text, px, py, colour) => this.#inView(px, py) && labels.push({ text, px, py, gap: r + 3, colour });
    if (selected) {
      const place = placeOf(run, selected, t);
      if (place) put(nameOf(run, selected).replace(":", selected.type === "agent" ? ":" : " "), x(place.x), y(place.y), theme.text);
    }
    const room = (this.shown.width * this.shown.height) / LABEL_PX;
    const named = selected?.type === "agent" ? selected.index : -1;
    const agents = this.near.length > room + 1 ? this.near : this.near.filter(({ agent }) => agent.index !== named);
    const tasks = this.sites.filter(({ task, status }) => ![DONE, CANCELLED].includes(status) && !(selected?.type === "task" && selected.id === task.id));
    if (!this.cells && agents.length <= room) {
      for (const { agent, px, py } of agents) put(agent.label, px, py, theme.kinds[agent.kind]);
      if (this.view.k >= 1.5 && agents.length + tasks.length <= room) for (const { task, px, py } of tasks) put(`${task.id}`, px, py, theme.muted);
    }
    drawLabels(c, labels, this.shown, theme.bg, scaleBoxes(this.shown.perMetre, this.shown.frame));
  }

  #drawSelected(c, x, y, t, r) {
    const { run, selected } = this.state;
    if (!selected) return;
    let place;
    if (selected.type === "agent") {
      const agent = run.agents[selected.index];
      place = agent && placeAt(agent, t);
      if (!place) return;
      c.strokeStyle = theme.kinds[agent.kind];
      c.lineWidth = 2.2;
      c.beginPath();
      this.#trail(c, x, y, agent, 0, t);
      c.stroke();
    } else {
      place = (selected.type === "task" ? run.tasks : run.charging)[selected.id];
      if (!place) return;
    }
    c.strokeStyle = theme.cursor;
    c.lineWidth = 2;
    c.beginPath();
    c.arc(x(place.x), y(place.y), r * 2.8, 0, 2 * Math.PI);
    c.stroke();
  }

  /** Takes the next click as a place, told to `taken({ x, y })` in metres; null: clicks select again. */
  pick(taken) {
    this.picking = taken;
    this.canvas.classList.toggle("picking", taken !== null);
  }

  /** Marks a place that is being asked about; null: none. */
  mark(place) {
    this.marked = place;
    this.draw();
  }

  #click(event) {
    if (this.picking && this.shown) this.picking({ x: this.shown.x.invert(event.offsetX), y: this.shown.y.invert(event.offsetY) });
    else this.state.select(this.#find(event));
  }

  #drawMarked(c, x, y, r) {
    if (!this.marked) return;
    const [px, py] = [x(this.marked.x), y(this.marked.y)];
    c.strokeStyle = theme.accent;
    c.lineWidth = 2;
    c.beginPath();
    c.arc(px, py, r * 2, 0, 2 * Math.PI);
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      c.moveTo(px + dx * r, py + dy * r);
      c.lineTo(px + dx * r * 3, py + dy * r * 3);
    }
    c.stroke();
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
    this.tip.hidden = !words;
    if (this.shown) byId("map-cursor").textContent = placeWords(this.state.run, { x: this.shown.x.invert(event.offsetX), y: this.shown.y.invert(event.offsetY) });
    if (!words) return;
    this.tip.textContent = words;
    const left = Math.min(event.offsetX + 14, this.shown.width - this.tip.offsetWidth - 6);
    this.tip.style.transform = `translate(${Math.max(4, left)}px, ${Math.max(4, event.offsetY - 34)}px)`;
  }
}

const TURNS = 32;

/** The way that a UAV flies as one of TURNS directions; up when it stands. */
function turnOf(status, place) {
  if (status !== MOVING || (place.dx === 0 && place.dy === 0)) return TURNS / 4;
  return (Math.round((Math.atan2(place.dy, place.dx) / (2 * Math.PI)) * TURNS) + TURNS) % TURNS;
}

/** Idle ones are hollow, failed ones a cross; a ring while working, a dotted one while waiting. */
function agentMark(c, kind, status, turn, r) {
  c.beginPath();
  if (status === FAILED) {
    cross(c, 0, 0, r);
    c.strokeStyle = theme.failed;
    c.lineWidth = 2.4;
    c.stroke();
    return;
  }
  const idle = status === IDLE;
  agentShape(c, kind, 0, 0, r, (-turn * 2 * Math.PI) / TURNS);
  c.lineWidth = idle ? 1.5 : 1;
  c.fillStyle = idle ? theme.bg : theme.kinds[kind];
  c.strokeStyle = idle ? theme.kinds[kind] : theme.bg;
  c.fill();
  c.stroke();
  if (idle || status === MOVING) return;
  c.beginPath();
  c.arc(0, 0, r * 2.1, 0, 2 * Math.PI);
  c.strokeStyle = theme.status[status];
  c.lineWidth = 1.8;
  c.setLineDash(status === WAITING ? [2, 3] : []);
  c.stroke();
}

/** open: hollow; reserved: hollow with a dot; being sensed: full; done: a small tick; held: two bars; cancelled: struck through */
function taskMark(c, status, r) {
  c.beginPath();
  if (status === DONE) {
    c.moveTo(-r * 0.7, 0);
    c.lineTo(-r * 0.15, r * 0.6);
    c.lineTo(r * 0.8, -r * 0.7);
  } else if (status === EXPIRED) {
    c.moveTo(-r * 0.7, -r * 0.7);
    c.lineTo(r * 0.7, r * 0.7);
    c.moveTo(-r * 0.7, r * 0.7);
    c.lineTo(r * 0.7, -r * 0.7);
  } else {
    const size = status === BEING_SENSED ? r * 1.5 : r * 1.15;
    c.moveTo(0, -size);
    c.lineTo(size, 0);
    c.lineTo(0, size);
    c.lineTo(-size, 0);
    c.closePath();
    if (status === RESERVED) c.rect(-1, -1, 2, 2);
    for (const x of status === HELD ? [-r * 0.28, r * 0.28] : []) {
      c.moveTo(x, -r * 0.45);
      c.lineTo(x, r * 0.45);
    }
    if (status === CANCELLED) {
      c.moveTo(-size * 1.3, 0);
      c.lineTo(size * 1.3, 0);
    }
  }
  c.strokeStyle = status === DONE || status === CANCELLED ? theme.done : status === BEING_SENSED ? theme.sensing : theme.task;
  c.lineWidth = status === DONE ? 1.6 : 1.4;
  if (status === BEING_SENSED) {
    c.fillStyle = theme.sensing;
    c.fill();
  }
  c.stroke();
}

function chargingPoint(c, r) {
  c.strokeStyle = theme.charging;
  c.lineWidth = 1.4;
  c.beginPath();
  c.rect(-r, -r, 2 * r, 2 * r);
  c.moveTo(-r * 0.5, 0);
  c.lineTo(r * 0.5, 0);
  c.moveTo(0, -r * 0.5);
  c.lineTo(0, r * 0.5);
  c.stroke();
}
