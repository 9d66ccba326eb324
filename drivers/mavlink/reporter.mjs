// What the mission is told of the UAV: where it is, how far it can go, when it will be there.
import { distance_m, towards } from "../places.mjs";
import { Phase } from "./safety.mjs";
import { Use } from "./use.mjs";

/** A place no sooner after the one before, of the mission and of the wall. */
const EVERY_S = 0.5;
const WALL_S = 0.05;
/** So much above the reserve it has no range left: missions plan to the last metre, and know of no hovering or landing. */
const MARGIN_PERCENT = 10;
/** A place is one of now for so long. */
const OLD_S = 3;
/** It stands where it was: its range does not fall. */
const STANDS_M = 2;
/** Places are known to so much. */
const PLACE_M = 50;
/** Places differ by rounding. */
const SAME_M = 1e-6;
/**
 * For the expected arrival: how fast it takes off and lands until it has done so once (ArduPilot took 45 s to land from 40 m), and
 * what it takes to speed up and slow down.
 */
const CLIMB_M_S = 1.5, DESCENT_M_S = 0.9, TURN_S = 5;

export class Reporter {
  /** Where it is sent: {order, to, isThere}; null: nowhere. */
  goal = null;
  /** {by, on_m}: from its last goal it is so far to the nearest charging point; null: none is known. */
  charging = null;
  #use = new Use();
  #last = null;  // {at, mission_s} told last
  #told_at = 0;  // our time
  #isQuiet = false;
  #ticked_s = 0;  // the last tick
  #tick_s = 0;    // from tick to tick; not known yet

  constructor(driver, hello) {
    Object.assign(this, { driver, hello, told_s: hello.mission_s, told_at: driver.edge.now() });
    this.range_m = hello.range_m;
    this.range_at = hello.at;
    this.#last = { at: hello.at, mission_s: hello.mission_s };
    this.#ticked_s = hello.mission_s;
  }

  /** The mission's time is that; `isTick`: it has taken what it was told by then. */
  tell(mission_s, isTick) {
    if (!Number.isFinite(mission_s)) return;
    if (!isTick && mission_s < this.mission_s) return;  // of what began before
    if (isTick) {
      this.#isQuiet = false;
      this.#last.mission_s = Math.min(this.#last.mission_s, mission_s);
      if (mission_s > this.#ticked_s) this.#tick_s = mission_s - this.#ticked_s;
      this.#ticked_s = mission_s;
    }
    this.told_s = mission_s;
    this.told_at = this.driver.edge.now();
  }

  get mission_s() {
    return this.told_s + this.driver.edge.now() - this.told_at;
  }

  /** The mission takes what is said now for said by then: at its next tick at the latest, which may be late by the wall. */
  get #heard_s() {
    return Math.max(this.#last.mission_s, Math.min(this.mission_s, this.#ticked_s + this.#tick_s));
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
    let seen = isHeard ? plan.map.toMetres(vehicle.place) : this.#last.at;
    if (this.goal?.isThere) seen = this.goal.to;
    if (plan.area.isOut(seen, 0)) return;
    const mission_s = this.#heard_s;
    const at = this.#possible(seen, mission_s);
    const line = { type: "state", at, mission_s };
    if (isHeard && !safety.isServiced && vehicle.battery_percent !== null) line.range_m = this.#range(at);
    if (isHeard && this.goal) line.expected_s = mission_s + this.#left_s(at);
    edge.say(line);
    this.#last = { at, mission_s };
  }

  /**
   * That place, or as far towards it as its speed allows by then. Where the mission runs fast its ticks are late by much of its
   * own time, and so is what it hears: it would take the UAV for faster than it is. The rest is told with the time.
   */
  #possible(at, mission_s) {
    return towards(this.#last.at, at, this.hello.speed_m_s * (mission_s - this.#last.mission_s));
  }

  /** Whether its speed allows that it is at its goal by now. */
  get canBeThere() {
    return distance_m(this.#last.at, this.goal.to) <= this.hello.speed_m_s * (this.#heard_s - this.#last.mission_s) + SAME_M;
  }

  #left_s(at) {
    const { plan, vehicle } = this.driver;
    const { order, to, corners } = this.goal;
    const climb_s = Math.abs(plan.altitude_m - vehicle.altitude_m) / (plan.climb_m_s ?? CLIMB_M_S);
    const descent_s = order.then === "charge" ? plan.altitude_m / (plan.descent_m_s ?? DESCENT_M_S) : 0;
    const way_m = [...corners, to].reduce(([sum, from], place) => [sum + distance_m(from, place), place], [0, at])[0];
    return way_m / Math.min(this.hello.speed_m_s, plan.cruise_m_s) + climb_s + descent_s + TURN_S;
  }

  /**
   * The range that its battery has left, down to the reserve, where that is less than the mission knows of; else nothing: the
   * mission takes no more than it has computed.
   */
  #range(at) {
    const way_m = distance_m(this.range_at, at);
    this.#use.hear(this.driver.vehicle.battery_percent);
    if (way_m > STANDS_M) {
      this.#use.count(way_m);
      this.range_m = Math.max(0, this.range_m - way_m);
      this.range_at = at;
    }
    const left_m = this.#batteryRange(at);
    if (left_m >= this.range_m) return undefined;
    this.range_m = left_m;
    return left_m;
  }

  /**
   * By what was measured where that is dearer than the scenario has it. It may always be sent to the nearest charging point that its
   * battery allows: without the margin, if need be.
   */
  #batteryRange(at) {
    const { vehicle, options } = this.driver;
    const above = vehicle.battery_percent - options.reserve;
    const percent_m = Math.max((100 - options.reserve - MARGIN_PERCENT) / this.hello.full_range_m, this.#use.percent_m);
    const metres = (percent) => Math.max(0, percent) / percent_m;
    const charging_m = this.charging ? distance_m(at, this.charging.by) + this.charging.on_m + PLACE_M : 0;
    return Math.max(metres(above - MARGIN_PERCENT), Math.min(metres(above), charging_m));
  }

  /** It is at its goal. */
  arrived() {
    const { order, to } = this.goal;
    this.answer();
    this.goal = null;
    this.driver.edge.say({ type: "arrived", id: order.id });
    this.#range(to);
    this.#last = { at: to, mission_s: this.#heard_s };
    // The mission takes it to be there at its tick: places from before would be old then.
    this.#isQuiet = true;
  }

  /** It has sensed. The mission has computed what that takes of its range; here is what it took. */
  done(order) {
    this.#use.count(order.for_s * this.hello.speed_m_s);
    this.#use.hear(this.driver.vehicle.battery_percent);
    this.#use.settle();
    this.driver.edge.say({ type: "done", id: order.id, range_m: this.#range(this.#last.at) ?? this.range_m });
  }

  /**
   * With another battery. The mission takes it to be as full as the time allows, of which it expects the end at its next tick:
   * so much it knows of at least.
   */
  charged(order) {
    this.#use.begin();
    const took_s = this.mission_s - order.mission_s, most_s = Math.max(order.for_s, this.#ticked_s + 2 * this.#tick_s - order.mission_s);
    this.range_m += (this.hello.full_range_m - this.range_m) * Math.min(1, took_s / most_s);
    this.range_at = this.#last.at;
    this.driver.edge.say({ type: "done", id: order.id, range_m: this.#range(this.#last.at) });
  }
}
