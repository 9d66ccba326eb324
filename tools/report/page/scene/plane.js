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

  z(north) {
    return this.height / 2 - north * this.unit;
  }
}
