// What an autopilot has told of itself. Values that cannot be are passed over.
import { autopilotOf } from "./autopilots.mjs";

const ARMED = 128;
/** Copters of MAV_TYPE: quad-, coaxial, helicopter, hexa-, octo-, tri-, dodecacopter. */
const COPTERS = [2, 3, 4, 13, 14, 15, 29];
const AUTOPILOT_COMPONENT = 1;
/** Bit of a position over ground, in EKF_STATUS_REPORT and ESTIMATOR_STATUS alike. */
const HAS_POSITION = 16;
const TEXT_S = 5;
/** Of MAV_SYS_STATUS_SENSOR: it may be armed. */
const PREARM_CHECK = 0x10000000;
const UNKNOWN_MV = 65535;

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
  cells = 0;            // of its battery, in series; 0: not known
  volts = null;         // of its battery
  hasEstimate = null;   // of its place; null: it has not said yet
  isArmable = null;     // its own checks before arming; null: it does not say
  satellites = null;
  down_m_s = 0;
  thrustWords = "";     // that it has lost some
  isBreached = false;   // its own fence
  altitude_amsl_m = 0;  // above the sea
  heard_s = -Infinity;  // when anything, and when that
  heartbeat_s = -Infinity;
  place_s = -Infinity;
  battery_s = -Infinity;
  badFix_s = null;      // since when
  hasFix = false;
  badEstimate_s = null;
  #texts = [];
  #heard = new Map();   // name -> seconds

  constructor(system) {
    this.system = system;
    this.otherSystem = null;  // another autopilot that is heard
  }

  /** Takes a message; returns whether it is one of this autopilot. */
  hear({ system, component, name, message }, now) {
    if (component !== AUTOPILOT_COMPONENT) return false;
    if (system !== this.system) {
      this.otherSystem = system;
      return false;
    }
    this.heard_s = now;
    this.#heard.set(name, now);
    this.#take[name]?.(message, now);
    return true;
  }

  /** When such a message was heard last; null: never. */
  heardOf(name) {
    return this.#heard.get(name) ?? null;
  }

  /** Volts of each cell; null: not known. */
  get cell_v() {
    return this.cells > 0 && this.volts !== null ? this.volts / this.cells : null;
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
    this.place = this.battery_percent = this.home = this.volts = this.hasEstimate = this.isArmable = null;
    this.badFix_s = this.badEstimate_s = null;
    this.hasFix = false;
    this.thrustWords = "";
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
      this.down_m_s = message.vz / 100;
      this.place_s = now;
    },
    GPS_RAW_INT: (message, now) => {
      this.hasFix = message.fixType >= 3;
      this.satellites = message.satellitesVisible === 255 ? null : message.satellitesVisible;
      this.badFix_s = this.hasFix ? null : this.badFix_s ?? now;
    },
    EKF_STATUS_REPORT: (message, now) => this.#estimate(message.flags, now),
    ESTIMATOR_STATUS: (message, now) => this.#estimate(message.flags, now),
    SYS_STATUS: (message, now) => {
      this.#battery(message.batteryRemaining, now);
      if (message.voltageBattery > 0 && message.voltageBattery < UNKNOWN_MV) this.volts = message.voltageBattery / 1000;
      const { onboardControlSensorsPresent: present, onboardControlSensorsHealth: health } = message;
      this.isArmable = present & PREARM_CHECK ? (health & PREARM_CHECK) !== 0 : null;
    },
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
      if (message.severity > 5 || !words) return;  // up to notices
      if (/thrust loss|motor (failure|fail|lost)/i.test(words)) this.thrustWords = words;
      if (this.#texts.at(-1)?.words === words) this.#texts.pop();
      this.#texts.push({ words, at: now });
      if (this.#texts.length > 4) this.#texts.shift();
    },
  };

  #estimate(flags, now) {
    this.hasEstimate = (flags & HAS_POSITION) !== 0;
    this.badEstimate_s = this.hasEstimate ? null : this.badEstimate_s ?? now;
  }

  #battery(percent, now) {
    if (percent < 0 || percent > 100) return;  // -1: it does not know
    this.battery_percent = percent;
    this.battery_s = now;
  }
}
