import { BufferAttribute, BufferGeometry, Mesh, MeshLambertMaterial, VertexColors } from "three";
import { isWater } from "../coast.js";
import { theme } from "../theme.js";
import { mixed } from "./crowd.js";
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
 * Source: ours; dense around a few centres, and none in water or where a task or a charging point is.
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
      if (isWater(run, plane.east(x), plane.north(z))) continue;
      const ruin = broken < 0.45;
      blocks.push({ x, z, wide: 0.9 + 0.9 * side, deep: 0.9 + 0.9 * across, turn: ruin ? (lean - 0.5) * 0.5 : 0, broken: ruin,
        high: (0.3 + 1.9 * density * tall) * (ruin ? 0.4 : 1) });
    }
  }
  return blocks;
}

/** Draws the blocks, as one body; those in ruins have rubble beside what still stands. */
export class City {
  constructor(scene) {
    this.mesh = new Mesh(new BufferGeometry(), new MeshLambertMaterial({ vertexColors: VertexColors }));
    this.mesh.frustumCulled = false;
    scene.add(this.mesh);
  }

  /** `shown`: whether there is scenery at all. */
  build(run, plane, shown) {
    const [whole, ruin] = [mixed(theme.line, theme.muted, 0.12), mixed(theme.line, theme.muted, 0.38)];
    const blocks = shown ? blocksOf(run, plane) : [];
    const boxes = blocks.flatMap(({ x, z, wide, high, deep, turn, broken }) => (broken
      ? [{ x: x - wide * 0.22, z, size: [wide * 0.5, high * 1.7, deep * 0.8], turn, colour: ruin },
        { x: x + wide * 0.25, z: z + deep * 0.15, size: [wide * 0.5, high * 0.5, deep * 0.6], turn: turn * 3, colour: ruin }]
      : [{ x, z, size: [wide, high, deep], turn, colour: whole }]));
    const { position, normal } = blockShape().attributes;
    const n = position.array.length;
    const arrays = { position: new Float32Array(n * boxes.length), normal: new Float32Array(n * boxes.length), color: new Float32Array(n * boxes.length) };
    boxes.forEach(({ x, z, size, turn, colour }, box) => {
      const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
      for (let i = 0; i < n; i += 3) {
        const at = n * box + i;
        const [px, py, pz] = [0, 1, 2].map((axis) => position.array[i + axis] * size[axis]);
        const [nx, ny, nz] = normal.array.slice(i, i + 3);
        arrays.position.set([x + px * cos + pz * sin, py, z - px * sin + pz * cos], at);
        arrays.normal.set([nx * cos + nz * sin, ny, -nx * sin + nz * cos], at);
        colour.toArray(arrays.color, at);
      }
    });
    const { geometry } = this.mesh;
    geometry.dispose();
    for (const [name, array] of Object.entries(arrays)) geometry.setAttribute(name, new BufferAttribute(array, 3));
    this.mesh.visible = boxes.length > 0;
    this.n = blocks.length;
  }
}
