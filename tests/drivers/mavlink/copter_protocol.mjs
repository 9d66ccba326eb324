// What the test copter hears and says: MAVLink as autopilots speak it. Messages come only where somebody asked for them, but for
// the heartbeat; what is for another system is passed over; what it does not know is UNSUPPORTED.
import { ardupilotmega, common, FrameReader, FrameWriter, make, minimal } from "../../../drivers/mavlink/frames.mjs";
import { MODES } from "./copter.mjs";

const { MavCmd, MavResult } = common;
const FENCE = 1, FENCE_VERTICES = [5001, 5002];
const CAMERA = 100, SHUTTER_S = 0.3;
/** Its clock starts then: 2026-11-23. */
const EPOCH_US = 1_795_392_000_000_000n;
const ASKS_AGAIN_S = 0.25;
const PREARM_CHECK = 0x10000000;  // of MAV_SYS_STATUS_SENSOR
/** Settings of PX4 that are integers (MAV_PARAM_TYPE_INT32 = 6, REAL32 = 9). */
const INTEGERS = /^(NAV_DLL_ACT|COM_DL_LOSS_T|COM_RC_OVERRIDE|COM_LOW_BAT_ACT|RTL_TYPE|RTL_CONE_ANG|GF_ACTION)$/;

export class CopterProtocol {
  /** `send(bytes)`: to whoever listens. `signing`: of signing.mjs; null: anybody may speak. */
  constructor(copter, { system = 1, send, signing = null }) {
    Object.assign(this, { copter, system, send });
    this.reader = new FrameReader(signing);
    this.writer = new FrameWriter(system, 1, signing);
    this.heard = [];     // [seconds, name, message] of what was for it, commands and settings
    this.refusals = [];  // {command, result, words, times}
    this.room = 250;     // for corners of its fence
    this.shift = 0;      // its fence is elsewhere when it is read back
    this.busy_s = 0;     // so long it takes to answer a command, and says that it is at it
    this.late = [];
    this.camera = new FrameWriter(system, CAMERA, signing);  // one with a link of its own
    this.taken = [];     // pictures that are not told of yet
    this.boot();
  }

  boot() {
    this.intervals = new Map([[0, 1]]);
    this.due = new Map();
    this.upload = null;
    this.requested = [];
  }

  say(type, fields) {
    this.send(this.writer.write(make(type, fields)));
  }

  hear(bytes, isDatagram = true) {
    for (const { system, name, message } of isDatagram ? this.reader.readDatagram(bytes) : this.reader.read(bytes)) {
      const isPartner = system === (this.copter.settings.SYSID_MYGCS ?? system);
      if (name === "HEARTBEAT" && message.type === minimal.MavType.GCS && isPartner) this.copter.partner_s = this.copter.now;
      if (message.targetSystem !== this.system) continue;
      this.heard.push([this.copter.now, name, message]);
      this.partner = system;
      this.#take[name]?.(message);
    }
  }

  /** Says what is due. */
  step() {
    const { now } = this.copter;
    for (const [id, interval] of this.intervals) {
      if (interval <= 0 || now < (this.due.get(id) ?? 0)) continue;
      this.due.set(id, now + interval - 1e-6);
      this.#messages[id]?.();
    }
    // Words come behind the heartbeat and the acknowledgement that they are about.
    if (this.copter.texts.length) for (const { words, severity } of this.copter.texts.splice(0)) this.say(common.StatusText, { severity, text: words });
    if (this.requested.length) for (const id of this.requested.splice(0)) this.#messages[id]();
    if (this.upload && now >= this.upload.again) this.#askItem();
    if (this.taken.length) this.#tellOfPictures();
    if (!this.late.length) return;
    for (const { ack } of this.late.filter(({ due }) => due <= now)) this.say(common.CommandAck, ack);
    this.late = this.late.filter(({ due }) => due > now);
  }

  /** All commands that it was given, by name. */
  commands(name) {
    return this.heard.filter(([, kind, message]) => kind.startsWith("COMMAND_") && (!name || message.command === MavCmd[name]));
  }

  #messages = {
    0: () => this.say(minimal.Heartbeat, {
      type: 2, autopilot: this.copter.kind === "px4" ? 12 : 3, baseMode: 1 | (this.copter.armed ? 128 : 0), customMode: this.copter.customMode,
      systemStatus: this.copter.armed ? 4 : 3, mavlinkVersion: 3,
    }),
    1: () => this.say(common.SysStatus, {
      batteryRemaining: Math.floor(this.copter.battery_percent), voltageBattery: Math.round(1000 * this.copter.volts),
      onboardControlSensorsPresent: PREARM_CHECK, onboardControlSensorsEnabled: PREARM_CHECK,
      onboardControlSensorsHealth: this.copter.isEstimating ? PREARM_CHECK : 0,
    }),
    24: () => this.say(common.GpsRawInt, { timeUsec: 0n, fixType: this.copter.hasFix ? 3 : 1, satellitesVisible: this.copter.hasFix ? 12 : 2 }),
    33: () => this.#position(),
    147: () => this.say(common.BatteryStatus, { batteryRemaining: Math.floor(this.copter.battery_percent), voltages: Array(10).fill(65535), voltagesExt: [0, 0, 0, 0] }),
    162: () => this.say(common.FenceStatus, { breachStatus: this.copter.isOutside ? 1 : 0 }),
    193: () => this.say(ardupilotmega.EkfStatusReport, { flags: this.copter.isEstimating ? 831 : 39 }),
    230: () => this.say(common.EstimatorStatus, { timeUsec: 0n, flags: this.copter.isEstimating ? 831 : 39 }),
    242: () => this.#home(),
  };

  #position() {
    const { copter } = this;
    if (!copter.hasFix) return;
    const { latitude_deg, longitude_deg } = copter.place;
    this.say(common.GlobalPositionInt, {
      timeBootMs: Math.round((copter.now - copter.booted) * 1000), lat: Math.round(latitude_deg * 1e7), lon: Math.round(longitude_deg * 1e7),
      alt: Math.round((this.#seaLevel + copter.at.up) * 1000), relativeAlt: Math.round(copter.at.up * 1000),
      vx: Math.round(copter.speed.north * 100), vy: Math.round(copter.speed.east * 100),
      vz: Math.round(-(copter.armed ? copter.climb_m_s ?? 0 : 0) * 100), hdg: 65535,
    });
  }

  get #seaLevel() {
    return 12;  // the ground, above the sea
  }

  #home() {
    const { home } = this.copter;
    if (!home) return;
    const [latitude, longitude] = [home.latitude_deg, home.longitude_deg].map((degrees) => Math.round(degrees * 1e7));
    this.say(common.HomePosition, { latitude, longitude, altitude: this.#seaLevel * 1000, q: [1, 0, 0, 0], timeUsec: 0n });
  }

  /** A picture is taken, and told of a moment later: by the autopilot, or by a camera that was asked itself. */
  #shoot(isCamera) {
    const { copter } = this;
    copter.photos.push({ ...copter.at, at_s: copter.now });
    this.taken.push({ index: copter.photos.length, isCamera, due: copter.now + SHUTTER_S, up: copter.at.up, place: copter.place });
    return MavResult.ACCEPTED;
  }

  #tellOfPictures() {
    const { copter } = this;
    for (const picture of this.taken.filter(({ due }) => due <= copter.now)) {
      const { index, isCamera, up } = picture, time_us = EPOCH_US + BigInt(Math.round(1e6 * (picture.due - SHUTTER_S)));
      const [lat, lon] = [picture.place.latitude_deg, picture.place.longitude_deg].map((degrees) => Math.round(degrees * 1e7));
      const captured = make(common.CameraImageCaptured, {
        timeUtc: time_us, timeBootMs: 0, cameraId: isCamera ? 0 : 1, lat, lon, alt: Math.round(1000 * (this.#seaLevel + up)), relativeAlt: Math.round(1000 * up),
        q: [1, 0, 0, 0], imageIndex: index - 1, captureResult: 1, fileUrl: isCamera ? `http://192.168.144.25/DCIM/IMG_${String(index).padStart(4, "0")}.JPG` : "",
      });
      if (isCamera) this.send(this.camera.write(captured));
      else if (copter.kind === "px4") this.send(this.writer.write(captured));
      else this.say(ardupilotmega.CameraFeedback, { timeUsec: time_us, targetSystem: this.system, imgIdx: index, lat, lng: lon, altMsl: this.#seaLevel + up, altRel: up });
    }
    this.taken = this.taken.filter(({ due }) => due > copter.now);
  }

  #take = {
    COMMAND_LONG: (message) => this.#command(message, false),
    COMMAND_INT: (message) => this.#command(message, true),
    PARAM_REQUEST_READ: (message) => this.#value(message.paramId),
    PARAM_SET: (message) => {
      const { settings } = this.copter;
      if (!(message.paramId in settings)) return;
      settings[message.paramId] = this.#isBits(message.paramId) ? fromBits(message.paramValue) : message.paramValue;
      this.#value(message.paramId);
    },
    MISSION_REQUEST_LIST: () => this.#mission(common.MissionCount, { count: this.copter.fence.length }),
    MISSION_REQUEST_INT: ({ seq }) => {
      const item = this.copter.fence[seq];
      if (item) this.#mission(common.MissionItemInt, { ...item, x: item.x + this.shift, seq });
    },
    MISSION_CLEAR_ALL: () => {
      this.copter.fence = [];
      this.#mission(common.MissionAck, { type: 0 });
    },
    MISSION_COUNT: ({ count }) => {
      if (count > this.room) return this.#mission(common.MissionAck, { type: 4 });  // MAV_MISSION_NO_SPACE
      this.upload = { count, items: [] };
      this.#askItem();
    },
    MISSION_ITEM_INT: (item) => this.#item(item),
  };

  #isBits(name) {
    return this.copter.kind === "px4" && INTEGERS.test(name);
  }

  #value(name) {
    const value = this.copter.settings[name];
    if (value === undefined) return;  // autopilots say nothing of what they do not have
    this.say(common.ParamValue, { paramId: name, paramValue: this.#isBits(name) ? toBits(value) : value, paramType: this.#isBits(name) ? 6 : 9, paramCount: 1 });
  }

  #mission(type, fields) {
    this.say(type, { targetSystem: this.partner, targetComponent: 190, missionType: FENCE, ...fields });
  }

  #askItem() {
    this.upload.again = this.copter.now + ASKS_AGAIN_S;
    this.#mission(common.MissionRequestInt, { seq: this.upload.items.length });
  }

  #item({ seq, command, frame, param1, x, y, z }) {
    if (!this.upload || seq !== this.upload.items.length) return;
    if (!FENCE_VERTICES.includes(command) || !this.#isNext(command, param1)) {
      this.upload = null;
      return this.#mission(common.MissionAck, { type: 3 });  // MAV_MISSION_UNSUPPORTED
    }
    this.upload.items.push({ command, frame, param1, x, y, z });
    if (this.upload.items.length < this.upload.count) return this.#askItem();
    this.copter.fence = this.upload.items;
    this.upload = null;
    this.#mission(common.MissionAck, { type: 0 });
  }

  /** Whether such an item goes on with the polygon that is being written, or begins another that is whole. */
  #isNext(command, corners) {
    const { items, count } = this.upload;
    let begun = 0;
    while (begun < items.length && begun + items[begun].param1 <= items.length) begun += items[begun].param1;
    if (begun < items.length) return items[begun].command === command && items[begun].param1 === corners;
    return corners >= 3 && items.length + corners <= count;
  }

  #command(message, isInt) {
    const params = [1, 2, 3, 4, 5, 6, 7].map((i) => message[`_param${i}`]);
    const refusal = this.refusals.find(({ command, times }) => MavCmd[command] === message.command && times !== 0);
    if (refusal?.times) refusal.times -= 1;
    if (refusal?.words) this.copter.say(refusal.words);
    const result = refusal ? refusal.result : this.#obey[message.command]?.(params, isInt, message.frame) ?? MavResult.UNSUPPORTED;
    const ack = { command: message.command, targetSystem: this.partner, targetComponent: 190 };
    this.say(common.CommandAck, { ...ack, result: this.busy_s > 0 ? MavResult.IN_PROGRESS : result });
    if (this.busy_s > 0) this.late.push({ due: this.copter.now + this.busy_s, ack: { ...ack, result } });
  }

  #obey = {
    [MavCmd.SET_MESSAGE_INTERVAL]: ([id, interval_us]) => {
      const isOther = id === (this.copter.kind === "px4" ? 193 : 230) || (this.copter.kind === "px4" && id === 162);
      if (!this.#messages[id] || isOther) return MavResult.FAILED;
      this.intervals.set(id, interval_us / 1e6);
      return MavResult.ACCEPTED;
    },
    [MavCmd.REQUEST_MESSAGE]: ([id]) => {
      if (!this.#messages[id] || (id === 242 && !this.copter.home)) return MavResult.FAILED;
      this.requested.push(id);  // behind the acknowledgement
      return MavResult.ACCEPTED;
    },
    [MavCmd.DO_SET_HOME]: ([, , , , x, y], isInt) => {
      if (!isInt) return MavResult.DENIED;
      if (!this.copter.isEstimating) return MavResult.FAILED;
      Object.assign(this.copter, { home: { latitude_deg: x / 1e7, longitude_deg: y / 1e7, up: 0 }, isHomeSet: true });
      return MavResult.ACCEPTED;
    },
    [MavCmd.DO_SET_MODE]: ([base, main, sub]) => {
      const { copter } = this;
      const mode = copter.kind === "px4" ? (main << 16) | (sub << 24) : main;
      const name = Object.keys(MODES[copter.kind]).find((key) => MODES[copter.kind][key] === mode);
      if (!(base & 1) || !name) return MavResult.DENIED;
      copter.setMode(name);
      return MavResult.ACCEPTED;
    },
    [MavCmd.COMPONENT_ARM_DISARM]: ([arms]) => this.#arm(arms === 1),
    [MavCmd.NAV_TAKEOFF]: (params) => this.#takeOff(params[6]),
    [MavCmd.DO_REPOSITION]: (params, isInt, frame) => this.#goTo(params, isInt, frame),
    [MavCmd.NAV_LAND]: () => this.#goDown("LAND"),
    [MavCmd.NAV_RETURN_TO_LAUNCH]: () => this.#goDown("RTL"),
    [MavCmd.DO_DIGICAM_CONTROL]: ([, , , , shoots]) => (shoots === 1 ? this.#shoot(false) : MavResult.ACCEPTED),
    [MavCmd.IMAGE_START_CAPTURE]: () => this.#shoot(true),
  };

  #arm(arms) {
    const { copter } = this;
    if (!arms) {
      if (!copter.isLanded) return MavResult.FAILED;
      copter.armed = false;
      return MavResult.ACCEPTED;
    }
    if (copter.armed) return MavResult.ACCEPTED;
    if (copter.notReady || copter.mode !== "GUIDED") {
      copter.say(copter.notReady || "Arm: mode not armable");
      return MavResult.FAILED;
    }
    copter.arm();
    return MavResult.ACCEPTED;
  }

  #takeOff(altitude) {
    const { copter } = this, isPx4 = copter.kind === "px4";
    if (!copter.armed || !copter.isLanded || (!isPx4 && copter.mode !== "GUIDED")) return MavResult.FAILED;
    if (isPx4) copter.setMode("TAKEOFF");
    copter.target = { ...copter.at, up: isPx4 ? altitude - this.#seaLevel : altitude };
    return MavResult.ACCEPTED;
  }

  #goTo([, flags, , , x, y, z], isInt, frame) {
    const { copter } = this, isPx4 = copter.kind === "px4";
    if (!isInt || (isPx4 ? flags !== 1 : copter.mode !== "GUIDED")) return isPx4 ? MavResult.UNSUPPORTED : MavResult.DENIED;
    if (frame !== (isPx4 ? 0 : 3)) return MavResult.COMMAND_UNSUPPORTED_MAV_FRAME;
    const target = { ...copter.toMetres({ latitude_deg: x / 1e7, longitude_deg: y / 1e7 }), up: isPx4 ? z - this.#seaLevel : z };
    if (copter.isLanded || (copter.fenceEnabled && !copter.isInFence(target))) return MavResult.FAILED;
    if (isPx4) copter.setMode("GUIDED");
    copter.target = target;
    return MavResult.ACCEPTED;
  }

  #goDown(mode) {
    if (!this.copter.hasFix && mode === "RTL") return MavResult.FAILED;
    this.copter.setMode(mode);
    return MavResult.ACCEPTED;
  }
}

const word = Buffer.alloc(4);

function toBits(value) {
  word.writeInt32LE(value);
  return word.readFloatLE();
}

function fromBits(value) {
  word.writeFloatLE(value);
  return word.readInt32LE();
}
