import { BufferAttribute, Color, InstancedBufferAttribute, InstancedMesh, VertexColors } from "three";

const LEAST = 64;

/** Many bodies of one shape, drawn in one call: begin(), put() each, end(). */
export class Crowd {
  constructor(scene, geometry, material) {
    this.scene = scene;
    this.geometry = geometry;
    this.material = material;
    material.vertexColors = VertexColors;
    this.n = 0;
    this.#grow(LEAST);
  }

  #grow(room) {
    const matrices = new Float32Array(room * 16);
    const colours = new Float32Array(room * 3);
    if (this.mesh) {
      matrices.set(this.mesh.instanceMatrix.array);
      colours.set(this.colours.array);
      this.scene.remove(this.mesh);
      this.geometry.dispose();
    }
    this.colours = new InstancedBufferAttribute(colours, 3);
    this.geometry.setAttribute("color", this.colours);
    this.mesh = new InstancedMesh(this.geometry, this.material, 0);
    this.mesh.instanceMatrix = new BufferAttribute(matrices, 16);
    this.mesh.frustumCulled = false;
    this.mesh.matrixAutoUpdate = false;
    this.room = room;
    this.scene.add(this.mesh);
  }

  begin() {
    this.n = 0;
  }

  #next(colour) {
    if (this.n === this.room) this.#grow(2 * this.room);
    colour.toArray(this.colours.array, 3 * this.n);
    return 16 * this.n++;
  }

  /** A body at (x, y, z), so large, turned around the vertical: `turn` in radians, counter-clockwise from east. */
  put(x, y, z, [wide, high, deep], turn, colour) {
    const at = this.#next(colour);
    const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
    this.mesh.instanceMatrix.array.set([cos * wide, 0, -sin * wide, 0, 0, high, 0, 0, sin * deep, 0, cos * deep, 0, x, y, z, 1], at);
  }

  /** A body one unit long, along y around its middle, laid from `a` to `b`; places as [x, y, z]. */
  lay(a, b, thick, colour) {
    const d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    const long = Math.hypot(...d);
    if (long < 1e-6) return;
    const [dx, dy, dz] = d.map((v) => v / long);
    // Across: perpendicular to it and, but for uprights, level.
    const level = Math.hypot(dx, dz);
    const u = level > 1e-3 ? [dz / level, 0, -dx / level] : [1, 0, 0];
    const v = [u[1] * dz - u[2] * dy, u[2] * dx - u[0] * dz, u[0] * dy - u[1] * dx];
    const at = this.#next(colour);
    this.mesh.instanceMatrix.array.set([...u.map((c) => c * thick), 0, ...d, 0, ...v.map((c) => c * thick), 0,
      (a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2, 1], at);
  }

  end() {
    this.mesh.count = this.n;
    this.mesh.instanceMatrix.needsUpdate = true;
    this.colours.needsUpdate = true;
  }
}

/** A colour between two, as the style sheet writes them. */
export const mixed = (from, to, share) => new Color(from).lerp(new Color(to), share);
