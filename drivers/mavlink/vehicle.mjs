// What an autopilot has told of itself. Values that cannot be are passed over.
import { autopilotOf } from "./autopilots.mjs";

const ARMED = 128;
/** Copters of MAV_TYPE: quad-, coaxial, helicopter, hexa-, octo-, tri-, dodecacopter. */
const COPTERS = [2, 3, 4, 13, 14, 15, 29];
const AUTOPILOT_COMPONENT = 1;
/** Bit of a position over ground, in EKF_STATUS_REPORT and ESTIMATOR_STATUS alike. */
const HAS_POSITION = 16;
const TEXT_S = 5;

export class Vehicle {
  kind = null;          // what it is of autopilots.mjs
  isCopter = false;
  armed = false;
  mode = null;          // custom_mode
  place = null;         // {latitude_deg, longitude_deg}
  altitude_m = 0;       // above home
  speed_m_s = 0;        // over ground
  home = null;          // {latitude_deg, longitude_deg, altitude_m above the sea}
  battery_percent = null;
  isBreached = false;   // its own fence
  altitude_amsl_m = 0;  // above the sea
  heard_s = -Infinity;  // when anything, and when that
  heartbeat_s = -Infinity;
  place_s = -Infinity;
  battery_s = -Infinity;
  badFix_s = null;      // since when
  badEstimate_s = null;
  #texts = [];

  constructor(system) {
    this.system = system;
  }

  /** Takes a message; returns whether it is one of this autopilot. */
  hear({ system, component, name, message }, now) {
    if (system !== this.system || component !== AUTOPILOT_COMPONENT) return false;
    this.heard_s = now;
    this.#take[name]?.(message, now);
    return true;
  }

  get modeName() {
    return this.mode === null ? "none" : this.kind.modeName(this.mode);
  }

  /** What it has said of late in words: why it refuses, which failsafe acts. "": nothing. */
  words(now) {
    return this.#texts.filter((text) => now - text.at < TEXT_S).map((text) => text.words).join("; ");
  }

  /** Everything that may be of before its power was cut is to be heard again. */
  forget() {
    this.place = this.battery_percent = this.home = null;
    this.badFix_s = this.badEstimate_s = null;
    this.isBreached = false;
  }

  #take = {
    HEARTBEAT: (message, now) => {
      const kind = autopilotOf(message.autopilot);
      if (!kind) return;
      this.kind = kind;
      this.isCopter = COPTERS.includes(message.type);
      this.armed = (message.baseMode & ARMED) !== 0;
      this.mode = message.customMode;
      this.heartbeat_s = now;
    },
    GLOBAL_POSITION_INT: (message, now) => {
      const isNone = message.lat === 0 && message.lon === 0;
      if (isNone || Math.abs(message.lat) > 90e7 || Math.abs(message.lon) > 180e7) return;
      this.place = { latitude_deg: message.lat / 1e7, longitude_deg: message.lon / 1e7 };
      this.altitude_m = message.relativeAlt / 1000;
      this.altitude_amsl_m = message.alt / 1000;
      this.speed_m_s = Math.hypot(message.vx, message.vy) / 100;
      this.place_s = now;
    },
    GPS_RAW_INT: (message, now) => {
      this.badFix_s = message.fixType >= 3 ? null : this.badFix_s ?? now;
    },
    EKF_STATUS_REPORT: (message, now) => this.#estimate(message.flags, now),
    ESTIMATOR_STATUS: (message, now) => this.#estimate(message.flags, now),
    SYS_STATUS: (message, now) => this.#battery(message.batteryRemaining, now),
    BATTERY_STATUS: (message, now) => {
      if (message.id === 0) this.#battery(message.batteryRemaining, now);
    },
    HOME_POSITION: (message) => {
      if (message.latitude === 0 && message.longitude === 0) return;
      this.home = { latitude_deg: message.latitude / 1e7, longitude_deg: message.longitude / 1e7, altitude_m: message.altitude / 1000 };
    },
    FENCE_STATUS: (message) => {
      this.isBreached = message.breachStatus !== 0;
    },
    STATUSTEXT: (message, now) => {
      const words = String(message.text).replace(/[^\x20-\x7e]/g, "").trim();
      if (message.severity > 4 || !words) return;  // up to warnings
      if (this.#texts.at(-1)?.words !== words) this.#texts.push({ words, at: now });
      if (this.#texts.length > 4) this.#texts.shift();
    },
  };

  #estimate(flags, now) {
    this.badEstimate_s = flags & HAS_POSITION ? null : this.badEstimate_s ?? now;
  }

  #battery(percent, now) {
    if (percent < 0 || percent > 100) return;  // -1: it does not know
    this.battery_percent = percent;
    this.battery_s = now;
  }
}
