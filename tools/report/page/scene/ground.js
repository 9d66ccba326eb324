import { CanvasTexture, DoubleSide, LinearFilter, Mesh, MeshBasicMaterial, PlaneBufferGeometry } from "three";
import { BELOW } from "../layers/below.js";
import { closed, closuresAt, closuresKey } from "../layers/roads.js";
import { zones } from "../layers/zones.js";
import { frameOf, linear } from "../scale.js";

const SIDE = 900; // pixels that the map's lines and letters are made for
const SHARP = 2.5;
const MARGIN = 30;

/** What a picture of the ground shows at that time: the same for the same. */
const keyOf = (run, t) => `${closuresKey(closuresAt(run, t))} ${run.baseMap?.version}`;

/** The map's ground, grid, degrees, background and roads as a picture, with what is closed at that time. */
function paint(run, plane, t) {
  const long = Math.max(plane.width, plane.height);
  const perUnit = (SIDE - 2 * MARGIN) / long;
  const width = plane.width * perUnit + 2 * MARGIN;
  const height = plane.height * perUnit + 2 * MARGIN;
  const canvas = document.createElement("canvas");
  canvas.width = Math.round(width * SHARP);
  canvas.height = Math.round(height * SHARP);
  const c = canvas.getContext("2d");
  c.scale(SHARP, SHARP);
  const { width_m: w, height_m: h } = run.scenario;
  const shown = { x: linear([0, w], [MARGIN, width - MARGIN]), y: linear([0, h], [height - MARGIN, MARGIN]), width, height };
  Object.assign(shown, { run, t, frame: frameOf(shown, run.scenario) });
  for (const layer of [...BELOW, closed, zones]) layer.draw(c, shown);
  return { canvas, wide: width / perUnit, high: height / perUnit };
}

/** The ground, and a glass of it that marks a time in the space-time view. */
export class Ground {
  constructor(below, scene) {
    this.below = below;
    this.scene = scene;
  }

  build(run, plane, t) {
    for (const mesh of [this.mesh, this.glass]) {
      if (!mesh) continue;
      mesh.parent.remove(mesh);
      mesh.geometry.dispose();
      mesh.material.map.dispose();
      mesh.material.dispose();
    }
    const { canvas, wide, high } = paint(run, plane, t);
    this.painted = keyOf(run, t);
    const texture = new CanvasTexture(canvas);
    texture.minFilter = LinearFilter;
    texture.generateMipmaps = false;
    texture.anisotropy = 4;
    const flat = () => new PlaneBufferGeometry(wide, high).rotateX(-Math.PI / 2);
    this.mesh = new Mesh(flat(), new MeshBasicMaterial({ map: texture, transparent: true }));
    this.glass = new Mesh(flat(), new MeshBasicMaterial({ map: texture, transparent: true, opacity: 0.4, side: DoubleSide, depthWrite: false }));
    this.below.add(this.mesh);
    this.scene.add(this.glass);
  }

  /** Paints it again if other roads are closed, or other zones in force, than when it was painted. */
  show(run, plane, t) {
    const key = keyOf(run, t);
    if (key === this.painted) return;
    this.painted = key;
    const texture = this.mesh.material.map;
    texture.image = paint(run, plane, t).canvas;
    texture.needsUpdate = true;
  }
}
