import { cornerOf, tilesWithin, zoomFor } from "./web_tiles.js";

const MOST_TILES = 512; // in view
const MOST_KEPT = 1024;
const STRIP_M = 5000; // a picture is drawn in strips no higher than this: the earth is round

export const MOST_NAMES_RANK = 8; // tools/tiles/ground_class.h: a path

/** The names of places and streets that a base map has so far, each once: { text, rank, x, y } in metres. */
export function namesOf(baseMap) {
  const found = new Map();
  for (const tile of baseMap?.tiles.values() ?? []) {
    for (const name of [...(tile?.names ?? []), ...(tile?.streets ?? [])]) {
      const known = found.get(name.text);
      if (!known || known.rank > name.rank) found.set(name.text, name);
    }
  }
  return [...found.values()];
}

/**
 * The base map of a run (docs/guide/report.md): tiles that the page holds, or asks the live server for. `info` is what
 * Muster says of it: { source, vector, type, zooms, units, tiles? }. Tells the document "basemap" when a tile has come.
 */
export class BaseMap {
  constructor(run, info) {
    this.run = run;
    this.info = info;
    this.tiles = new Map(); // "zoom/column/row" -> tile; null: it is on its way, or there is none
    this.version = 0; // changes when a tile has come
  }

  /**
   * The tiles that are there of those within a part of the map's plane, in metres; asks for the others. A page holds the closer zoom of
   * some places only: elsewhere there is the tile of the zoom below, with `parts`, the corners of the squares that it stands for.
   */
  within(box, perMetre) {
    let zoom = zoomFor(this.run, perMetre, this.info.zooms);
    let wanted = null;
    for (; zoom >= this.info.zooms[0] && !wanted; --zoom) wanted = tilesWithin(this.run, zoom, box, MOST_TILES);
    ++zoom;
    const found = [];
    const below = new Map(); // key -> its parts
    for (const [column, row] of wanted ?? []) {
      if (this.#lacks(zoom, column, row)) {
        const key = [zoom - 1, column >> 1, row >> 1].join("/");
        below.set(key, [...(below.get(key) ?? []), this.#square(zoom, column, row)]);
      } else {
        const tile = this.#tile(zoom, column, row);
        if (tile) found.push(tile);
      }
    }
    const coarse = [...below].map(([key, parts]) => ({ ...this.#tile(...key.split("/").map(Number)), parts }));
    return [...coarse.filter(({ names, picture }) => names || picture), ...found];
  }

  #tile(zoom, column, row) {
    const key = `${zoom}/${column}/${row}`;
    if (!this.tiles.has(key)) this.#fetch(key, zoom, column, row);
    return this.tiles.get(key);
  }

  /** Whether the page has the zoom below instead. */
  #lacks(zoom, column, row) {
    return this.info.tiles && zoom > this.info.zooms[0] && !Object.hasOwn(this.info.tiles, `${zoom}/${column}/${row}`);
  }

  #square(zoom, column, row) {
    return [[0, 0], [1, 0], [1, 1], [0, 1]].map(([right, down]) => cornerOf(this.run, zoom, column + right, row + down));
  }

  async #fetch(key, zoom, column, row) {
    if (this.tiles.size >= MOST_KEPT) this.tiles.delete(this.tiles.keys().next().value);
    this.tiles.set(key, null);
    try {
      const data = await this.#dataOf(key);
      if (data === null) return;
      this.tiles.set(key, this.info.vector ? this.#shapes(data, zoom, column, row) : await this.#picture(data, zoom, column, row));
      ++this.version;
      document.dispatchEvent(new Event("basemap"));
    } catch {
      // Without this tile the map is worth showing. The server may be back when it is wanted again.
      if (!this.info.tiles) setTimeout(() => this.tiles.delete(key), 5000);
    }
  }

  /** Shapes, or a picture as a Blob; null: there is no such tile. */
  async #dataOf(key) {
    if (this.info.tiles) {
      const held = this.info.tiles[key];
      if (!held || this.info.vector) return held ?? null;
      return new Blob([Uint8Array.from(atob(held), (letter) => letter.charCodeAt(0))], { type: this.info.type });
    }
    const answer = await fetch(`tiles/${key}`);
    if (answer.status === 404) return null;
    if (!answer.ok) throw new Error(`status ${answer.status}`);
    return this.info.vector ? answer.json() : answer.blob();
  }

  /** { picture, strips: [{ from, to: shares of the height, corners: north-west, north-east, south-west }] } */
  async #picture(blob, zoom, column, row) {
    const picture = await createImageBitmap(blob);
    const corner = (right, down) => cornerOf(this.run, zoom, column + right, row + down);
    const high = corner(0, 0).y - corner(0, 1).y;
    const n = Math.min(16, Math.max(1, Math.ceil(high / STRIP_M)));
    const strip = (from, to) => ({ from, to, corners: [corner(0, from), corner(1, from), corner(0, to)] });
    return { picture, strips: Array.from({ length: n }, (_, i) => strip(i / n, (i + 1) / n)) };
  }

  /** { paths: Path2D in metres by class, names: [{ x, y, rank, text }], streets: [{ from, to, x, y: the middle, rank, text }] } */
  #shapes({ shapes, names, streets }, zoom, column, row) {
    const { units } = this.info;
    const at = (x, y) => cornerOf(this.run, zoom, column + x / units, row + y / units);
    const paths = shapes.map((all) => {
      const path = new Path2D();
      for (const places of all) {
        let [x, y] = [0, 0];
        for (let i = 0; i < places.length; i += 2) {
          x += places[i];
          y += places[i + 1];
          const place = at(x, y);
          if (i === 0) path.moveTo(place.x, place.y);
          else path.lineTo(place.x, place.y);
        }
      }
      return path;
    });
    return {
      paths,
      names: names.map(([x, y, rank, text]) => ({ ...at(x, y), rank, text })),
      streets: streets.map(([x, y, dx, dy, rank, text]) => ({ from: at(x, y), to: at(x + dx, y + dy), ...at(x + dx / 2, y + dy / 2), rank, text })),
    };
  }
}
