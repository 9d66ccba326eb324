// The base map below the phone's map: tiles of the mission's live page, which the driver passes on.
import { MissionMap } from "./places.mjs";

const EARTH_M = 40075016.7;  // around the equator
const TILE_PX = 300;  // about what a tile's side takes on the screen
const MOST_KEPT = 64, MOST_TILES = 24;
const AGAIN_MS = 10_000;
/** By class, as tools/tiles/vector_tile.h numbers them: a colour of page.css, and the width of lines in pixels. */
const STYLES = [["green"], ["built"], ["water"], ["shore", 1], ["building"], ["street", 1], ["street", 1], ["street", 2], ["road", 3], ["road", 4]];

const from = (a, b) => ({ x_m: b.x_m - a.x_m, y_m: b.y_m - a.y_m });
const longitudeAt = (column, zoom) => (column / 2 ** zoom) * 360 - 180;
const latitudeAt = (row, zoom) => (Math.atan(Math.sinh(Math.PI * (1 - (2 * row) / 2 ** zoom))) * 180) / Math.PI;

/** The tile of a zoom in which a place is: [column, row]. */
export function tileAt({ latitude_deg, longitude_deg }, zoom) {
  const phi = (latitude_deg * Math.PI) / 180;
  return [(longitude_deg + 180) / 360, (1 - Math.asinh(Math.tan(phi)) / Math.PI) / 2].map((share) => Math.floor(share * 2 ** zoom));
}

/** The tiles that cover what is shown, [zoom, column, row]: `frame` of map.mjs; `zooms`: the first and the last that there are. */
export function tilesFor(map, frame, { width, height }, latitude_deg, [least, most]) {
  const side_m = TILE_PX / frame.scale;
  let zoom = Math.round(Math.log2((EARTH_M * Math.cos((latitude_deg * Math.PI) / 180)) / side_m));
  zoom = Math.min(most, Math.max(least, zoom));
  const [right, up] = [width / 2 / frame.scale, height / 2 / frame.scale];
  const corners = [[-right, -up], [right, -up], [right, up], [-right, up]].map(([x, y]) => map.toDegrees({ x_m: frame.x_m + x, y_m: frame.y_m + y }));
  for (; ; --zoom) {
    const places = corners.map((corner) => tileAt(corner, zoom));
    const [columns, rows] = [0, 1].map((i) => places.map((place) => place[i]));
    const [west, east, north, south] = [Math.min(...columns), Math.max(...columns), Math.min(...rows), Math.max(...rows)];
    if ((east - west + 1) * (south - north + 1) > MOST_TILES) {
      if (zoom === least) return [];
      continue;
    }
    const tiles = [];
    for (let row = north; row <= south; ++row) for (let column = west; column <= east; ++column) tiles.push([zoom, column, row]);
    return tiles;
  }
}

export class Ground {
  #info = null;  // what there is; null: nothing so far
  #asked_ms = -Infinity;
  #tiles = new Map();  // "zoom-column-row" -> tile; null: on its way, or there is none

  /** `canvas`: below the map; `changed()`: a tile has come. */
  constructor(canvas, changed) {
    Object.assign(this, { canvas, changed });
  }

  /** Whose map it is; "": there is none. */
  get source() {
    return this.#info?.source ?? "";
  }

  /** Draws what there is; asks for the rest. `view`: of the mission; `frame`: of map.mjs, or null. */
  draw(view, frame, size) {
    const c = this.canvas.getContext("2d");
    this.#fit(size);
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.clearRect(0, 0, this.canvas.width, this.canvas.height);
    if (!frame || !view.origin || !this.#info) {
      if (view.has_tiles) this.#ask();
      return;
    }
    const map = (this.map ??= new MissionMap(view.origin));
    const wanted = tilesFor(map, frame, size, view.origin.latitude_deg, this.#info.zooms);
    const tiles = wanted.map((id) => this.#tile(...id)).filter(Boolean);
    const ratio = this.canvas.width / size.width;
    // Metres to pixels, north up.
    const scale = frame.scale * ratio;
    c.setTransform(scale, 0, 0, -scale, this.canvas.width / 2 - frame.x_m * scale, this.canvas.height / 2 + frame.y_m * scale);
    if (this.#info.vector) this.#drawShapes(c, tiles, frame.scale);
    else for (const tile of tiles) this.#drawPicture(c, tile);
  }

  #fit({ width, height }) {
    const ratio = window.devicePixelRatio || 1;
    const [wide, high] = [width, height].map((side) => Math.round(side * ratio));
    if (this.canvas.width !== wide) this.canvas.width = wide;
    if (this.canvas.height !== high) this.canvas.height = high;
  }

  #drawShapes(c, tiles, scale) {
    const style = getComputedStyle(document.documentElement);
    c.lineJoin = "round";
    STYLES.forEach(([colour, width], i) => {
      c.fillStyle = c.strokeStyle = style.getPropertyValue(`--${colour}`);
      c.lineWidth = (width ?? 0) / scale;
      for (const { paths } of tiles) {
        if (width) c.stroke(paths[i]);
        else c.fill(paths[i]);
      }
    });
  }

  #drawPicture(c, { picture, nw, ne, sw }) {
    c.save();
    c.globalAlpha = 0.7;
    const { width, height } = picture, [right, down] = [from(nw, ne), from(nw, sw)];
    c.transform(right.x_m / width, right.y_m / width, down.x_m / height, down.y_m / height, nw.x_m, nw.y_m);
    c.drawImage(picture, 0, 0);
    c.restore();
  }

  async #ask() {
    if (performance.now() - this.#asked_ms < AGAIN_MS) return;
    this.#asked_ms = performance.now();
    try {
      const answer = await fetch("tiles.json");
      if (answer.ok) this.#info = await answer.json();
      this.changed();
    } catch { /* without it the map is worth showing */ }
  }

  #tile(zoom, column, row) {
    const key = `${zoom}-${column}-${row}`;
    if (!this.#tiles.has(key)) this.#fetch(key, zoom, column, row);
    return this.#tiles.get(key);
  }

  async #fetch(key, zoom, column, row) {
    if (this.#tiles.size >= MOST_KEPT) this.#tiles.delete(this.#tiles.keys().next().value);
    this.#tiles.set(key, null);
    try {
      const answer = await fetch(`tile-${key}`);
      if (answer.status === 404) return;
      if (!answer.ok) throw new Error(`status ${answer.status}`);
      const at = (x, y) => this.map.toMetres({ latitude_deg: latitudeAt(row + y, zoom), longitude_deg: longitudeAt(column + x, zoom) });
      const corners = { nw: at(0, 0), ne: at(1, 0), sw: at(0, 1) };
      const { vector } = this.#info;
      this.#tiles.set(key, vector ? this.#shapes(await answer.json(), corners) : { picture: await createImageBitmap(await answer.blob()), ...corners });
      this.changed();
    } catch {
      setTimeout(() => this.#tiles.delete(key), AGAIN_MS);
    }
  }

  /** { paths: Path2D in metres, by class }; from the tile's corners. */
  #shapes({ shapes }, { nw, ne, sw }) {
    const { units } = this.#info, [right, down] = [from(nw, ne), from(nw, sw)];
    // A tile is small: its places lie evenly.
    const place = (x, y) => ["x_m", "y_m"].map((axis) => nw[axis] + (x / units) * right[axis] + (y / units) * down[axis]);
    return { paths: shapes.map((all) => {
      const path = new Path2D();
      for (const places of all) {
        for (let i = 0, x = 0, y = 0; i < places.length; i += 2) {
          x += places[i];
          y += places[i + 1];
          if (i === 0) path.moveTo(...place(x, y));
          else path.lineTo(...place(x, y));
        }
      }
      return path;
    }) };
  }
}
