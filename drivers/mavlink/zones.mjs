// The mission's zones, which UAVs keep out of. They go into the autopilot's fence, which steps in only when we did not.

/** Of all zones together, unless the autopilot has less room. */
const MOST_CORNERS = 190;

function holds(ring, { x_m, y_m }) {
  return ring.filter((a, i) => {
    const b = ring[(i + 1) % ring.length];
    return a.y_m > y_m !== b.y_m > y_m && x_m < ((b.x_m - a.x_m) * (y_m - a.y_m)) / (b.y_m - a.y_m) + a.x_m;
  }).length % 2 === 1;
}

const isCorner = (corner) => Number.isFinite(corner?.x_m) && Number.isFinite(corner?.y_m);
const isRing = (ring) => Array.isArray(ring) && ring.length >= 3 && ring.every(isCorner);

export class Zones {
  #zones = new Map();  // id -> outline
  #isTold = new Set();
  /** For so many corners the fence has room. */
  room = MOST_CORNERS;

  /** `note`: takes words for people. */
  constructor(note) {
    this.note = note;
  }

  get isAny() {
    return this.#zones.size > 0;
  }

  /** Takes a line of the mission. */
  add({ id, rings }) {
    if (!Array.isArray(rings) || !rings.every(isRing)) return;
    if (rings.length === 1) this.#zones.set(id, rings[0]);
    else this.note(`zone ${id} is not in its fence: it has holes`);
  }

  lift({ id }) {
    this.#zones.delete(id);
    this.#isTold.delete(id);
  }

  /**
   * [id, outline] of those that are to be in its fence while it is there. A zone around it is not: it has to be let out of it.
   */
  around(place) {
    if (!this.isAny) return [];
    let left = this.room;
    return [...this.#zones].filter(([id, outline]) => {
      if (holds(outline, place)) return false;
      const fits = outline.length <= left;
      if (fits) left -= outline.length;
      else if (!this.#isTold.has(id)) this.note(`zone ${id} is not in its fence: it has ${outline.length} corners, and there is room for ${left}`);
      if (!fits) this.#isTold.add(id);
      return fits;
    });
  }
}
