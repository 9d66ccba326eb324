// What a metre of the mission's range takes of a UAV's battery, measured. The mission counts the metres of ways, and sensing as the
// metres that would be flown meanwhile. The battery also pays for take-offs, for waiting in the air and for wind.

/** Batteries are told in whole percents: less than this is not measured. */
const LEAST_PERCENT = 5;

export class Use {
  #all = { percent: 0, m: 0 };
  #battery = { percent: 0, m: 0 };  // since it was changed
  #percent = null;
  /** 0: nothing is measured yet. */
  percent_m = 0;

  /** The battery has so many percent now. */
  hear(percent) {
    if (this.#percent !== null) this.#add({ percent: Math.max(0, this.#percent - percent), m: 0 });
    this.#percent = percent;
  }

  /** The mission counts so many metres. */
  count(m) {
    this.#add({ percent: 0, m });
  }

  #add(used) {
    for (const sum of [this.#all, this.#battery]) for (const key of Object.keys(sum)) sum[key] += used[key];
  }

  /** A way and what was done at its end are over: it counts what was dearer, this battery so far or all of them. */
  settle() {
    const each = [this.#all, this.#battery].filter(({ percent, m }) => percent >= LEAST_PERCENT && m > 0).map(({ percent, m }) => percent / m);
    if (each.length) this.percent_m = Math.max(...each);
  }

  /** Another battery is in. */
  begin() {
    this.#battery = { percent: 0, m: 0 };
    this.#percent = null;
  }
}
