// Where it may fly: the mission's area up to a ceiling. The autopilot gets it as its fence, somewhat larger, so that it steps
// in only when we did not.

/** Nothing is commanded farther outside the area than rounding makes it. */
const ROUNDING_M = 1;
/** So far outside it is out: places are good to some metres. */
const OUTSIDE_M = 5;
/** The autopilot's fence, outside the area. */
const FENCE_M = 20;
/** The autopilot draws straight lines between degrees: with corners so near they are those of the map to 1 m. */
const CORNERS_M = 4000;
/** The fence above the highest altitude that it flies at. */
export const CEILING_M = 20;

export class Area {
  constructor(map, { width_m, height_m }, highest_m) {
    this.map = map;
    this.width_m = width_m;
    this.height_m = height_m;
    this.ceiling_m = highest_m + CEILING_M;
  }

  #holds({ x_m, y_m }, margin_m) {
    return x_m >= -margin_m && y_m >= -margin_m && x_m <= this.width_m + margin_m && y_m <= this.height_m + margin_m;
  }

  mayBeSent(place) {
    return Number.isFinite(place.x_m) && Number.isFinite(place.y_m) && this.#holds(place, ROUNDING_M);
  }

  isOut(place, altitude_m) {
    return !this.#holds(place, OUTSIDE_M) || altitude_m > this.ceiling_m;
  }

  /** The fence's corners, counter-clockwise, in degrees. */
  corners() {
    const [west, south, east, north] = [-FENCE_M, -FENCE_M, this.width_m + FENCE_M, this.height_m + FENCE_M];
    const corners = [[west, south], [east, south], [east, north], [west, north]];
    return corners.flatMap(([x, y], i) => {
      const [to_x, to_y] = corners[(i + 1) % 4];
      const parts = Math.max(1, Math.ceil(Math.hypot(to_x - x, to_y - y) / CORNERS_M));
      return Array.from({ length: parts }, (_, part) =>
        this.map.toDegrees({ x_m: x + ((to_x - x) * part) / parts, y_m: y + ((to_y - y) * part) / parts }));
    });
  }
}
