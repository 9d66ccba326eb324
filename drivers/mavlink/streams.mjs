// Messages that the autopilot is to send again and again. It forgets that with its power, so what stops is asked for again.
import { common } from "./frames.mjs";

const { MavCmd } = common;
const PLACE_US = 200_000, SECOND_US = 1_000_000;
/** So long after a message was heard last it is asked for, and then again after so long. */
const STOPPED_S = 3, AGAIN_S = 2;
/** The autopilot is there. */
const ALIVE_S = 2;

export class Streams {
  isOn = false;
  #alive_s = null;     // since when it is heard without a break
  #asked = new Map();  // id -> seconds
  #kind = null;        // of which that is wanted
  #wanted = null;

  constructor({ talk, vehicle }) {
    Object.assign(this, { talk, vehicle });
  }

  /** [id, name, interval in microseconds, whether there is no flight without]: place, battery (twice), fix, fence, estimate. */
  get wanted() {
    const { kind } = this.vehicle;
    if (kind !== this.#kind) [this.#kind, this.#wanted] = [kind, this.#wantedOf(kind)];
    return this.#wanted;
  }

  #wantedOf(kind) {
    return [
      [33, "GLOBAL_POSITION_INT", PLACE_US, true], [1, "SYS_STATUS", SECOND_US, true], [147, "BATTERY_STATUS", SECOND_US, false],
      [24, "GPS_RAW_INT", SECOND_US, true], [162, "FENCE_STATUS", SECOND_US, false],
      [kind.estimateMessage, kind.estimateName, SECOND_US, true],
    ];
  }

  /** Asks for what has stopped. Sends only; whether it helps is heard. */
  step() {
    const { vehicle, talk } = this, now = talk.now();
    const isAlive = vehicle.kind && now - vehicle.heartbeat_s <= talk.patience(ALIVE_S);
    this.#alive_s = isAlive ? this.#alive_s ?? now : null;
    if (!this.isOn || !isAlive) return;
    for (const [id, name, interval_us, isNeeded] of this.wanted) {
      const heard_s = vehicle.heardOf(name);
      if (!isNeeded && heard_s === null) continue;  // it does not have it
      const asked_s = this.#asked.get(id) ?? -Infinity;
      if (now - Math.max(heard_s ?? 0, this.#alive_s) <= talk.patience(STOPPED_S) || now - asked_s < talk.patience(AGAIN_S)) continue;
      this.#asked.set(id, now);
      talk.sendTo(common.CommandLong, { command: MavCmd.SET_MESSAGE_INTERVAL, confirmation: 0, _param1: id, _param2: interval_us });
    }
  }
}
