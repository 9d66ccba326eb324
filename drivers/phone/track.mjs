// Where the mission is told that it is. A mission takes whoever is faster than the agent's speed for impossible, and out; a
// person in a car, or a place that jumps, is told as far as the speed allows, and the rest with the time.
import { distance_m, towards } from "../places.mjs";

/** A place that is no older, by the wall, is one of now. */
const FRESH_S = 5;
/** The mission hears of an arrival so much later, by the wall, than we say it. */
const HEARD_S = 0.25;
/** Places outside the area by more are not told; the mission allows 10 m. */
const OUTSIDE_M = 5;

export class Track {
  /** It has not been told yet that it is where it is, as that needs a higher speed. */
  isLimited = false;
  #fix = null;  // {at, mission_s} seen last, and not told yet
  #isArrived = false;  // since the last tick

  /** `hello`: of docs/guide/drivers.md. */
  constructor(hello) {
    this.speed_m_s = hello.speed_m_s;
    this.rate = hello.rate ?? 0;
    this.area = hello.area;
    /** What the mission knows, of when. */
    this.last = { at: { x_m: hello.at.x_m, y_m: hello.at.y_m }, mission_s: hello.mission_s };
  }

  isOutside({ x_m, y_m }) {
    return !(x_m >= -OUTSIDE_M && y_m >= -OUTSIDE_M && x_m <= this.area.width_m + OUTSIDE_M && y_m <= this.area.height_m + OUTSIDE_M);
  }

  /** It was there then. The caller has looked that it is not outside. */
  see(at, mission_s) {
    if (mission_s < (this.#fix ?? this.last).mission_s) return;
    this.#fix = { at, mission_s };
  }

  /** When it can be there at its speed. */
  soonest_s(to) {
    return this.last.mission_s + distance_m(this.last.at, to) / this.speed_m_s;
  }

  /** The mission was told that it has arrived there. */
  arrive(at, mission_s) {
    this.last = { at, mission_s };
    this.#fix = null;
    this.#isArrived = true;
    this.isLimited = false;
  }

  /** It was at work up to then, and went nowhere. */
  stay(mission_s) {
    this.last = { at: this.last.at, mission_s: Math.max(mission_s, this.last.mission_s) };
    this.#fix = null;
  }

  /** What was seen and is not told yet is not so. */
  forget() {
    this.#fix = null;
    this.isLimited = false;
  }

  /**
   * What to say at the tick of `mission_s`: {at, mission_s}. Where nothing newer is known, what was said last, of that time: the
   * mission expects it to go on as planned.
   */
  tell(mission_s) {
    if (this.#isArrived) {
      // The mission takes it for there up to now.
      this.#isArrived = false;
      this.last.mission_s = mission_s + HEARD_S * this.rate;
      return { at: this.last.at, mission_s };
    }
    const fix = this.#fix;
    if (!fix) return { at: this.last.at, mission_s: Math.min(mission_s, this.last.mission_s) };
    const soonest_s = this.soonest_s(fix.at);
    this.isLimited = soonest_s > mission_s;
    if (this.isLimited) {
      const way_m = this.speed_m_s * Math.max(0, mission_s - this.last.mission_s);
      this.last = { at: towards(this.last.at, fix.at, way_m), mission_s: Math.max(mission_s, this.last.mission_s) };
      return { at: this.last.at, mission_s };
    }
    const isFresh = mission_s - fix.mission_s <= FRESH_S * this.rate;
    this.last = { at: fix.at, mission_s: isFresh ? mission_s : Math.min(mission_s, Math.max(fix.mission_s, soonest_s)) };
    this.#fix = null;
    return { ...this.last };
  }
}
