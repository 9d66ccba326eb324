import { degreesOf, planeOf } from "./place.js";

/** Tiles of the web's map of the earth: at zoom z it is 2^z columns by 2^z rows, the first row in the north. */

const EARTH_M = 40075016.7; // around the equator
const MOST_LATITUDE = 85.0511;
const TILE_PX = 384; // about what a tile's side takes on the screen

const longitudeAt = (column, zoom) => (column / 2 ** zoom) * 360 - 180;
const latitudeAt = (row, zoom) => (Math.atan(Math.sinh(Math.PI * (1 - (2 * row) / 2 ** zoom))) * 180) / Math.PI;

/** The place in the map's plane of a tile's column and row; halves are within a tile. */
export const cornerOf = (run, zoom, column, row) => planeOf(run, latitudeAt(row, zoom), longitudeAt(column, zoom));

/** The zoom whose tiles are neither coarse nor many at so many pixels a metre. */
export function zoomFor(run, perMetre, [least, most]) {
  const [latitude] = run.scenario.origin;
  const round = Math.round(Math.log2((EARTH_M * Math.cos((latitude * Math.PI) / 180) * perMetre) / TILE_PX));
  return Math.min(most, Math.max(least, round));
}

/** The tiles of a zoom within a part of the map's plane, in metres: [column, row]; null where they are more than `most`. */
export function tilesWithin(run, zoom, { west, east, south, north }, most) {
  const side = 2 ** zoom;
  const places = [[west, south], [west, north], [east, south], [east, north]].map(([x, y]) => degreesOf(run, { x, y }));
  const column = (longitude) => Math.floor(((longitude + 180) / 360) * side);
  const row = (latitude) => {
    const phi = (Math.min(MOST_LATITUDE, Math.max(-MOST_LATITUDE, latitude)) * Math.PI) / 180;
    return Math.floor(((1 - Math.asinh(Math.tan(phi)) / Math.PI) / 2) * side);
  };
  const within = (n) => Math.min(side - 1, Math.max(0, n));
  const columns = places.map(([, longitude]) => within(column(longitude)));
  const rows = places.map(([latitude]) => within(row(latitude)));
  const [left, right, top, bottom] = [Math.min(...columns), Math.max(...columns), Math.min(...rows), Math.max(...rows)];
  if ((right - left + 1) * (bottom - top + 1) > most) return null;
  const tiles = [];
  for (let r = top; r <= bottom; ++r) for (let col = left; col <= right; ++col) tiles.push([col, r]);
  return tiles;
}
