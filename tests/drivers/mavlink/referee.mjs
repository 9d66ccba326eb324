// What a mission knows of a measured UAV, and holds against what it says (model/measured.cc): speed, and range from nowhere. It
// takes what was said when a tick is answered, and nothing as of a later time than that tick.

const SENSING_COST_M = 400;

export class Referee {
  wrong = [];
  #commands = new Map();
  #said = [];  // since the last tick
  #isAnswered = true;
  #told_at = 0;

  constructor(hello) {
    this.hello = hello;
    this.tick_s = hello.mission_s;
    this.taken = { at: hello.at, at_s: hello.mission_s };
    this.seen = { at: hello.at, at_s: hello.mission_s, range_m: hello.range_m };
    this.anchor = this.seen;
  }

  /** It is told that, then. */
  told(line, now) {
    if (line.type === "time") {
      this.tick_s = line.mission_s;
      this.#told_at = now;
      this.#isAnswered = false;
    }
    if (line.id === undefined || line.type === "cancel") return;
    this.#commands.set(line.id, line);
    if (line.type === "goto") this.anchor = this.seen;
    if (line.type !== "goto") this.range_before_m = this.seen.range_m;
  }

  /** It says that, then. */
  hear(line, now) {
    const command = this.#commands.get(line.id), mission_s = this.tick_s + now - this.#told_at;
    if (line.type === "state") this.#state(line, mission_s);
    if (line.type === "arrived") this.seen = { at: command.to, at_s: mission_s, range_m: this.#most(command.to) };
    if (line.type === "done") this.#done(line, command, mission_s);
    if (line.type === "state") this.#said.push({ at: line.at, at_s: line.mission_s });
    if (line.type === "arrived") this.#said.push({ at: command.to, at_s: mission_s, isWord: true });
    if (line.type !== "state" || this.#isAnswered || line.mission_s < this.tick_s - 1) return;
    this.#isAnswered = true;
    for (const said of this.#said.splice(0)) this.#takeAtTick(said);
  }

  #takeAtTick({ at, at_s, isWord }) {
    const { taken } = this;
    const by_s = Math.min(this.tick_s, isWord ? Math.max(at_s, taken.at_s) : at_s);
    if (by_s < taken.at_s) return;  // old
    const way_m = distance(taken.at, at), time_s = by_s - taken.at_s;
    if (way_m > this.hello.speed_m_s * (time_s + 1)) this.wrong.push(`at its tick ${this.tick_s} s: ${way_m} m in ${time_s} s are too fast`);
    this.taken = { at, at_s: by_s };
  }

  #most(at) {
    return Math.min(...[this.seen, this.anchor].map((known) => Math.max(0, known.range_m - distance(known.at, at))));
  }

  #range(range_m, most_m) {
    if (range_m > most_m + this.hello.speed_m_s) this.wrong.push(`a range of ${range_m} m, at most ${most_m} m can be left`);
  }

  #state({ at, mission_s, range_m }, now) {
    if (mission_s < this.seen.at_s) return;  // old
    if (mission_s > now + 1 + 0.25 * (this.hello.rate ?? 1)) this.wrong.push(`its state is of ${mission_s} s, and it is ${now} s`);
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
