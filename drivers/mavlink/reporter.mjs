// What the mission is told of the UAV: where it is, how far it can go, when it will be there.
import { distance_m } from "../places.mjs";
import { Phase } from "./safety.mjs";

/** A place no sooner after the one before, of the mission and of the wall. */
const EVERY_S = 0.5;
const WALL_S = 0.05;
/** So much above the reserve it has no range left: missions plan to the last metre, and know of no hovering or landing. */
const MARGIN_PERCENT = 10;
/** A place is one of now for so long. */
const OLD_S = 3;
/** It stands where it was: its range does not fall. */
const STANDS_M = 2;
/** To take off or land, and to speed up and slow down: for the expected arrival. */
const CLIMB_M_S = 1.5, TURN_S = 5;
/** Clocks, and lines on their way: so much later than now may be told. */
const LATER_S = 0.5, LATER_WALL_S = 0.2;

export class Reporter {
  /** Where it is sent: {order, to}; null: nowhere. */
  goal = null;
  #last = null;  // {at, mission_s} told last
  #told_at = 0;  // our time
  #isQuiet = false;
  #tick_s = 60;

  constructor(driver, hello) {
    Object.assign(this, { driver, hello, told_s: hello.mission_s, told_at: driver.edge.now() });
    this.range_m = hello.range_m;
    this.range_at = hello.at;
    this.#last = { at: hello.at, mission_s: hello.mission_s };
  }

  /** The mission's time is that; `isTick`: it has taken what it was told by then. */
  tell(mission_s, isTick) {
    if (!Number.isFinite(mission_s)) return;
    if (!isTick && mission_s < this.mission_s) return;  // of what began before
    if (isTick) {
      this.#isQuiet = false;
      if (mission_s > this.told_s) this.#tick_s = mission_s - this.told_s;
    }
    this.told_s = mission_s;
    this.told_at = this.driver.edge.now();
  }

  get mission_s() {
    return this.told_s + this.driver.edge.now() - this.told_at;
  }

  /** The autopilot has told its place. */
  place() {
    const { now } = this.driver.edge;
    const { speedup } = this.driver.options;
    if (now() - this.#told_at < Math.max(EVERY_S, WALL_S * speedup)) return;
    this.answer();
  }

  /**
   * Says where it is. On the ground, where it is not heard as long as its power is off, and not before it is ready: where it was
   * last, so that the mission does not take it for lost.
   */
  answer() {
    const { driver } = this;
    const { vehicle, plan, edge, safety } = driver;
    if (this.#isQuiet || !plan || driver.isEnding) return;
    const isHeard = vehicle.place !== null && edge.now() - vehicle.place_s <= OLD_S * driver.options.speedup;
    if (!isHeard && safety.phase !== Phase.ground) return;
    this.#told_at = edge.now();
    const at = isHeard ? plan.map.toMetres(vehicle.place) : this.#last.at;
    if (plan.area.isOut(at, 0)) return;
    const mission_s = this.#when(at);
    const line = { type: "state", at, mission_s };
    if (isHeard && !safety.isServiced && vehicle.battery_percent !== null) line.range_m = this.#range(at);
    if (isHeard && this.goal) line.expected_s = mission_s + this.#left_s(at);
    edge.say(line);
    this.#last = { at, mission_s };
  }

  /**
   * When it is there: now, or as late as its speed needs from the place before. Lines and messages take their time, more where
   * the mission runs fast, and the mission would take what was delayed less for faster.
   */
  #when(at) {
    const { speedup } = this.driver.options;
    const soonest = this.#last.mission_s + distance_m(this.#last.at, at) / this.hello.speed_m_s;
    const latest = this.mission_s + LATER_S + LATER_WALL_S * (speedup - 1);
    return Math.max(this.mission_s, Math.min(soonest, latest));
  }

  #left_s(at) {
    const { plan, vehicle } = this.driver;
    const { order, to } = this.goal;
    const climb_m = Math.abs(plan.altitude_m - vehicle.altitude_m) + (order.then === "charge" ? plan.altitude_m : 0);
    return distance_m(at, to) / this.hello.speed_m_s + climb_m / CLIMB_M_S + TURN_S;
  }

  /**
   * The range that its battery has left, down to the reserve, where that is less than the mission knows of; else nothing: the
   * mission takes no more than it has computed.
   */
  #range(at) {
    const way_m = distance_m(this.range_at, at);
    if (way_m > STANDS_M) {
      this.range_m = Math.max(0, this.range_m - way_m);
      this.range_at = at;
    }
    const left_m = this.#batteryRange();
    if (left_m >= this.range_m) return undefined;
    this.range_m = left_m;
    return left_m;
  }

  #batteryRange() {
    const { vehicle, options } = this.driver;
    const empty = options.reserve + MARGIN_PERCENT;
    return (this.hello.full_range_m * Math.max(0, vehicle.battery_percent - empty)) / (100 - empty);
  }

  arrived(order, to) {
    this.answer();
    this.driver.edge.say({ type: "arrived", id: order.id });
    this.#range(to);
    this.#last = { at: to, mission_s: this.mission_s };
    // The mission takes it to be there at its tick: places from before would be old then.
    this.#isQuiet = true;
  }

  /** It has sensed. The mission has computed what that takes of its range; here is what it took. */
  done(order) {
    this.driver.edge.say({ type: "done", id: order.id, range_m: this.#range(this.#last.at) ?? this.range_m });
  }

  /**
   * With another battery. The mission takes it to be as full as the time allows, of which it expects the end at its next tick:
   * so much it knows of at least.
   */
  charged(order) {
    const took_s = this.mission_s - order.mission_s, most_s = Math.max(order.for_s, this.told_s + 2 * this.#tick_s - order.mission_s);
    this.range_m += (this.hello.full_range_m - this.range_m) * Math.min(1, took_s / most_s);
    this.range_at = this.#last.at;
    this.driver.edge.say({ type: "done", id: order.id, range_m: this.#range(this.#last.at) });
  }
}
