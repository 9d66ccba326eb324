// What ends a flight, and who is in command. Checked at every message and at least ten times a second; never asks or sends.
import { Trouble } from "./talk.mjs";

/** Nothing at all from the autopilot, or no heartbeat, for so long: the link is lost. It sends five places a second, and a
 * heartbeat each second. */
const SILENT_S = 3;
const NO_HEARTBEAT_S = 5;
/** No place, or a fix of less than three dimensions, or no estimate of the place, for so long. */
const NO_PLACE_S = 3;
/** No word of the battery for so long. */
const NO_BATTERY_S = 10;
/** Volts of a cell in flight, below which it comes home, and below which it lands, if that lasts for so long. Source: ours. */
const LOW_V = 3.4, CRITICAL_V = 3.25, LOW_V_S = 3;
/** When we have stood still for so long, what was sent meanwhile is heard first, for so long; and not again for a while. */
const STALL_S = 0.5, CATCH_UP_S = 0.5, STALL_AGAIN_S = 3;
/** It is never told to go down so fast. */
const FALL_M_S = 4, FALL_S = 0.3;
/** Why it does something by itself is said in words, so much later. */
const WORDS_S = 0.5;

/** What a Trouble says, as a plain object: check() looks at every step, and an Error takes long to make. */
const wrong = (message, then = "home") => ({ message, then });

/** What it is doing: who may be in command, and what is watched, depend on it. */
export const Phase = { ground: "ground", fly: "fly", land: "land", home: "home" };

export class Safety {
  phase = Phase.ground;
  /** On the ground, for somebody to change the battery: the power may be cut. */
  isServiced = false;
  /** We are about to start its motors. */
  isArming = false;
  /** Somebody else is in command: for good. */
  isOff = false;

  constructor({ vehicle, now, patience, reserve_percent }) {
    Object.assign(this, { vehicle, now, patience, reserve_percent });
  }

  #since = {};

  /** Since when that is so, without a break; null: it is not. */
  #sinceWhen(name, isSo) {
    this.#since[name] = isSo ? this.#since[name] ?? this.now() : null;
    return this.#since[name];
  }

  #looked_s = null;
  #caughtUp_s = -Infinity;

  /** To be called often: notices when this program itself stood still, on a busy machine, and takes that for nobody's silence. */
  look() {
    const now = this.now();
    const hasStalled = this.#looked_s !== null && now - this.#looked_s > this.patience(STALL_S);
    this.#looked_s = now;
    if (hasStalled && now - this.#caughtUp_s > this.patience(STALL_AGAIN_S)) this.#caughtUp_s = now + this.patience(CATCH_UP_S);
  }

  get #isCatchingUp() {
    return this.now() < this.#caughtUp_s;
  }

  /** Why nothing may be commanded now; null: it may. */
  mayCommand() {
    const why = this.isOff ? wrong("somebody else is in command", "off") : this.#otherCommand();
    return why && new Trouble(why.message, why.then);
  }

  /** What is wrong: {message, then} as of a Trouble; null: nothing. `area`, `map`: once they are known. */
  check(area, map) {
    return this.#otherCommand(true) ?? this.#link() ?? (this.phase === Phase.ground ? null : this.#flight(area, map));
  }

  get isLinked() {
    return this.#silence === null;
  }

  /** It will not come home with what its battery still has. */
  get isCritical() {
    const { cell_v } = this.vehicle;
    return this.#is(this.#sinceWhen("critical", cell_v !== null && cell_v < CRITICAL_V), LOW_V_S);
  }

  #is(since_s, limit_s) {
    return since_s !== null && this.now() - since_s > this.patience(limit_s);
  }

  /** Somebody flies it, or it flies by itself: not as we have told it. `isPatient`: its words may still come. */
  #otherCommand(isPatient = false) {
    const { vehicle, phase } = this;
    if (!vehicle.armed || !vehicle.kind) return null;
    if (phase === Phase.ground) return this.isArming ? null : wrong("it was armed, not by us", "off");
    const isOther = !vehicle.kind.modes[phase].includes(vehicle.mode);
    const other_s = this.#sinceWhen("other", isOther);
    if (!isOther) return null;
    const words = vehicle.words(this.now());
    const why = words ? ` (${words})` : "";
    if (isPatient && !words && vehicle.kind.modes.itself.includes(vehicle.mode) && !this.#is(other_s, WORDS_S)) return null;
    return vehicle.kind.modes.itself.includes(vehicle.mode)
      ? wrong(`it went to ${vehicle.modeName} by itself${why}`, "off")
      : wrong(`the pilot has taken over: ${vehicle.modeName}${why}`, "off");
  }

  #link() {
    const words = this.#silence;
    return words && wrong(`its link is lost: ${words}`);
  }

  /** What is not heard; null: nothing. */
  get #silence() {
    const { vehicle } = this;
    if (!vehicle.kind || this.isServiced || this.#isCatchingUp) return null;
    if (this.#is(vehicle.heard_s, SILENT_S)) return `nothing heard for ${SILENT_S} s`;
    if (this.#is(vehicle.heartbeat_s, NO_HEARTBEAT_S)) return `no heartbeat for ${NO_HEARTBEAT_S} s`;
    return null;
  }

  #flight(area, map) {
    const { vehicle } = this;
    if (!vehicle.armed && this.phase === Phase.fly) return wrong("it has disarmed in flight", "off");
    const { place_s, badFix_s, badEstimate_s } = vehicle;
    const isLong = this.#is(place_s, NO_PLACE_S) || this.#is(badFix_s, NO_PLACE_S) || this.#is(badEstimate_s, NO_PLACE_S);
    const isLost = isLong && !this.#isCatchingUp;
    if (this.#is(this.#sinceWhen("falls", this.phase === Phase.fly && vehicle.down_m_s > FALL_M_S), FALL_S)) {
      return wrong(`it falls at ${vehicle.down_m_s.toFixed(0)} m/s`, "land");
    }
    if (vehicle.thrustWords) return wrong(`its thrust is lost, it says: ${vehicle.thrustWords}`, "land");
    if (isLost) return wrong(`its position is lost for ${NO_PLACE_S} s`, "land");
    if (vehicle.isBreached) return wrong("its fence is touched, it says");
    if (area.isOut(map.toMetres(vehicle.place), vehicle.altitude_m)) return wrong("it is outside the area");
    if (vehicle.battery_percent <= this.reserve_percent) {
      return wrong(`its battery is low: ${vehicle.battery_percent} %, and ${this.reserve_percent} % are the reserve`);
    }
    const { cell_v } = vehicle;
    if (this.#is(this.#sinceWhen("low", cell_v !== null && cell_v < LOW_V), LOW_V_S)) {
      return wrong(`its battery is low: ${cell_v.toFixed(2)} V a cell, at least ${LOW_V.toFixed(2)} in flight`);
    }
    return !this.#isCatchingUp && this.#is(vehicle.battery_s, NO_BATTERY_S) ? wrong(`nothing is heard of its battery for ${NO_BATTERY_S} s`) : null;
  }
}
