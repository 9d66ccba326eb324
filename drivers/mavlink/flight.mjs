// What a UAV does: gets ready, takes off, goes to a place, lands, comes home. Generators, as talk.mjs has them; what goes wrong
// is a Trouble.
import { common } from "./frames.mjs";
import { distance_m, towards } from "../places.mjs";
import { Phase } from "./safety.mjs";
import { Trouble } from "./talk.mjs";

const { MavCmd } = common;
const HEARTBEAT_S = 30, READY_S = 600, MODE_S = 3, SETTLE_S = 30, LAND_S = 600;
/** What is refused at first may be taken later, up to so long; asked again after so long. */
const REFUSED_S = 30, REFUSED_AGAIN_S = 2;
/** Volts of a cell at rest with which it takes off, and which a battery has that was charged. Source: ours. */
const START_V = 3.7, CHARGED_V = 4;
/** It is there: so near, and so slow. */
const THERE_M = 3, THERE_M_S = 1;
/** At a corner of its way it turns so near to it. */
const TURN_M = 6;
/** Slower than this for so long on its way, it does not move. */
const STUCK_M_S = 0.3, STUCK_S = 20;
const CLIMB_M_S = 0.5;
/** At which a mission that keeps UAVs apart counts on a change of altitude, from when it sets out (docs/reference/separation.md). */
const RISE_M_S = 2.5, SINK_M_S = 1.5;
/** Slower by so little is as fast. */
const SLOWER_M_S = 0.1;
const HOME_MESSAGE = 242;

/** Figures change all the time. */
export const withoutFigures = (words) => words.replace(/[\d.]+/g, "");

/** Waits for the autopilot. It may still be starting, for which its own time does not count. */
export function* heartbeat(talk, vehicle, speedup) {
  if (yield* talk.await(() => vehicle.kind, HEARTBEAT_S * speedup)) return;
  throw new Trouble(`no heartbeat of system ${vehicle.system} for ${HEARTBEAT_S} s`, "off");
}

export class Flight {
  /**
   * `plan`: {map, area, launch, near_m, altitude_m, speed_m_s, silence_s, reserve_percent, camera, speedup}; it also keeps what is
   * learned: cruise_m_s, climb_m_s, descent_m_s.
   */
  constructor({ talk, vehicle, safety, settings, streams, fence, note, waits, plan }) {
    Object.assign(this, { talk, vehicle, safety, settings, streams, fence, note, waits, plan });
  }

  get place() {
    return this.plan.map.toMetres(this.vehicle.place);
  }

  /** Waits for what a flight needs to know, and sets what it relies on. `isFirst`: here is where it comes home to. */
  *prepare(isFirst) {
    const { talk, vehicle, plan } = this;
    if (isFirst) yield* this.#untilHeard();
    else yield* heartbeat(talk, vehicle, plan.speedup);
    if (!vehicle.isCopter) throw new Trouble("it is no copter", "off");
    for (const [id, name, interval_us] of this.streams.wanted) {
      yield* this.#ask(name === "GLOBAL_POSITION_INT", "sending its place", { command: MavCmd.SET_MESSAGE_INTERVAL, params: [id, interval_us] });
    }
    this.streams.isOn = true;
    yield* this.#countCells();
    // At first nobody counts on it. Later a vehicle waits beside it.
    yield* isFirst ? this.#untilReady(START_V, Infinity) : this.#untilReady(CHARGED_V, READY_S);
    if (isFirst) yield* this.#checkCamera();
    if (isFirst) this.#checkLaunch();
    if (isFirst) plan.returnsStraight = yield* this.#returnsStraight();
    yield* this.#setHome(true);
    const set = yield* this.settings.apply(vehicle.kind.settings({ ...plan, ceiling_m: plan.area.ceiling_m }), () => this.fence.write(this.place));
    plan.cruise_m_s = vehicle.kind.cruise_m_s(set);
    if (isFirst && plan.cruise_m_s < plan.speed_m_s - SLOWER_M_S) {
      this.note(`it flies ${plan.cruise_m_s.toFixed(1)} m/s, as it is set; the scenario counts on ${plan.speed_m_s.toFixed(1)}: it will be late`);
    }
  }

  /** It may be switched on when the mission has long begun. */
  *#untilHeard() {
    const { talk, vehicle, plan } = this;
    for (let isNoted = false; !(yield* talk.await(() => vehicle.kind, HEARTBEAT_S * plan.speedup)); isNoted = true) {
      const heard = vehicle.otherSystem === null ? "" : ` (heard: system ${vehicle.otherSystem})`;
      this.waits(`a heartbeat of system ${vehicle.system}${heard}`);
      if (!isNoted) this.note(`no heartbeat of system ${vehicle.system} for ${HEARTBEAT_S} s${heard}: it goes on waiting`);
    }
  }

  /** Autopilots acknowledge pictures that no camera takes. */
  *#checkCamera() {
    const { talk, vehicle, plan } = this;
    if (plan.camera !== "digicam" || !vehicle.kind.cameraSetting) return;
    const camera = yield* talk.read(vehicle.kind.cameraSetting);
    if (camera?.value === 0) throw new Trouble(`it has no camera: ${vehicle.kind.cameraSetting} is 0. --camera none, if no picture is wanted`, "off");
  }

  /** Whether it would fly through zones, if it came home by itself, and somebody could change that. */
  *#returnsStraight() {
    const { name, around } = this.vehicle.kind.pathSetting ?? {};
    const set = name && (yield* this.talk.read(name));
    return Boolean(set) && !around.includes(set.value);
  }

  *#countCells() {
    const { talk, vehicle, plan } = this;
    vehicle.cells = plan.cells;
    for (const name of vehicle.kind.cellSettings) vehicle.cells ||= (yield* talk.read(name))?.value ?? 0;
    if (!(vehicle.cells > 0)) throw new Trouble("the number of its battery's cells is not known: --cells N", "off");
    plan.cells = vehicle.cells;
  }

  /** What it still lacks before it can fly; "": nothing. What it has not said yet is lacking. */
  #lacks(least_v) {
    const { vehicle } = this;
    const satellites = vehicle.satellites === null ? "" : ` (${vehicle.satellites} satellites)`;
    if (!vehicle.place) return `a place${satellites}`;
    if (!vehicle.hasFix) return `a fix${satellites}`;
    if (!vehicle.hasEstimate) return "an estimate of its place";
    if (vehicle.battery_percent === null || vehicle.cell_v === null) return "word of its battery";
    if (vehicle.cell_v < least_v) return `a charged battery: this one has ${vehicle.cell_v.toFixed(2)} V a cell, at least ${least_v.toFixed(2)} are needed`;
    return vehicle.isArmable === false ? `its own checks before arming${this.#words}` : "";
  }

  get #words() {
    const words = this.vehicle.words(this.talk.now());
    return words ? ` (${words})` : "";
  }

  *#untilReady(least_v, patience_s) {
    let told = "";
    const isReady = () => {
      const lack = this.#lacks(least_v);
      if (lack) this.waits(lack);
      const what = withoutFigures(lack);
      if (lack && what !== told) this.note(`not ready yet: it waits for ${lack}`);
      told = what;
      return !lack;
    };
    if (!(yield* this.talk.await(isReady, patience_s))) throw new Trouble(`it is not ready after ${patience_s} s: it waits for ${this.#lacks(least_v)}`);
  }

  /** Does it again while it is refused, up to so long. */
  *#retry(attempt) {
    const { talk } = this, until = talk.now() + talk.patience(REFUSED_S);
    for (let isNoted = false; ; ) {
      try {
        return yield* attempt();
      } catch (error) {
        if (!(error instanceof Trouble) || error.then === "off" || talk.now() >= until) throw error;
        this.waits(`the end of this: ${error.message}`);
        if (!isNoted) this.note(`not yet: ${error.message}`);
        isNoted = true;
        yield* talk.await(() => false, REFUSED_AGAIN_S);
      }
    }
  }

  *#ask(isNeeded, what, command) {
    try {
      yield* this.talk.command(what, command);
    } catch (error) {
      if (isNeeded || !(error instanceof Trouble)) throw error;
    }
  }

  #checkLaunch() {
    const { plan, vehicle } = this;
    const away_m = distance_m(this.place, plan.launch);
    if (away_m > plan.near_m) throw new Trouble(`it is ${away_m.toFixed(0)} m from where the mission has it`, "off");
    if (!plan.area.mayBeSent(this.place)) throw new Trouble("it stands outside the area", "off");
    plan.home = { ...vehicle.place, altitude_m: vehicle.altitude_amsl_m };
  }

  /**
   * Autopilots take where they are armed for their home, even after a battery was changed elsewhere, unless it was set.
   * `isNew`: its power may have been off, so that it is to be set even where it is right.
   */
  *#setHome(isNew) {
    const { talk, vehicle, plan } = this;
    const isHome = () => vehicle.home !== null && distance_m(plan.map.toMetres(vehicle.home), plan.map.toMetres(plan.home)) < THERE_M;
    const home = { command: MavCmd.DO_SET_HOME, params: [0, 0, 0, 0], place: plan.home, z: plan.home.altitude_m, frame: 0 };
    if (isNew) yield* this.#retry(() => talk.command("setting its home", home));
    for (let n = 0; n < 4; ++n) {
      vehicle.home = null;  // it may have changed since
      yield* this.#ask(false, "sending its home", { command: MavCmd.REQUEST_MESSAGE, params: [HOME_MESSAGE] });
      yield* talk.await(() => vehicle.home !== null, 1);
      if (isHome()) return;
      yield* this.#retry(() => talk.command("setting its home", home));
    }
    throw new Trouble("its home is not where it was set out");
  }

  get isFlying() {
    return this.safety.phase === Phase.fly;
  }

  *takeOff() {
    const { talk, vehicle, safety, plan } = this;
    if (vehicle.battery_percent <= plan.reserve_percent) {
      throw new Trouble(`its battery is low: ${vehicle.battery_percent} %, and ${plan.reserve_percent} % are the reserve`);
    }
    if (!(vehicle.cell_v >= START_V)) throw new Trouble(`its battery is low: ${vehicle.cell_v?.toFixed(2) ?? "unknown"} V a cell, and ${START_V.toFixed(2)} are needed to take off`);
    const isReady = () => vehicle.kind.modes.fly.includes(vehicle.mode);
    yield* talk.command("its mode", { command: MavCmd.DO_SET_MODE, params: vehicle.kind.flyMode }, isReady);
    if (!(yield* talk.await(isReady, MODE_S))) throw new Trouble(`it stays in ${vehicle.modeName}`);
    yield* this.#retry(() => this.#arm());
    if (!(yield* talk.await(() => vehicle.armed, MODE_S))) throw new Trouble("it does not arm");
    safety.phase = Phase.fly;
    safety.isArming = false;
    yield* talk.command("taking off", vehicle.kind.takeOff(plan.altitude_m, plan.home), () => vehicle.altitude_m > 1);
    const from_s = talk.now();
    const isUp = () => vehicle.altitude_m > plan.altitude_m - 1.5;
    if (!(yield* talk.await(isUp, plan.altitude_m / CLIMB_M_S + SETTLE_S))) throw new Trouble(`it does not climb to ${plan.altitude_m} m`);
    // PX4 stays in TAKEOFF for a moment, and may take the place where it was armed for its home.
    yield* talk.await(() => vehicle.kind.modes.fly[0] === vehicle.mode, SETTLE_S);
    plan.climb_m_s = plan.altitude_m / Math.max(1, talk.now() - from_s);
    yield* this.#setHome(false);
  }

  *#arm() {
    const { talk, vehicle, safety } = this;
    safety.isArming = true;
    try {
      yield* talk.command("arming", { command: MavCmd.COMPONENT_ARM_DISARM, params: [1, 0] }, () => vehicle.armed);
    } catch (error) {
      safety.isArming = vehicle.armed;  // else somebody else may arm it
      throw error;
    }
  }

  /** Goes there by these corners, each taken off the list as it is passed; returns whether it is there, or `isReplaced()`. */
  *follow(corners, to, isReplaced) {
    this.#changeAltitudeFirst(corners, to);
    if (!(yield* this.#pass(corners, isReplaced))) return false;
    const { vehicle, plan } = this;
    const isThere = () => distance_m(this.place, to) < THERE_M && vehicle.speed_m_s < THERE_M_S && Math.abs(vehicle.altitude_m - plan.altitude_m) < THERE_M;
    return yield* this.#goTo(to, isThere, isReplaced);
  }

  /**
   * An autopilot flies straight to a place, and changes its altitude evenly all the way there. The mission counts on it being
   * changed first: a place on the way is put in, at which it is to be that of the plan.
   */
  #changeAltitudeFirst(corners, to) {
    const { vehicle, plan } = this;
    const from_m = vehicle.altitude_m, change_m = plan.altitude_m - from_m;
    if (Math.abs(change_m) < THERE_M) return;
    const all_m = (Math.abs(change_m) / (change_m > 0 ? RISE_M_S : SINK_M_S)) * plan.cruise_m_s;
    let flown_m = 0, from = this.place;
    for (const [i, place] of [...corners, to].entries()) {
      const part_m = distance_m(from, place);
      if (flown_m + part_m >= all_m) {
        corners.splice(i, 0, towards(from, place, all_m - flown_m));
        return;
      }
      flown_m += part_m;
      if (place !== to) place.altitude_m = from_m + (change_m * flown_m) / all_m;
      from = place;
    }
  }

  *#pass(corners, isReplaced) {
    for (; corners.length; corners.shift()) {
      const isPassed = () => distance_m(this.place, corners[0]) < TURN_M;
      if (!(yield* this.#goTo(corners[0], isPassed, isReplaced))) return false;
    }
    return true;
  }

  /**
   * Passes the corners of its way home, as an autopilot that comes home flies straight. When it has to land, nearly without
   * battery, or without a link, it leaves the rest out. Returns how to bring it down then: "home" or "land".
   */
  *passHomeward(corners) {
    const { safety, plan } = this;
    const wrong = () => {
      const trouble = safety.check(plan.area, plan.map);
      const isComingHome = trouble?.then === "home" && safety.isLinked && !safety.isCritical;
      return isComingHome ? null : trouble;  // another reason to do so changes nothing
    };
    try {
      if (yield* this.#pass(corners, () => wrong() !== null)) return "home";
      const { message, then } = wrong();
      this.note(`${message}; it does not fly around zones any more`);
      return then;
    } catch (error) {
      if (!(error instanceof Trouble)) throw error;
      this.note(`${error.message}; it does not fly around zones any more`);
      return "home";
    }
  }

  /** Until it is there or `isReplaced()`; returns whether it is. */
  *#goTo(to, isThere, isReplaced) {
    const { talk, vehicle } = this;
    yield* this.#send("going there", to);
    let moved_s = talk.now();
    for (;;) {
      const left_m = distance_m(this.place, to);
      if (isThere()) return true;
      if (vehicle.speed_m_s > STUCK_M_S || left_m < THERE_M) moved_s = talk.now();
      if (talk.now() - moved_s > talk.patience(STUCK_S)) throw new Trouble(`it does not move, ${left_m.toFixed(0)} m before the place`);
      yield;
      if (isReplaced()) return false;
    }
  }

  *#send(what, to) {
    const { talk, vehicle, plan } = this;
    if (!plan.area.mayBeSent(to)) throw new Trouble(`(${to.x_m?.toFixed(0)}, ${to.y_m?.toFixed(0)}) m is outside the area`);
    yield* talk.command(what, vehicle.kind.goTo(plan.map.toDegrees(to), to.altitude_m ?? plan.altitude_m, plan.home, plan.cruise_m_s));
  }

  /** Stops where it is. It may be a few metres outside by then. */
  *hold() {
    const { width_m, height_m } = this.plan.area;
    const { x_m, y_m } = this.place;
    yield* this.#send("stopping", { x_m: Math.min(Math.max(x_m, 0), width_m), y_m: Math.min(Math.max(y_m, 0), height_m) });
  }

  /** Takes a picture. */
  *photograph() {
    const commands = {
      digicam: { command: MavCmd.DO_DIGICAM_CONTROL, params: [0, 0, 0, 0, 1, 0, 0] },
      image: { command: MavCmd.IMAGE_START_CAPTURE, params: [0, 0, 1, 0, 0, 0, 0] },
    };
    const command = commands[this.plan.camera];
    if (command) yield* this.talk.command("the camera", command);
  }

  /** Lands where it is, and waits until the motors are off. */
  *land() {
    const { talk, vehicle, safety, plan } = this;
    const from_s = talk.now(), from_m = vehicle.altitude_m;
    safety.phase = Phase.land;
    const isLanding = () => !vehicle.armed || (!vehicle.kind.modes.fly.includes(vehicle.mode) && vehicle.kind.modes.land.includes(vehicle.mode));
    yield* talk.command("landing", { command: MavCmd.NAV_LAND, params: [] }, isLanding);
    if (!(yield* talk.await(() => !vehicle.armed, LAND_S))) throw new Trouble(`it has not landed after ${LAND_S} s`);
    plan.descent_m_s = Math.max(1, from_m) / Math.max(1, talk.now() - from_s);
    safety.phase = Phase.ground;
  }

  /**
   * Brings it down, home or where it is, whatever happens on the way: it goes on until the motors are off or somebody else is in
   * command. What cannot be sent now is sent when the link is back.
   */
  *bringDown(where) {
    const { talk, vehicle, safety } = this;
    if (!vehicle.armed) return;
    safety.phase = where === "land" ? Phase.land : Phase.home;
    const commands = [MavCmd.NAV_RETURN_TO_LAUNCH, MavCmd.NAV_LAND].slice(where === "land" ? 1 : 0);
    const isLanding = () => vehicle.kind.modes.land.includes(vehicle.mode) && !vehicle.kind.modes.fly.includes(vehicle.mode);
    let mustLand = false;
    const isOnItsWay = () => (mustLand ? isLanding() : !vehicle.kind.modes.fly.includes(vehicle.mode));
    while (vehicle.armed && !safety.isOff) {
      if (safety.isCritical && !mustLand) {
        mustLand = true;
        commands.splice(0, commands.length, MavCmd.NAV_LAND);
        if (!isLanding()) this.note(`its battery is nearly empty: ${vehicle.cell_v.toFixed(2)} V a cell; landing`);
      }
      if (isOnItsWay() || !safety.isLinked) {
        yield;
        continue;
      }
      const command = commands[0];
      try {
        yield* talk.command(command === MavCmd.NAV_LAND ? "landing" : "coming home", { command, params: [] }, isOnItsWay);
        yield* talk.await(isOnItsWay, MODE_S);
      } catch (error) {
        if (!(error instanceof Trouble)) throw error;
        this.note(error.message);
        if (commands.length > 1) commands.shift();
        yield* talk.await(() => !vehicle.armed, 1);
      }
    }
    if (!vehicle.armed) safety.phase = Phase.ground;
  }
}
