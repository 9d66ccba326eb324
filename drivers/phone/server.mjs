// The page over HTTP, to whoever knows the token.
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { isToken } from "./link.mjs";

const PAGE = join(dirname(fileURLToPath(import.meta.url)), "page");
const FILES = {
  "": ["index.html", "text/html"], "page.css": ["page.css", "text/css"],
  ...Object.fromEntries(["page", "language", "noise", "ground", "queue", "map", "way", "words", "fr", "es", "zh"].map((name) => [`${name}.mjs`, [`${name}.mjs`, "text/javascript"]])),
  "places.mjs": ["../../places.mjs", "text/javascript"],
  "worker.js": ["worker.js", "text/javascript"], "app.webmanifest": ["app.webmanifest", "application/manifest+json"], "icon.svg": ["icon.svg", "image/svg+xml"],
};
const SYNC_BYTES = 64 * 1024, TILE_BYTES = 4e6, TILE_MS = 5000;
/** A tile's name in the page's address: zoom, column, row. */
const TILE = /^tile-(\d{1,2})-(\d{1,8})-(\d{1,8})$/;
const MOST_CONNECTIONS = 32, MOST_UPLOADS = 2, HEADER_BYTES = 8192;
const HEADERS = {
  "Cache-Control": "no-store",
  "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; manifest-src 'self'; worker-src 'self'; "
    + "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
  "Cross-Origin-Opener-Policy": "same-origin",
  "Cross-Origin-Resource-Policy": "same-origin",
  "Permissions-Policy": "geolocation=(self), camera=(), microphone=()",
  "Referrer-Policy": "no-referrer",
  "X-Content-Type-Options": "nosniff",
};

class Refused extends Error {
  constructor(status, words) {
    super(words);
    this.status = status;
  }
}

/** The body, of so many bytes at most. */
async function bodyOf(request, most) {
  const announced = Number(request.headers["content-length"] ?? 0);
  const parts = [];
  let size = announced > most ? Infinity : 0;
  if (size <= most) {
    for await (const part of request.iterator({ destroyOnReturn: false })) {
      size += part.length;
      if (size > most) break;
      parts.push(part);
    }
  }
  if (size > most) throw new Refused(413, `more than ${Math.floor(most / 1000)} kB`);
  return Buffer.concat(parts);
}

export class PageServer {
  #uploads = 0;

  /** `served`: {token, origins (a function), phone, photos (null: none), mostBytes, tiles (a live page's origin, or null), note}. */
  constructor(served) {
    Object.assign(this, served);
    this.http = createServer({ maxHeaderSize: HEADER_BYTES, requestTimeout: 300_000, headersTimeout: 10_000 }, (request, response) => {
      this.#answer(request).then(
        ([status, type, body]) => this.#send(request, response, status, type, body),
        (error) => {
          if (!(error instanceof Refused) && error.code !== "ECONNRESET") this.note(`a request failed: ${error.message}`);
          if (!response.destroyed) this.#send(request, response, error.status ?? 500, "text/plain", error instanceof Refused ? error.message : "that failed here");
        });
    });
    this.http.maxConnections = MOST_CONNECTIONS;
  }

  #send(request, response, status, type, body) {
    const more = request.complete || request.method === "GET" ? {} : { Connection: "close" };
    const kind = /^text/.test(type) ? `${type}; charset=utf-8` : type;
    response.writeHead(status, { ...HEADERS, ...more, "Content-Type": kind, "Content-Length": Buffer.byteLength(body) });
    response.end(body);
  }

  async #answer(request) {
    const origins = this.origins();
    if (!origins.some((origin) => new URL(origin).host === request.headers.host)) throw new Refused(403, "by that name it is not known here");
    const [path, query] = request.url.split("?", 2);
    const [, token, name, ...rest] = path.split("/");
    if (rest.length || name === undefined || !isToken(token, this.token)) throw new Refused(404, "there is nothing here");
    if (request.method === "GET") {
      const tile = TILE.exec(name);
      if (name === "tiles.json") return this.#tile("/tiles.json");
      if (tile) return this.#tile(`/tiles/${tile.slice(1).map(Number).join("/")}`);
      if (!Object.hasOwn(FILES, name)) throw new Refused(404, "there is nothing here");
      const [file, type] = FILES[name];
      return [200, type, readFileSync(join(PAGE, file))];
    }
    if (request.method !== "POST") throw new Refused(405, "expected GET or POST");
    // Pages of others cannot name themselves ours.
    if (!origins.includes(request.headers.origin)) throw new Refused(403, "not from this page");
    if (name === "sync") return this.#sync(request);
    if (name === "photo") return this.#photo(request, new URLSearchParams(query ?? ""));
    throw new Refused(404, "there is nothing here");
  }

  /** What the live page says of its base map, or a tile. */
  async #tile(path) {
    if (!this.tiles) throw new Refused(404, "there is no base map");
    try {
      const answer = await fetch(`${this.tiles}${path}`, { signal: AbortSignal.timeout(TILE_MS), redirect: "error" });
      const type = answer.headers.get("content-type") ?? "";
      if (answer.status !== 200 || !/^(application\/json|image\/(png|jpeg|webp|avif))$/.test(type)) throw new Refused(404, "there is no such tile");
      const body = Buffer.from(await answer.arrayBuffer());
      if (body.length > TILE_BYTES) throw new Refused(404, "that tile is too large");
      return [200, type, body];
    } catch (error) {
      throw error instanceof Refused ? error : new Refused(502, "the mission's live page does not answer");
    }
  }

  async #sync(request) {
    const body = await bodyOf(request, SYNC_BYTES);
    try {
      return [200, "application/json", JSON.stringify(this.phone.sync(JSON.parse(body.toString("utf8"))))];
    } catch (error) {
      if (error instanceof SyntaxError || error instanceof TypeError) throw new Refused(400, error.message);
      throw error;
    }
  }

  async #photo(request, query) {
    const { phone, photos } = this;
    if (!photos || !phone.hello) throw new Refused(404, "no photos are kept: --run names no run directory");
    const id = query.get("id") ?? "", ago_s = Number(query.get("ago_ms")) / 1000;
    if (!/^[0-9a-zA-Z-]{8,40}$/.test(id) || !(ago_s >= 0 && ago_s < 1e6)) throw new Refused(400, "expected id and ago_ms");
    if (photos.isFull || this.#uploads >= MOST_UPLOADS) throw new Refused(photos.isFull ? 409 : 503, "too many photos");
    ++this.#uploads;
    try {
      const bytes = await bodyOf(request, this.mostBytes);
      const order = query.get("session") === phone.session ? phone.orderOf(Number(query.get("order"))) : undefined;
      const { place, hello } = phone;
      const at = place && { x_m: place.x_m, y_m: place.y_m, latitude_deg: place.latitude_deg, longitude_deg: place.longitude_deg,
        accuracy_m: place.accuracy_m, mission_s: place.mission_s };
      const name = photos.keep(id, bytes, {
        agent: hello.agent, task: order?.task ?? null, mission_s: Math.max(hello.mission_s, phone.mission_s - ago_s * (hello.rate ?? 0)), at,
        taken_utc: new Date(Date.now() - 1000 * ago_s).toISOString(),
      });
      if (!name) throw new Refused(415, "no picture: JPEG, PNG, WebP or HEIC");
      this.note(`a photo: ${name}`);
      return [200, "application/json", JSON.stringify({ photo: name })];
    } finally {
      --this.#uploads;
    }
  }
}
