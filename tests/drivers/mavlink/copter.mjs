// A copter to test with: simple in how it flies, honest in what it does by itself. What it says is in copter_protocol.mjs.
// As its models, ArduPilot's Copter and PX4, it does not trust whoever commands it. Time is given to it; seconds and metres.

const G_M = 6378137, E2 = 0.00669437999014;
const STEP_S = 0.1;
const ACCELERATION = 2.5, UP_M_S = 2.5, DOWN_M_S = 1.5, LAND_M_S = 0.5, LAND_BELOW_M = 10;
const CAPACITY_MAH = 5000, CELLS = 4;
/** Of a cell that is full and one that is empty, at rest; and what the motors take off it. */
const FULL_V = 4.2, EMPTY_V = 3.5, SAG_V = 0.1;
const TOUCHED_S = 2, UNUSED_S = 10;

/** Modes: what it does in them, and their numbers. `pilot`: somebody holds the sticks. */
export const MODES = {
  ardupilot: { STABILIZE: 0, GUIDED: 4, LOITER: 5, RTL: 6, LAND: 9, BRAKE: 17 },
  px4: { POSCTL: 3 << 16, TAKEOFF: (4 << 16) | (2 << 24), GUIDED: (4 << 16) | (3 << 24), RTL: (4 << 16) | (5 << 24), LAND: (4 << 16) | (6 << 24) },
};
export const PILOT_MODES = ["STABILIZE", "LOITER", "POSCTL"];

/** What its maker has set: not what a mission wants. */
const SETTINGS = {
  ardupilot: {
    SYSID_MYGCS: 255, FS_GCS_ENABLE: 0, FS_GCS_TIMEOUT: 5, FS_OPTIONS: 0, FS_EKF_ACTION: 1, BATT_FS_LOW_ACT: 0, BATT_FS_CRT_ACT: 0, BATT_LOW_MAH: 0,
    BATT_LOW_VOLT: 10.5, BATT_CRT_VOLT: 0,
    BATT_CAPACITY: CAPACITY_MAH, RTL_ALT: 1500, WPNAV_SPEED: 1200, CAM1_TYPE: 1, OA_TYPE: 0, FENCE_ENABLE: 0, FENCE_ACTION: 1, FENCE_TYPE: 7, FENCE_ALT_MAX: 100,
  },
  px4: {
    NAV_DLL_ACT: 0, COM_DL_LOSS_T: 10, COM_RC_OVERRIDE: 0, COM_LOW_BAT_ACT: 0, BAT_CRIT_THR: 0.07, BAT_LOW_THR: 0.15, RTL_TYPE: 1, RTL_CONE_ANG: 45,
    RTL_RETURN_ALT: 60, RTL_LAND_DELAY: -1, MPC_XY_CRUISE: 12, GF_MAX_VER_DIST: 0, GF_ACTION: 2,
  },
};

function isInside(corners, { east, north }) {
  let isIn = false, a = corners.at(-1);
  for (const b of corners) {
    if (a.north > north !== b.north > north && east < ((b.east - a.east) * (north - a.north)) / (b.north - a.north) + a.east) isIn = !isIn;
    a = b;
  }
  return isIn;
}

export class Copter {
  /** `kind`: "ardupilot" or "px4". `at`: {latitude_deg, longitude_deg} of where it stands. `hover`: in one place it uses so many times as much. */
  constructor({ kind = "ardupilot", at, now = 0, drain_percent_s = 0.02, unused_s = UNUSED_S, ready_s = 0, hover = 1 }) {
    Object.assign(this, { kind, origin: at, now, drain_percent_s, unused_s, ready_s, hover });
    const s = Math.sin((at.latitude_deg * Math.PI) / 180), w = 1 - E2 * s * s, degree = Math.PI / 180;
    this.scale = { north: (G_M * (1 - E2)) / w ** 1.5 * degree, east: (G_M / Math.sqrt(w)) * Math.sqrt(1 - s * s) * degree };
    this.settings = Object.fromEntries(Object.entries(SETTINGS[kind]).map(([name, value]) => [name, Math.fround(value)]));
    this.at = { east: 0, north: 0, up: 0 };
    this.speed = { east: 0, north: 0 };
    this.home = null;
    this.isHomeSet = false;
    this.battery_percent = 100;  // that it counts from when its power came on: it takes what is plugged in for full
    this.charge_percent = 100;   // that the battery truly has
    this.cell_v = null;          // of each cell; null: by its charge
    this.fall_m_s = 0;           // with a motor gone
    this.up_m_s = UP_M_S;
    this.hasFix = true;
    this.fence = [];
    this.photos = [];
    this.breaches = 0;
    this.texts = [];
    this.history = [];  // [seconds, mode] of each change
    this.boot(now);
  }

  /** As after its power came back. */
  boot(now) {
    this.battery_percent = 100;
    Object.assign(this, { booted: now, armed: false, target: null, home: null, isHomeSet: false, partner_s: null, isOutside: false });
    this.setMode(this.kind === "px4" ? "POSCTL" : "STABILIZE");
  }

  setMode(name) {
    if (this.mode === name) return;
    this.mode = name;
    this.target = name === "RTL" ? { ...this.toMetres(this.home ?? this.origin), up: Math.max(this.at.up, this.returnAltitude) } : null;
    this.isDescending = false;
    this.history.push([this.now, name]);
  }

  /** Its estimator takes so long after its power came on. */
  get isEstimating() {
    return this.hasFix && this.now - this.booted >= this.ready_s;
  }

  get volts() {
    const cell_v = this.cell_v ?? EMPTY_V + ((FULL_V - EMPTY_V) * this.charge_percent) / 100;
    return CELLS * (cell_v - (this.armed ? SAG_V : 0));
  }

  get customMode() {
    return MODES[this.kind][this.mode];
  }

  get isPiloted() {
    return PILOT_MODES.includes(this.mode);
  }

  get isLanded() {
    return this.at.up < 0.05;
  }

  get returnAltitude() {
    return this.kind === "px4" ? this.settings.RTL_RETURN_ALT : this.settings.RTL_ALT / 100;
  }

  get cruise_m_s() {
    return this.kind === "px4" ? this.settings.MPC_XY_CRUISE : this.settings.WPNAV_SPEED / 100;
  }

  get place() {
    return this.toDegrees(this.at);
  }

  toDegrees({ east, north }) {
    return { latitude_deg: this.origin.latitude_deg + north / this.scale.north, longitude_deg: this.origin.longitude_deg + east / this.scale.east };
  }

  toMetres({ latitude_deg, longitude_deg }) {
    return { east: (longitude_deg - this.origin.longitude_deg) * this.scale.east, north: (latitude_deg - this.origin.latitude_deg) * this.scale.north };
  }

  say(words, severity = 4) {
    this.texts.push({ words, severity });
  }

  /** Why it does not arm; "": it does. */
  get notReady() {
    if (!this.isEstimating) return "PreArm: Need Position Estimate";
    if (this.battery_percent < 10) return "PreArm: Battery below minimum";
    if (this.fenceEnabled && this.fence.length && !this.isInFence(this.at)) return "PreArm: Vehicle breaching Polygon fence";
    return "";
  }

  arm() {
    this.armed = true;
    this.armed_s = this.now;
    this.landed_s = null;
    if (!this.isHomeSet || this.kind === "px4") this.home = { ...this.place, up: 0 };  // PX4 takes it whatever it was told
  }

  get fenceEnabled() {
    return this.kind === "px4" ? this.settings.GF_ACTION > 0 : this.settings.FENCE_ENABLE !== 0;
  }

  isInFence({ east, north, up = 0 }) {
    const ceiling = this.kind === "px4" ? this.settings.GF_MAX_VER_DIST || Infinity : this.settings.FENCE_ALT_MAX;
    if (up > ceiling) return false;
    return this.polygons.every(({ isOut, corners }) => isOut !== isInside(corners, { east, north }));
  }

  /** Of its fence: an item says how many corners its polygon has. `isOut`: it has to stay out of it. */
  get polygons() {
    if (this.#known?.fence !== this.fence) this.#known = { fence: this.fence, polygons: this.#readFence() };
    return this.#known.polygons;
  }

  #known = null;  // polygons of the fence that it had last

  #readFence() {
    const polygons = [];
    for (let i = 0; i < this.fence.length; i += this.fence[i].param1) {
      const items = this.fence.slice(i, i + this.fence[i].param1);
      const corners = items.map((item) => this.toMetres({ latitude_deg: item.x / 1e7, longitude_deg: item.y / 1e7 }));
      polygons.push({ isOut: items[0].command === 5002, corners });
    }
    return polygons;
  }

  /** Goes on until that time. */
  step(now) {
    while (this.now < now - 1e-9) {
      const dt = Math.min(STEP_S, now - this.now);
      this.now += dt;
      if (!this.home && this.isEstimating) this.home = { ...this.place, up: 0 };  // until it is set, or armed elsewhere
      if (!this.armed) continue;
      const used = this.drain_percent_s * dt * (Math.hypot(this.speed.east, this.speed.north) < 1 ? this.hover : 1);
      this.battery_percent = Math.max(0, this.battery_percent - used);
      this.charge_percent = Math.max(0, this.charge_percent - used);
      this.#failsafes();
      this.#fly(dt);
      this.#disarm();
    }
  }

  #failsafes() {
    const set = this.settings, isArdu = this.kind === "ardupilot";
    const silence = this.partner_s === null ? 0 : this.now - this.partner_s;
    const isSilent = isArdu ? set.FS_GCS_ENABLE === 1 && silence > set.FS_GCS_TIMEOUT : set.NAV_DLL_ACT === 2 && silence > set.COM_DL_LOSS_T;
    const leavesPilot = isArdu && (set.FS_OPTIONS & 16) !== 0;  // PX4 has no such option
    if (isSilent && !(this.isPiloted && leavesPilot)) this.#getOut("RTL", "GCS Failsafe");
    const low = isArdu ? (100 * set.BATT_LOW_MAH) / CAPACITY_MAH : 100 * set.BAT_CRIT_THR;
    const actsOnLow = isArdu ? set.BATT_FS_LOW_ACT === 2 : set.COM_LOW_BAT_ACT === 3;
    if (this.battery_percent < low && actsOnLow && !this.isPiloted) this.#getOut("RTL", "Battery 1 is low");
    const landsUnfixed = !isArdu || set.FS_EKF_ACTION === 1;
    if (!this.hasFix && landsUnfixed && !this.isPiloted) this.#getOut("LAND", "EKF Failsafe: changed to LAND Mode");
    const isOutside = this.fenceEnabled && !this.isInFence(this.at);
    if (isOutside && !this.isOutside) {
      this.breaches += 1;
      this.#getOut("RTL", "Fence Breached");
    }
    this.isOutside = isOutside;
  }

  #getOut(mode, words) {
    if (this.mode === "LAND" || this.mode === mode) return;
    this.setMode(mode);
    this.say(words, 2);
  }

  #fly(dt) {
    const { target, at } = this;
    const hold = { east: at.east, north: at.north, up: at.up };
    let to = target ?? hold;
    if (this.mode === "LAND") to = { ...hold, up: 0 };
    if (this.mode === "RTL") to = this.#returning(target);
    // A constant acceleration, and the speed from which it can still stop there.
    const way = { east: to.east - at.east, north: to.north - at.north };
    const left = Math.hypot(way.east, way.north);
    let wanted = Math.min(this.cruise_m_s, Math.sqrt(1.6 * ACCELERATION * left), left / dt), rise = this.up_m_s, sink = DOWN_M_S;
    const slope = Math.abs(to.up - at.up) / left;
    if (this.kind === "ardupilot" && this.mode === "GUIDED" && left > 1 && slope > 1e-3) {
      // Straight to the place: what is slower, across or up, holds back the other.
      wanted = Math.min(wanted, (to.up > at.up ? rise : sink) / slope);
      rise = sink = wanted * slope;
    }
    const aim = left > 1e-6 ? { east: (way.east / left) * wanted, north: (way.north / left) * wanted } : { east: 0, north: 0 };
    const change = { east: aim.east - this.speed.east, north: aim.north - this.speed.north };
    const size = Math.hypot(change.east, change.north), most = ACCELERATION * dt * 1.5;
    const part = size > most ? most / size : 1;
    for (const axis of ["east", "north"]) {
      this.speed[axis] += change[axis] * part;
      at[axis] += this.speed[axis] * dt;
    }
    const down = this.mode === "LAND" || this.isDescending ? (at.up < LAND_BELOW_M ? LAND_M_S : DOWN_M_S) : sink;
    const before = at.up;
    at.up = Math.max(0, at.up + (this.fall_m_s > 0 ? -this.fall_m_s * dt : Math.max(-down * dt, Math.min(rise * dt, to.up - at.up))));
    this.climb_m_s = (at.up - before) / dt;
    if (this.mode === "TAKEOFF" && target && at.up > target.up - 0.5) this.setMode("GUIDED");
  }

  #returning(target) {
    const isUp = this.at.up > target.up - 1 || this.isDescending;
    const isThere = Math.hypot(target.east - this.at.east, target.north - this.at.north) < 1;
    if (!isUp) return { ...target, east: this.at.east, north: this.at.north };
    this.isDescending ||= isThere;
    return this.isDescending ? { ...target, up: 0 } : target;
  }

  #disarm() {
    const goesDown = this.mode === "LAND" || this.isDescending;
    this.landed_s = this.isLanded && goesDown ? this.landed_s ?? this.now : null;
    const isUnused = this.isLanded && !this.target && this.now - this.armed_s > this.unused_s;
    if ((this.landed_s !== null && this.now - this.landed_s >= TOUCHED_S) || isUnused) {
      this.armed = false;
      this.speed = { east: 0, north: 0 };
    }
  }
}
