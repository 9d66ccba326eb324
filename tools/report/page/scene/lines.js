import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments, VertexColors } from "three";

/** Thin lines, drawn in one call: begin(), add() each, end(). */
export class Lines {
  constructor(scene, options = {}) {
    this.geometry = new BufferGeometry();
    this.material = new LineBasicMaterial({ vertexColors: VertexColors, transparent: true, depthWrite: false, ...options });
    this.object = new LineSegments(this.geometry, this.material);
    this.object.frustumCulled = false;
    this.room = 0;
    this.places = [];
    this.colours = [];
    scene.add(this.object);
  }

  begin() {
    this.places.length = 0;
    this.colours.length = 0;
  }

  add(ax, ay, az, bx, by, bz, colour) {
    this.places.push(ax, ay, az, bx, by, bz);
    this.colours.push(colour.r, colour.g, colour.b, colour.r, colour.g, colour.b);
  }

  end() {
    const n = this.places.length;
    if (n > this.room) {
      this.room = Math.max(2 * this.room, n);
      this.geometry.dispose();
      for (const name of ["position", "color"]) this.geometry.setAttribute(name, new BufferAttribute(new Float32Array(this.room), 3));
    }
    const { position, color } = this.geometry.attributes;
    this.geometry.setDrawRange(0, n / 3);
    if (n === 0) return;
    position.array.set(this.places);
    color.array.set(this.colours);
    position.needsUpdate = true;
    color.needsUpdate = true;
  }
}
