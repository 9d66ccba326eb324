// The fence as it is wanted: the area to stay in, and the zones to stay out of, which come and go while it flies.
import { polygon, STAY_IN, STAY_OUT, writeFence } from "./fence.mjs";
import { Trouble } from "./talk.mjs";
import { Zones } from "./zones.mjs";

/** What could not be written is written again after so long. */
const AGAIN_S = 10;

export class ZoneFence {
  #written = null;  // ids of the zones that it has; null: it has no fence of ours yet
  #again_s = -Infinity;
  #work = null;

  constructor({ talk, area, map, note }) {
    Object.assign(this, { talk, area, map, note, zones: new Zones(note) });
  }

  /** Of the fence for where it is now, to be written. */
  items(place) {
    const corners = this.area.corners();
    const zones = this.zones.around(place, corners.length);
    this.#written = idsOf(zones);
    const outlines = zones.map(([, outline]) => outline.map((corner) => this.map.toDegrees(corner)));
    return [...polygon(STAY_IN, corners), ...outlines.flatMap((outline) => polygon(STAY_OUT, outline))];
  }

  /** Goes on writing it where the zones are others than it has. `heard`: as Driver.step() has it. */
  step(place, heard) {
    const now = this.talk.now();
    if (!this.#work && now >= this.#again_s && idsOf(this.zones.around(place, this.area.corners().length)) !== this.#written) {
      this.#work = writeFence(this.talk, this.items(place));
    }
    try {
      if (this.#work?.next(heard).done) this.#work = null;
    } catch (error) {
      if (!(error instanceof Trouble)) throw error;
      this.note(`the zones are not in its fence: ${error.message}`);
      this.#work = this.#written = null;
      this.#again_s = now + AGAIN_S;
    }
  }
}

function idsOf(zones) {
  return JSON.stringify(zones.map(([id]) => id));
}
