import { Color, DoubleSide, MeshBasicMaterial, MeshLambertMaterial } from "three";
import { flownBetween } from "../approaches.js";
import { placeAt, statusAt, taskStatusAt } from "../run.js";
import { theme } from "../theme.js";
import { rowAt } from "../time.js";
import { BEING_SENSED, CANCELLED, CHARGING, DONE, EXPIRED, FAILED, IDLE, MOVING, OFFLINE, RESERVED, SENSING, UAV, UNREPORTED } from "../words.js";
import { Crowd, mixed } from "./crowd.js";
import { drawnHeight } from "./heights.js";
import { Lines } from "./lines.js";
import { barShape, beamShape, chargingShape, columnShape, doneShape, failedShape, ringShape, taskShape, uavShape,
  vehicleShape, workerShape } from "./shapes.js";

const CROWDED = 500; // agents
const GROUND = 0.12; // of trails above it

const lit = () => new MeshLambertMaterial();
const plain = () => new MeshBasicMaterial({ side: DoubleSide });
const glass = () => new MeshBasicMaterial({ transparent: true, opacity: 0.34, side: DoubleSide, depthWrite: false });

/** Agents, sites, trails and what agents do, at a time. */
export class Actors {
  constructor(scene) {
    this.kinds = [uavShape(), workerShape(), vehicleShape()].map((shape, kind) =>
      new Crowd(scene, shape, kind === UAV ? new MeshLambertMaterial({ side: DoubleSide }) : lit()));
    this.failed = new Crowd(scene, failedShape(), lit());
    this.tasks = new Crowd(scene, taskShape(), lit());
    this.done = new Crowd(scene, doneShape(), plain());
    this.charging = new Crowd(scene, chargingShape(), lit());
    this.rings = new Crowd(scene, ringShape(), plain());
    this.beams = new Crowd(scene, beamShape(), glass());
    this.columns = new Crowd(scene, columnShape(), glass());
    this.bars = new Crowd(scene, barShape(), plain());
    this.trails = new Lines(scene, { opacity: 0.65 });
    this.ways = new Lines(scene, { opacity: 0.4 });
    this.all = [...this.kinds, this.failed, this.tasks, this.done, this.charging, this.rings, this.beams, this.columns, this.bars, this.trails, this.ways];
    this.readTheme();
  }

  readTheme() {
    this.colours = new Map();
    this.idle = theme.kinds.map((kind) => mixed(kind, theme.bg, 0.5));
  }

  /** A colour of the style sheet, read once. */
  colour(css) {
    if (!this.colours.has(css)) this.colours.set(css, new Color(css));
    return this.colours.get(css);
  }

  /**
   * Shows everything at t, bodies so large; UAVs fly `lift` times as high as usual, or `times` as high as their altitude. `floor`: height of the
   * ground, above which they stand; `flat`: without trails, ways and heights.
   */
  show({ run, plane, t, size, lift, times, floor, flat, trailMs, classes, selected }) {
    for (const part of this.all) part.begin();
    this.places = [];
    this.working = { sensing: 0, charging: 0 };
    this.shown = { run, plane, t, size, lift, times, unit: plane.unit, floor, flat };
    this.#sites();
    const crowded = run.agents.length > CROWDED;
    for (const agent of run.agents) {
      if (!classes[agent.kind]) continue;
      const status = statusAt(agent, t);
      const place = status === OFFLINE ? null : placeAt(agent, t);
      if (!place) continue;
      this.#agent(agent, status, place, crowded);
      if (!flat && trailMs > 0) this.#trail(agent, t - trailMs);
    }
    if (selected) this.#select(selected);
    for (const part of this.all) part.end();
    this.counts = { agents: this.places.length, ...this.working, failed: this.failed.n, done: this.done.n, trails: this.trails.places.length / 6 };
  }

  #sites() {
    const { run, plane, t, size, floor } = this.shown;
    const charging = this.colour(theme.charging);
    for (const point of run.charging) this.charging.put(plane.x(point.x), floor, plane.z(point.y), [size, size, size], 0, charging);
    const [open, sensing, done] = [theme.task, theme.sensing, theme.done].map((css) => this.colour(css));
    for (const task of run.tasks) {
      const [x, z] = [plane.x(task.x), plane.z(task.y)];
      const status = taskStatusAt(task, t);
      if ([UNREPORTED, EXPIRED, CANCELLED].includes(status)) continue;
      if (status === DONE) this.done.put(x, floor + 0.06, z, [size, size, size], 0, done);
      else {
        const s = size * (status === BEING_SENSED ? 1.1 : 0.85);
        this.tasks.put(x, floor + s, z, [s, s, s], 0, status === BEING_SENSED ? sensing : open);
        if (status === RESERVED) this.rings.put(x, floor + s, z, [s * 1.3, s, s * 1.3], 0, open);
      }
    }
  }

  #agent(agent, status, place, crowded) {
    const { run, plane, t, size, floor, flat } = this.shown;
    const [x, z] = [plane.x(place.x), plane.z(place.y)];
    const high = flat ? 0 : drawnHeight(run, agent, t, this.shown);
    const y = floor + high + (agent.kind === UAV ? 0.3 * size : 0);
    this.places.push({ agent, x, y, z });
    const turn = place.dx || place.dy ? Math.atan2(place.dy, place.dx) : Math.PI / 2;
    if (status === FAILED) {
      this.failed.put(x, floor, z, [size, size, size], 0, this.colour(theme.failed));
      return;
    }
    if (agent.kind === UAV && status === SENSING) ++this.working.sensing;
    if (agent.kind === UAV && status === CHARGING) ++this.working.charging;
    const own = this.colour(theme.kinds[agent.kind]);
    this.kinds[agent.kind].put(x, y, z, [size, size, size], turn, status === IDLE ? this.idle[agent.kind] : own);
    if (status !== IDLE && status !== MOVING) this.rings.put(x, y + 0.2 * size, z, [size * 1.9, size * 1.9, size * 1.9], 0, this.colour(theme.status[status]));
    if (agent.kind === UAV && !flat) {
      if (status === SENSING) this.beams.put(x, floor, z, [size * 2.4, Math.max(0.1, high), size * 2.4], 0, this.colour(theme.sensing));
      else if (high > 0.2 && !crowded) this.ways.add(x, floor, z, x, y, z, own);
    }
    if (status === CHARGING && agent.kind === UAV) this.columns.put(x, floor, z, [size * 1.5, size * 5, size * 1.5], 0, this.colour(theme.charging));
    if (status === MOVING && !flat) this.#way(agent, { x, y, z }, place, own);
  }

  /** Where one that moves goes to, at its altitude. */
  #way(agent, { x, y, z }, place, own) {
    const { run, plane, t, times } = this.shown;
    const ends = agent.stops[(rowAt(agent.stops, 4, t) + 1) * 4];
    if (agent.kind !== UAV || times === null || ends === undefined) this.ways.add(x, y, z, plane.x(place.toX), y, plane.z(place.toY), own);
    else for (const [from, to] of this.#flown(run, agent, t, ends)) this.ways.add(...from, ...to, own);
  }

  /** Lines of what a UAV flies between two times, at its altitude: [[x, y, z], [x, y, z]]. */
  #flown(run, agent, from, to) {
    const { plane, times, unit, floor } = this.shown;
    const point = (x, y, up) => [plane.x(x), floor + GROUND + times * unit * up, plane.z(y)];
    return flownBetween(run, agent, from, to).map((piece) => [point(piece.x, piece.y, piece.up), point(piece.toX, piece.toY, piece.toUp)]);
  }

  /** Lines of an agent's way from a time until now: [[x, y, z], [x, y, z]]. */
  #path(agent, from) {
    const { run, t, times } = this.shown;
    if (agent.kind === UAV && times !== null) return this.#flown(run, agent, from, t);
    const places = this.#places(agent, from);
    return places.slice(1).map((place, i) => [places[i], place]);
  }

  #places(agent, from) {
    const { run, plane, t, floor } = this.shown;
    const { stops } = agent;
    const path = [];
    const add = (place, at) => path.push([plane.x(place.x), floor + GROUND + drawnHeight(run, agent, at, this.shown), plane.z(place.y)]);
    const begin = Math.max(from, stops[0] ?? 0);
    if (begin > t || stops.length === 0) return path;
    add(placeAt(agent, begin), begin);
    for (let i = (rowAt(stops, 4, begin) + 1) * 4; i < stops.length && stops[i] < t; i += 4) add({ x: stops[i + 1], y: stops[i + 2] }, stops[i]);
    add(placeAt(agent, t), t);
    return path;
  }

  #trail(agent, from) {
    const colour = this.colour(theme.kinds[agent.kind]);
    for (const [a, b] of this.#path(agent, from)) this.trails.add(...a, ...b, colour);
  }

  #select(selected) {
    const { run, plane, size, floor, flat } = this.shown;
    const cursor = this.colour(theme.cursor);
    let at;
    if (selected.type === "agent") {
      const agent = run.agents[selected.index];
      at = this.places.find((place) => place.agent === agent);
      if (at && !flat) for (const [a, b] of this.#path(agent, 0)) this.bars.lay(a, b, size * 0.28, this.colour(theme.kinds[agent.kind]));
    } else {
      const site = (selected.type === "task" ? run.tasks : run.charging)[selected.id];
      if (site) at = { x: plane.x(site.x), y: floor, z: plane.z(site.y) };
    }
    if (!at) return;
    this.rings.put(at.x, floor + 0.1, at.z, [size * 3, size * 3, size * 3], 0, cursor);
    if (at.y > floor + 0.2) this.bars.lay([at.x, floor, at.z], [at.x, at.y, at.z], size * 0.12, cursor);
  }
}
