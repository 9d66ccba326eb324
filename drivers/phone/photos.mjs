// The photos of a phone's page: each once, pictures only.
import { createHash } from "node:crypto";
import { MOST_PHOTOS, PhotoFolder } from "../photos.mjs";

/** What it is, by its first bytes; null: no picture that phones make. */
export function kindOf(bytes) {
  const text = bytes.subarray(0, 12).toString("latin1");
  if (text.startsWith("\xff\xd8\xff")) return "jpg";
  if (text.startsWith("\x89PNG\r\n\x1a\n")) return "png";
  if (text.startsWith("RIFF") && text.endsWith("WEBP")) return "webp";
  if (/^ftyp(heic|heix|mif1|msf1|hevc)/.test(text.slice(4))) return "heic";
  return null;
}

export class Photos {
  #kept = new Map();  // by the page's number of it

  constructor(run) {
    this.photos = new PhotoFolder(run);
  }

  get isFull() {
    return this.#kept.size >= MOST_PHOTOS;
  }

  /**
   * Keeps it, once for each id, with what is known of it beside it. `of`: {agent, task, mission_s, at, taken_utc}; returns the
   * name, null when it is no picture. Throws what the file system says.
   */
  keep(id, bytes, of) {
    const before = this.#kept.get(id);
    if (before) return before;
    const kind = kindOf(bytes);
    if (!kind) return null;
    const sha256 = createHash("sha256").update(bytes).digest("hex");
    const name = this.photos.keep({ ...of, taken_utc: of.taken_utc ?? null, bytes: bytes.length, sha256 }, { kind, bytes });
    this.#kept.set(id, `${name}.${kind}`);
    return `${name}.${kind}`;
  }
}
