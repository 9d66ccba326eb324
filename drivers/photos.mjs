// Photos in the run directory, or what is known of them: under names that are made here, whole or not there, and none in the
// place of another.
import { existsSync, linkSync, mkdirSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";

/** A driver keeps no more. */
export const MOST_PHOTOS = 1000;

function baseOf({ agent, task, mission_s, at }) {
  const where = at ? `${Math.round(at.x_m)}m-${Math.round(at.y_m)}m` : "nowhere";
  return `${agent.replace(":", "-")}_${task === null ? "no-task" : `task-${task}`}_${where}_${Math.round(mission_s)}s`;
}

export class PhotoFolder {
  /** `run`: the mission's run directory. */
  constructor(run) {
    this.folder = join(run, "photos");
  }

  /**
   * Keeps a file of what is known of a photo, and the photo beside it, if there is one: {kind, bytes}. `of`: {agent, task,
   * mission_s, at}, and what else there is to say. Returns the name, without its ending. Throws what the file system says.
   */
  keep(of, photo = null) {
    mkdirSync(this.folder, { recursive: true });
    const base = baseOf(of);
    for (let i = 1; ; ++i) {
      const name = `${base}_${i}`;
      if (existsSync(join(this.folder, `${name}.json`))) continue;
      if (photo && !this.#write(`${name}.${photo.kind}`, photo.bytes)) continue;
      const words = { version: 1, photo: photo && `${name}.${photo.kind}`, ...of };
      if (this.#write(`${name}.json`, `${JSON.stringify(words, null, 1)}\n`) || photo) return name;
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
