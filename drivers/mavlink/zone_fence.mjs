// The fence as it is wanted: the area to stay in, and the zones to stay out of, which come and go while it flies.
import { NoRoom, polygon, STAY_IN, STAY_OUT, writeFence } from "./fence.mjs";
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

  /** Writes it for where it is now. If the autopilot has no room for all zones, the last ones are left out. */
  *write(place) {
    this.#work = null;  // what was begun in flight is of another time
    return yield* this.#write(place);
  }

  *#write(place) {
    for (;;) {
      const items = this.#items(place), corners = items.length - this.area.corners().length;
      try {
        return yield* writeFence(this.talk, items);
      } catch (error) {
        if (!(error instanceof NoRoom) || corners === 0) throw error;
        this.zones.room = corners - 1;
      }
    }
  }

  #items(place) {
    const corners = this.area.corners();
    const zones = this.zones.around(place);
    this.#written = idsOf(zones);
    const outlines = zones.map(([, outline]) => outline.map((corner) => this.map.toDegrees(corner)));
    return [...polygon(STAY_IN, corners), ...outlines.flatMap((outline) => polygon(STAY_OUT, outline))];
  }

  /** Goes on writing it where the zones are others than it has. `heard`: as Driver.step() has it. */
  step(place, heard) {
    const now = this.talk.now();
    if (!this.#work && now >= this.#again_s && idsOf(this.zones.around(place)) !== this.#written) {
      this.#work = this.#write(place);
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
  return zones.length === 0 ? "[]" : JSON.stringify(zones.map(([id]) => id));
}
