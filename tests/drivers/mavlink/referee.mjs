// What a mission knows of a measured UAV, and holds against what it says (model/measured.cc): speed, and range from nowhere.

const SENSING_COST_M = 400;

export class Referee {
  wrong = [];
  #commands = new Map();

  constructor(hello) {
    this.hello = hello;
    this.seen = { at: hello.at, at_s: hello.mission_s, range_m: hello.range_m };
    this.anchor = this.seen;
  }

  /** It is told that, then. */
  told(line, now) {
    if (line.type === "time") this.tick_s = now;
    if (line.id === undefined || line.type === "cancel") return;
    this.#commands.set(line.id, line);
    if (line.type === "goto") this.anchor = this.seen;
    if (line.type !== "goto") this.range_before_m = this.seen.range_m;
  }

  /** It says that, then. */
  hear(line, now) {
    const command = this.#commands.get(line.id);
    if (line.type === "state") this.#state(line, now);
    if (line.type === "arrived") this.seen = { at: command.to, at_s: now, range_m: this.#most(command.to) };
    if (line.type === "done") this.#done(line, command, now);
  }

  #most(at) {
    return Math.min(...[this.seen, this.anchor].map((known) => Math.max(0, known.range_m - distance(known.at, at))));
  }

  #range(range_m, most_m) {
    if (range_m > most_m + this.hello.speed_m_s) this.wrong.push(`a range of ${range_m} m, at most ${most_m} m can be left`);
  }

  #state({ at, mission_s, range_m }, now) {
    if (mission_s < this.seen.at_s) return;  // old
    if (mission_s > now + 1.25) this.wrong.push(`its state is of ${mission_s} s, and it is ${now} s`);
    for (const known of [this.seen, this.anchor]) {
      const way_m = distance(known.at, at), time_s = mission_s - known.at_s;
      if (way_m > this.hello.speed_m_s * (time_s + 1)) this.wrong.push(`${way_m} m in ${time_s} s are too fast`);
    }
    const most_m = this.#most(at);
    if (range_m !== undefined) this.#range(range_m, most_m);
    this.seen = { at, at_s: mission_s, range_m: range_m ?? most_m };
  }

  #done({ range_m }, command, now) {
    let most_m = this.seen.range_m, computed_m = Math.max(0, this.seen.range_m - SENSING_COST_M);
    if (command.type === "charge") {
      // It is expected to end at the next tick, when it has not said so by the last.
      const end_s = Math.max(command.mission_s + command.for_s, (this.tick_s ?? 0) + 30);
      const part = Math.min(1, (now - command.mission_s) / (end_s - command.mission_s));
      most_m = computed_m = this.range_before_m + (this.hello.full_range_m - this.range_before_m) * part;
    }
    if (range_m !== undefined) this.#range(range_m, most_m);
    this.seen = { ...this.seen, range_m: range_m ?? computed_m };
    this.anchor = this.seen;
  }
}

function distance(a, b) {
  return Math.hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}
