import { number } from "./dom.js";

// WGS84
const A = 6378137;
const F = 1 / 298.257223563;
const E2 = F * (2 - F);
const RADIANS = Math.PI / 180;

/** Earth-centred coordinates, in metres, of a place at height 0. */
function earthCentred(latitude, longitude) {
  const [sinLat, cosLat] = [Math.sin(latitude * RADIANS), Math.cos(latitude * RADIANS)];
  const n = A / Math.sqrt(1 - E2 * sinLat ** 2);
  return [n * cosLat * Math.cos(longitude * RADIANS), n * cosLat * Math.sin(longitude * RADIANS), n * (1 - E2) * sinLat];
}

/** East, north and up at an origin in degrees, as rows. */
function axesAt([latitude, longitude]) {
  const [sinLat, cosLat] = [Math.sin(latitude * RADIANS), Math.cos(latitude * RADIANS)];
  const [sinLon, cosLon] = [Math.sin(longitude * RADIANS), Math.cos(longitude * RADIANS)];
  return [[-sinLon, cosLon, 0], [-sinLat * cosLon, -sinLat * sinLon, cosLat], [cosLat * cosLon, cosLat * sinLon, sinLat]];
}

/**
 * Latitude and longitude, in degrees, of a place in the map's plane, which touches the earth at the scenario's origin;
 * null without one. Source: Bowring's formula, one step, exact to a millimetre near the ground.
 */
export function degreesOf(run, { x, y }) {
  const { origin } = run.scenario;
  if (!origin) return null;
  const [east, north] = axesAt(origin);
  const [X, Y, Z] = earthCentred(...origin).map((value, i) => value + x * east[i] + y * north[i]);
  const p = Math.hypot(X, Y);
  const b = A * (1 - F);
  const theta = Math.atan2(Z * A, p * b);
  const latitude = Math.atan2(Z + (E2 / (1 - E2)) * b * Math.sin(theta) ** 3, p - E2 * A * Math.cos(theta) ** 3);
  return [latitude / RADIANS, Math.atan2(Y, X) / RADIANS];
}

/** The place in the map's plane, in metres, of degrees; the scenario must have an origin. */
export function planeOf(run, latitude, longitude) {
  const { origin } = run.scenario;
  const [east, north] = axesAt(origin);
  const from = earthCentred(...origin);
  const d = earthCentred(latitude, longitude).map((value, i) => value - from[i]);
  const dot = (axis) => axis[0] * d[0] + axis[1] * d[1] + axis[2] * d[2];
  return { x: dot(east), y: dot(north) };
}

export function latitudeWords(degrees, digits = 3) {
  return `${number(Math.abs(degrees), digits)}° ${degrees < 0 ? "S" : "N"}`;
}

export function longitudeWords(degrees, digits = 3) {
  return `${number(Math.abs(degrees), digits)}° ${degrees < 0 ? "W" : "E"}`;
}

const SMALL_M = 2000; // the side of an area in which a hundred metres are far

/** "12.3, 4.5 km", and its degrees where they are known; of a small area to the metre. */
export function placeWords(run, place) {
  const more = Math.max(run.scenario.width_m, run.scenario.height_m) <= SMALL_M ? 2 : 0;
  const km = `${number(place.x / 1000, 1 + more)}, ${number(place.y / 1000, 1 + more)} km`;
  const degrees = degreesOf(run, place);
  return degrees ? `${km} (${latitudeWords(degrees[0], 3 + more)} ${longitudeWords(degrees[1], 3 + more)})` : km;
}
