// Photos in the run directory: under names that are made here, whole or not there, and none in the place of another.
import { createHash } from "node:crypto";
import { existsSync, linkSync, mkdirSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";

const MOST_PHOTOS = 1000;

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
    this.folder = join(run, "photos");
  }

  get isFull() {
    return this.#kept.size >= MOST_PHOTOS;
  }

  /**
   * Keeps it, once for each id, with what is known of it beside it. `of`: {agent, task, mission_s, at}; returns the name, null
   * when it is no picture. Throws what the file system says.
   */
  keep(id, bytes, of) {
    const before = this.#kept.get(id);
    if (before) return before;
    const kind = kindOf(bytes);
    if (!kind) return null;
    mkdirSync(this.folder, { recursive: true });
    const where = of.at ? `${Math.round(of.at.x_m)}m-${Math.round(of.at.y_m)}m` : "nowhere";
    const what = of.task === null ? "no-task" : `task-${of.task}`;
    const base = `${of.agent.replace(":", "-")}_${what}_${where}_${Math.round(of.mission_s)}s`;
    for (let i = 1; ; ++i) {
      const name = `${base}_${i}`;
      const photo = `${name}.${kind}`;
      if (existsSync(join(this.folder, `${name}.json`)) || !this.#write(photo, bytes)) continue;
      const sha256 = createHash("sha256").update(bytes).digest("hex");
      const words = { version: 1, photo, ...of, taken_utc: of.taken_utc ?? null, bytes: bytes.length, sha256 };
      this.#write(`${name}.json`, `${JSON.stringify(words, null, 1)}\n`);
      this.#kept.set(id, photo);
      return photo;
    }
  }

  /** Returns false when there is one of that name. */
  #write(name, content) {
    const path = join(this.folder, name), part = join(this.folder, `.${process.pid}-${name}.part`);
    try {
      writeFileSync(part, content);
      linkSync(part, path);
      return true;
    } catch (error) {
      if (error.code === "EEXIST") return false;
      throw error;
    } finally {
      rmSync(part, { force: true });
    }
  }
}
