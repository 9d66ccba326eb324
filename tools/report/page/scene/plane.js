/** The longer side of the area, in the scene's units. */
export const SIZE = 100;

/** The area in the scene: x east, y up, z south, its middle at the origin. */
export class Plane {
  constructor({ width_m: width, height_m: height }) {
    this.unit = SIZE / Math.max(width, height, 1); // of a metre
    this.width = width * this.unit;
    this.height = height * this.unit;
  }

  x(east) {
    return east * this.unit - this.width / 2;
  }

  /** Metres east of a place of the scene. */
  east(x) {
    return (x + this.width / 2) / this.unit;
  }

  north(z) {
    return (this.height / 2 - z) / this.unit;
  }

  z(north) {
    return this.height / 2 - north * this.unit;
  }
}
