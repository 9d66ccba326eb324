import { MeshLambertMaterial } from "three";
import { theme } from "../theme.js";
import { Crowd, mixed } from "./crowd.js";
import { blockShape } from "./shapes.js";

const STREET = 2.6; // from block to block, in the scene's units
const CENTRES = 5;
const CLEAR = 1.5; // around a task or a charging point

/** Numbers from 0 to 1, the same for the same seed. Source: mulberry32, by Tommy Ettinger, public domain. */
export function randomOf(seed) {
  let state = Number(BigInt.asUintN(32, BigInt(Math.trunc(seed))));
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/**
 * Blocks of a ruined city: { x, z, wide, high, deep, turn, broken }. Scenery: the mission knows nothing of them.
 * Source: ours; dense around a few centres, and none where a task or a charging point is.
 */
export function blocksOf(run, plane) {
  const random = randomOf(run.scenario.seed);
  const centres = Array.from({ length: CENTRES }, () => ({ x: (random() - 0.5) * plane.width, z: (random() - 0.5) * plane.height, reach: 8 + 14 * random() }));
  const sites = [...run.tasks, ...run.charging].map((site) => [plane.x(site.x), plane.z(site.y)]);
  const blocks = [];
  for (let x = -plane.width / 2 + STREET; x < plane.width / 2 - STREET / 2; x += STREET) {
    for (let z = -plane.height / 2 + STREET; z < plane.height / 2 - STREET / 2; z += STREET) {
      const [stands, tall, broken, side, across, lean] = [random(), random(), random(), random(), random(), random()];
      const density = Math.max(...centres.map((c) => Math.exp(-((x - c.x) ** 2 + (z - c.z) ** 2) / (2 * c.reach ** 2))));
      if (stands > density * 0.9 + 0.04 || sites.some(([sx, sz]) => (sx - x) ** 2 + (sz - z) ** 2 < CLEAR ** 2)) continue;
      const ruin = broken < 0.45;
      blocks.push({ x, z, wide: 0.9 + 0.9 * side, deep: 0.9 + 0.9 * across, turn: ruin ? (lean - 0.5) * 0.5 : 0, broken: ruin,
        high: (0.3 + 1.9 * density * tall) * (ruin ? 0.4 : 1) });
    }
  }
  return blocks;
}

/** Draws the blocks; those in ruins have rubble beside what still stands. */
export class City {
  constructor(scene) {
    this.crowd = new Crowd(scene, blockShape(), new MeshLambertMaterial());
  }

  /** `shown`: whether there is scenery at all. */
  build(run, plane, shown) {
    const { crowd } = this;
    const [whole, ruin] = [mixed(theme.line, theme.muted, 0.12), mixed(theme.line, theme.muted, 0.38)];
    crowd.begin();
    const blocks = shown ? blocksOf(run, plane) : [];
    for (const { x, z, wide, high, deep, turn, broken } of blocks) {
      if (!broken) {
        crowd.put(x, 0, z, [wide, high, deep], turn, whole);
        continue;
      }
      crowd.put(x - wide * 0.22, 0, z, [wide * 0.5, high * 1.7, deep * 0.8], turn, ruin);
      crowd.put(x + wide * 0.25, 0, z + deep * 0.15, [wide * 0.5, high * 0.5, deep * 0.6], turn * 3, ruin);
    }
    crowd.end();
    this.n = blocks.length;
  }
}
