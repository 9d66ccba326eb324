// The mission's map: metres east and north of the area's south-west corner, and degrees (WGS84).

const A_M = 6378137, F = 1 / 298.257223563, E2 = F * (2 - F);

function toEarth(latitude, longitude, height) {
  const n = A_M / Math.sqrt(1 - E2 * Math.sin(latitude) ** 2);
  const across = (n + height) * Math.cos(latitude);
  return [
    across * Math.cos(longitude),
    across * Math.sin(longitude),
    (n * (1 - E2) + height) * Math.sin(latitude),
  ];
}

const radians = (degrees) => (degrees * Math.PI) / 180;
const degrees = (angle) => (angle * 180) / Math.PI;

/**
 * East and north on the plane that touches the ellipsoid at the origin, as GeographicLib's LocalCartesian has them.
 * Source: B. Hofmann-Wellenhof et al., GNSS (2008), sections 8.2.1 and 8.2.2: geodetic to Cartesian, Cartesian to local.
 */
export class MissionMap {
  constructor(origin) {
    this.latitude = radians(origin.latitude_deg);
    this.longitude = radians(origin.longitude_deg);
    this.centre = toEarth(this.latitude, this.longitude, 0);
    const [sp, cp, sl, cl] = [Math.sin(this.latitude), Math.cos(this.latitude), Math.sin(this.longitude), Math.cos(this.longitude)];
    this.axes = [[-sl, cl, 0], [-sp * cl, -sp * sl, cp]];
  }

  /** The place at these degrees. Its height, 0 here, is without effect at the size of a mission. */
  toMetres({ latitude_deg, longitude_deg }) {
    const point = toEarth(radians(latitude_deg), radians(longitude_deg), 0), { centre, axes: [east, north] } = this;
    const x = point[0] - centre[0], y = point[1] - centre[1], z = point[2] - centre[2];
    return { x_m: east[0] * x + east[1] * y + east[2] * z, y_m: north[0] * x + north[1] * y + north[2] * z };
  }

  /** The degrees of a place: nearer with each step, by the radii of curvature at the origin. */
  toDegrees({ x_m, y_m }) {
    const s = 1 - E2 * Math.sin(this.latitude) ** 2;
    const north_m = (A_M * (1 - E2)) / s ** 1.5, east_m = (A_M / Math.sqrt(s)) * Math.cos(this.latitude);
    const place = { latitude_deg: degrees(this.latitude), longitude_deg: degrees(this.longitude) };
    for (let step = 0; step < 10; ++step) {
      const at = this.toMetres(place);
      place.latitude_deg += degrees((y_m - at.y_m) / north_m);
      place.longitude_deg += degrees((x_m - at.x_m) / east_m);
    }
    return place;
  }
}

export function distance_m(a, b) {
  return Math.hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

/** The place so far on the way from one to the other, at most at its end. */
export function towards(from, to, way_m) {
  const whole_m = distance_m(from, to);
  const part = whole_m > way_m ? way_m / whole_m : 1;
  return { x_m: from.x_m + part * (to.x_m - from.x_m), y_m: from.y_m + part * (to.y_m - from.y_m) };
}
