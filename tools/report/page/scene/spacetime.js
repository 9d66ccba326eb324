import { Color, MeshBasicMaterial, Plane as Cut, Vector3 } from "three";
import { statusAt } from "../run.js";
import { theme } from "../theme.js";
import { CHARGES, FAILED, OFFLINE } from "../words.js";
import { Crowd } from "./crowd.js";
import { Lines } from "./lines.js";
import { SIZE } from "./plane.js";
import { barShape } from "./shapes.js";

/** How tall the whole mission is, in the scene's units. */
export const TALL = 0.62 * SIZE;
const FAINT = 0.16;

/**
 * Everybody's way through the mission with time upwards: what meets is where lines cross, and a bar as long as they stay
 * together stands there. What is later than now is faint.
 */
export class SpaceTime {
  constructor(scene) {
    // Two copies of the same, cut at the time: below it, and faint above.
    this.past = new Cut(new Vector3(0, -1, 0), 0);
    this.future = new Cut(new Vector3(0, 1, 0), 0);
    this.lines = [new Lines(scene, { clippingPlanes: [this.past], opacity: 0.75 }), new Lines(scene, { clippingPlanes: [this.future], opacity: FAINT })];
    const bar = (options) => new Crowd(scene, barShape(), new MeshBasicMaterial(options));
    this.bars = [bar({ clippingPlanes: [this.past] }), bar({ clippingPlanes: [this.future], transparent: true, opacity: 2 * FAINT, depthWrite: false })];
    this.scene = scene;
  }

  /** How high a time stands. */
  heightOf(run, t) {
    return (TALL * t) / Math.max(1, run.limitMs);
  }

  /** Builds what `run` knows; `selected` is thicker. Nothing when there is no run. */
  build(run, plane, classes, selected) {
    for (const part of [...this.lines, ...this.bars]) part.begin();
    this.meetings = 0;
    if (run) {
      for (const agent of run.agents) if (classes[agent.kind]) this.#way(run, plane, agent, selected);
      this.#meetings(run, plane);
    }
    for (const part of [...this.lines, ...this.bars]) part.end();
  }

  #way(run, plane, agent, selected) {
    const colour = new Color(theme.kinds[agent.kind]);
    const chosen = selected?.type === "agent" && selected.index === agent.index;
    const { stops } = agent;
    const point = (i, t = stops[i]) => [plane.x(stops[i + 1]), this.heightOf(run, t), plane.z(stops[i + 2])];
    const add = (a, b) => {
      for (const lines of this.lines) lines.add(...a, ...b, colour);
      if (chosen) for (const bars of this.bars) bars.lay(a, b, 0.5, colour);
    };
    for (let i = 4; i < stops.length; i += 4) if (statusAt(agent, stops[i - 4]) !== OFFLINE) add(point(i - 4), point(i));
    const last = stops.length - 4;
    if (last < 0) return;
    const ended = agent.spans.length && agent.spans.at(-1) === FAILED ? Math.max(stops[last], agent.spans.at(-2)) : run.nowMs;
    add(point(last), point(last, ended));
  }

  #meetings(run, plane) {
    const sensing = new Color(theme.sensing), charging = new Color(theme.charging);
    for (let i = 0; i < run.activities.length; i += 6) {
      const [kind, , , site, start, end] = run.activities.slice(i, i + 6);
      const at = (kind === CHARGES ? run.charging : run.tasks)[site];
      if (!at) continue;
      const [x, z] = [plane.x(at.x), plane.z(at.y)];
      for (const bars of this.bars) bars.lay([x, this.heightOf(run, start), z], [x, this.heightOf(run, end), z], 1.1, kind === CHARGES ? charging : sensing);
      ++this.meetings;
    }
  }

  /** Cuts past from future at t. */
  cut(run, t) {
    const y = this.heightOf(run, t);
    this.past.constant = y;
    this.future.constant = -y;
  }
}
