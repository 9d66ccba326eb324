// One UAV's driver: lines of the mission (docs/guide/drivers.md) on one side, MAVLink on the other, as a function of what it hears and
// of the time. Sockets, clocks and files, and the greeting, are in main.mjs.
import { FrameWriter, make, minimal } from "./frames.mjs";
import { Area } from "./area.mjs";
import { Flight, heartbeat, withoutFigures } from "./flight.mjs";
import { Pictures } from "./pictures.mjs";
import { distance_m, MissionMap } from "../places.mjs";
import { Reporter } from "./reporter.mjs";
import { Phase, Safety } from "./safety.mjs";
import { Settings } from "./settings.mjs";
import { Streams } from "./streams.mjs";
import { Talk, Trouble } from "./talk.mjs";
import { Vehicle } from "./vehicle.mjs";
import { ZoneFence } from "./zone_fence.mjs";

const HEARTBEAT_S = 1, HEARD_S = 5;
const LANDING_S = 900;
const ROUNDING_S = 1e-6;
/** So often the mission hears of figures that change while it waits. */
const FIGURES_S = 10;
/** A ground station, as MAV_COMPONENT and MAV_STATE have it. */
const OUR_COMPONENT = 190, ACTIVE = 4, NO_AUTOPILOT = 8;

export class Driver {
  /**
   * `options`: of options.mjs. `edge`: {now() in the vehicle's seconds, say(object), send(bytes), note(words), kept (settings.mjs),
   * isChanged(): whether somebody has said, since the last call, that the battery was changed, keepPicture(of) (pictures.mjs),
   * signing (signing.mjs) or null}.
   */
  constructor(options, edge) {
    Object.assign(this, { options, edge });
    const { speedup } = options;
    // Where time runs faster nothing is given up sooner, by the wall, than it would be at life's pace, up to 3 s.
    const patience = (seconds) => (speedup > 1 ? Math.max(seconds, speedup * Math.min(seconds, 3)) : seconds);
    const now = edge.now;
    this.writer = new FrameWriter(options.ownSystem, OUR_COMPONENT, edge.signing);
    this.vehicle = new Vehicle(options.system);
    this.safety = new Safety({ vehicle: this.vehicle, now, patience, reserve_percent: options.reserve });
    this.talk = new Talk({ vehicle: this.vehicle, now, patience, send: (message) => this.#send(message), mayCommand: () => this.safety.mayCommand() });
    this.settings = new Settings(this.talk, edge.kept, edge.note);
    this.streams = new Streams(this);
    this.silence_s = speedup > 1 ? Math.max(5, 2 * speedup) : 5;
  }

  /** What it was told last; it does that, or has done it. */
  order = null;
  /** null: it goes on; else the code to exit with. */
  exitCode = null;
  hasFailed = false;
  /** Nothing is done with it any more. */
  isHandsOff = false;
  /** It has not been in the air yet. */
  isPreparing = false;
  /** It has a fence, and may take off. */
  isReady = false;
  /** Nobody tells it how high it is to fly. */
  isFree = true;
  /** Corners of its way home around zones, as the mission told it last. On the last way home each is taken off as it is passed. */
  homeward = [];
  #work = null;
  #task = null;  // at which it is, or to which it is on its way
  #heartbeat_s = -Infinity;
  #wait = { said: "", said_s: -Infinity };  // as the mission was told last

  #send(message) {
    this.edge.send(this.writer.write(message));
  }

  /** Brings it home by the way around zones that a driver left, if it did, puts back the settings that it left, and ends. */
  restore() {
    this.#work = this.#restore();
  }

  *#restore() {
    const { talk, vehicle, settings, options, edge } = this;
    try {
      yield* heartbeat(talk, vehicle, options.speedup);
      const wayHome = edge.kept.load()?.wayHome;
      if (options.after && wayHome && vehicle.armed) yield* this.#goOnHome(wayHome);
      if (options.after) yield* talk.await(() => !vehicle.armed, LANDING_S);
      if (vehicle.armed) throw new Trouble("it is armed: its settings are put back on the ground only", "off");
      this.exitCode = (yield* settings.restore()) ? 0 : 1;
    } catch (error) {
      if (!(error instanceof Trouble)) throw error;
      edge.note(error.message);
      this.exitCode = 1;
    }
  }

  /** Leaves its way home around zones to the program that goes on, and ends: a mission does not wait so long. */
  leaveWayHome() {
    const { plan: { cells, cruise_m_s, altitude_m, home }, homeward } = this;
    this.#keepWayHome(homeward.length ? { greeting: this.reporter.hello, plan: { cells, cruise_m_s, altitude_m, home }, homeward } : null);
    if (homeward.length) this.exitCode = this.hasFailed ? 1 : 0;
  }

  /** Takes the place of that of a mission before, which is flown by nobody. */
  #keepWayHome(wayHome) {
    const { kept } = this.edge, before = kept.load();
    if (before && (wayHome || before.wayHome)) kept.save({ ...before, wayHome });
  }

  *#goOnHome({ greeting, plan, homeward = [] }) {
    const { vehicle, safety, streams, talk, edge } = this;
    this.#keepWayHome(null);
    this.plan = { ...this.#planOf(greeting), ...plan };
    this.order = { type: "bye" };
    this.homeward = homeward;
    vehicle.cells = plan.cells;
    this.flight = new Flight({ ...this, note: edge.note, plan: this.plan });
    safety.phase = vehicle.kind.modes.fly.includes(vehicle.mode) ? Phase.fly : Phase.home;
    streams.isOn = true;
    yield* talk.await(() => vehicle.place && vehicle.battery_percent !== null, HEARD_S);
    const way = this.#bringHome();
    for (let heard; !way.next(heard).done; heard = yield) {
      if (talk.now() - vehicle.heard_s > LANDING_S) throw new Trouble("it is not heard any more", "off");
    }
  }

  /** There is no link, and none will come: it ends at once. */
  refuse(reason) {
    this.edge.note(reason);
    this.edge.say({ type: "failed", id: null, reason });
    this.hasFailed = this.isHandsOff = true;
    this.#work = null;
    this.exitCode = 3;
  }

  /** Takes a line of the mission. What is none is passed over. */
  hearLine(text) {
    let line = null;
    try {
      line = JSON.parse(text);
    } catch {
      return this.edge.note("a line of the mission is no JSON");
    }
    const take = { hello: () => this.#hello(line), time: () => this.#time(line), bye: () => this.bye(line.reason) };
    take.way_home = () => this.#takeWayHome(line.via);
    take.zone = () => this.#takeZone(line);
    take.zone_lift = () => this.fence?.zones.lift(line);
    for (const type of ["goto", "sense", "charge", "cancel", "altitude"]) take[type] = () => this.#take(line);
    if (line && Object.hasOwn(take, line.type)) take[line.type]();
  }

  #takeZone(line) {
    this.fence?.zones.add(line);
    this.#warnOfReturn();
  }

  /** Once, when both its settings and a zone are known. */
  #warnOfReturn() {
    if (!this.plan?.returnsStraight || !this.fence.zones.isAny) return;
    this.plan.returnsStraight = false;
    const { name, around } = this.vehicle.kind.pathSetting;
    this.edge.note(`if its autopilot comes home by itself, it flies straight, through zones: set ${name} to ${around[0]} and start it again, then it flies around them`);
  }

  #takeWayHome(via) {
    if (this.plan && Array.isArray(via)) this.homeward = via.filter(Boolean).map((place) => this.#metres(place));
  }

  /** The mission is over, or gone. */
  bye(reason) {
    this.edge.note(`the mission is over: ${reason}`);
    this.order = { type: "bye" };
    if (!this.#work) this.exitCode = 0;  // it has not begun
    if (this.isPreparing) this.#work = this.#end("off");  // it is on the ground
    this.step();
  }

  /** Takes a frame; returns whether it is one of the autopilot. */
  hearFrame(frame) {
    if (frame.system === this.options.system) this.#hearOfPicture(frame);
    if (!this.vehicle.hear(frame, this.edge.now())) return false;
    if (frame.name === "GLOBAL_POSITION_INT") this.reporter?.place();
    this.step(frame);
    return true;
  }

  #metres(place) {
    return Number.isFinite(place.x_m) ? place : this.plan.map.toMetres(place);
  }

  #hearOfPicture(frame) {
    if (!this.plan || this.order?.type === "bye") return;
    const { reporter, vehicle } = this;
    this.pictures.hear(frame, { agent: reporter.hello.agent, task: this.#task, mission_s: reporter.mission_s, place: vehicle.place });
  }

  /** Goes on as far as it can. At least ten times a second. */
  step(heard) {
    const now = this.edge.now();
    this.safety.look();
    // Who is deaf in the air falls silent: the autopilot then comes home by itself, as we cannot see what we would command.
    const isDeaf = this.vehicle.armed && !this.safety.isLinked;
    if (this.#work && !isDeaf && now - this.#heartbeat_s >= HEARTBEAT_S) {
      this.#heartbeat_s = now;
      this.#send(make(minimal.Heartbeat, { type: minimal.MavType.GCS, autopilot: NO_AUTOPILOT, systemStatus: ACTIVE, mavlinkVersion: 3 }));
    }
    if (!this.isHandsOff) this.streams.step();
    const trouble = this.plan && !this.isHandsOff && this.safety.check(this.plan.area, this.plan.map);
    // On its way home or down only somebody else in command matters.
    if (trouble && (trouble.then === "off" || !this.isEnding)) this.#fail(trouble);
    if (this.isReady && !this.isEnding && !isDeaf) this.fence.step(this.flight.place, heard);
    try {
      this.#work?.next(heard);
    } catch (error) {
      if (!(error instanceof Trouble)) throw error;
      this.#fail(error);
    }
  }

  #hello(line) {
    if (this.#work) return;
    this.reporter = new Reporter(this, line);
    try {
      this.plan = this.#planOf(line);
    } catch (error) {
      if (!(error instanceof Trouble)) throw error;
      return this.#fail(error);
    }
    this.pictures = new Pictures({ keep: this.edge.keepPicture, note: this.edge.note, map: this.plan.map });
    this.fence = new ZoneFence({ ...this, ...this.plan, note: this.edge.note });
    this.flight = new Flight({ ...this, note: this.edge.note, waits: (words) => this.#waitFor(words), plan: this.plan });
    this.#work = this.#life();
    this.step();
  }

  #planOf(line) {
    const { speedup, camera, reserve, ceiling, ownSystem, cells } = this.options;
    if (line.class !== "uav") throw new Trouble(`it drives UAVs, not a ${line.class}`, "off");
    if (!line.origin) throw new Trouble("the mission has no origin: it is nowhere on the earth", "off");
    if (line.rate === null || Math.abs(line.rate / speedup - 1) > 0.01) {
      throw new Trouble(`the mission runs at ${line.rate === null ? "full speed" : `rate ${line.rate}`}, and the vehicle's time at ${speedup} (--speedup)`, "off");
    }
    const number = Number(String(line.agent).split(":")[1]) || 0;
    // A mission that keeps UAVs apart says with each command how high it is to fly.
    const altitude_m = line.altitudes?.lowest_m ?? this.options.altitude + number * this.options.altitudeStep;
    const highest_m = line.altitudes?.highest_m ?? altitude_m;
    if (highest_m > ceiling) throw new Trouble(`${line.agent} would fly at ${highest_m} m, above ${ceiling} m: see --altitude, --altitude-step, --ceiling`, "off");
    const map = new MissionMap(line.origin);
    return {
      map, altitude_m, area: new Area(map, line.area, highest_m), launch: line.at, near_m: Math.max(5, line.speed_m_s),
      speed_m_s: line.speed_m_s, silence_s: this.silence_s, reserve_percent: reserve, camera, speedup, ownSystem, cells,
    };
  }

  #time(line) {
    this.reporter?.tell(line.mission_s, true);
    this.step();  // what is over by then is said first: it counts for this tick
    this.reporter?.answer();
  }

  #take(line) {
    this.reporter?.tell(line.mission_s, false);
    if (!this.isEnding) this.order = line;
    if (line.type === "goto") {
      this.#task = line.task ?? null;
      this.isFree = line.altitude_m === undefined;
    }
    if (this.plan && Number.isFinite(line.altitude_m)) this.plan.altitude_m = line.altitude_m;
    this.step();
  }

  /** The mission is over, and it is still in the air with settings that are to be put back. */
  get isUnfinished() {
    return this.order?.type === "bye" && this.vehicle.armed && !this.isHandsOff;
  }

  /** It has failed, or the mission is over. */
  get isEnding() {
    return this.hasFailed || this.order?.type === "bye";
  }

  #fail(trouble) {
    if (this.isHandsOff) return;
    const isOver = this.isEnding;
    this.edge.note(`${trouble.message}; ${{ home: "coming home", land: "landing", off: "hands off" }[trouble.then]}`);
    if (trouble.then === "off") this.safety.isOff = this.vehicle.armed;
    if (!isOver) this.edge.say({ type: "failed", id: this.order?.id ?? null, reason: trouble.message.slice(0, 500) });
    this.hasFailed = true;
    if (isOver && trouble.then !== "off") return;  // what brings it down meets its troubles itself
    this.isHandsOff = trouble.then === "off";
    this.#work = this.#end(trouble.then);
  }

  *#life() {
    this.isPreparing = true;
    yield* this.flight.prepare(true);
    this.isPreparing = false;
    this.isReady = true;
    this.#warnOfReturn();
    this.edge.say({ type: "ready" });
    this.edge.note(`ready: ${this.vehicle.kind.name}, ${this.vehicle.battery_percent} %, at ${this.plan.altitude_m} m`);
    while (this.order?.type !== "bye") {
      const order = this.order, isReplaced = () => this.order !== order;
      if (order) yield* this.#do(order, isReplaced);
      yield* this.#rest(isReplaced);
    }
    yield* this.#end("home");
  }

  /** Before it can set out first the mission hears what it waits for, and plans without it. */
  #waitFor(words) {
    const now = this.talk.now(), { said, said_s } = this.#wait;
    if (!this.isPreparing || words === said) return;
    if (withoutFigures(words) === withoutFigures(said) && now - said_s < FIGURES_S) return;
    this.#wait = { said: words, said_s: now };
    this.edge.say({ type: "not_ready", reason: words.slice(0, 500) });
  }

  *#do(order, isReplaced) {
    const { flight, reporter, safety, options } = this;
    if (order.type === "goto") {
      const to = this.#metres(order.to);
      reporter.charging = Number.isFinite(order.on_to_charge_m) ? { by: to, on_m: order.on_to_charge_m } : null;
      if (!flight.isFlying && distance_m(flight.place, to) < 3 && !this.vehicle.armed && order.then === "charge") {
        return yield* this.#arrive(order, to, isReplaced);
      }
      if (this.isHandled && !(yield* this.#battery(isReplaced))) return;
      safety.isServiced = false;
      while (reporter.mission_s < (order.set_out_s ?? 0) - ROUNDING_S && !isReplaced()) yield;
      if (isReplaced()) return;
      if (!flight.isFlying) yield* flight.takeOff();
      reporter.goal = { order, to, corners: (order.via ?? []).map((place) => this.#metres(place)) };
      const isThere = !isReplaced() && (yield* flight.follow(reporter.goal.corners, to, isReplaced));
      if (isThere && order.then === "charge") yield* flight.land();
      reporter.goal = null;
      if (isThere) yield* this.#arrive(order, to, isReplaced);
    } else if (order.type === "sense") {
      yield* flight.photograph();
      while (reporter.mission_s < order.mission_s + order.for_s - ROUNDING_S && !isReplaced()) yield;
      if (!isReplaced()) reporter.done(order);
    } else if (order.type === "charge") {
      if (safety.phase !== Phase.ground) yield* flight.land();
      this.isHandled = options.confirm !== "battery";  // somebody is near: no start without a word
      this.edge.isChanged();  // what was said before is of another change
      if (!(yield* this.#battery(isReplaced))) return;
      while (reporter.mission_s < order.mission_s + order.for_s - ROUNDING_S && !isReplaced()) yield;
      if (!isReplaced()) reporter.charged(order);
    } else if (flight.isFlying) {
      yield* flight.hold();
    }
  }

  /** Has nothing to do until it is told something else. When that takes long it lands where it set out from. */
  *#rest(isReplaced) {
    const from_s = this.talk.now();
    while (!isReplaced()) {
      if (this.#mayGoHome && this.talk.now() - from_s >= this.options.landIdle) yield* this.#landAtHome(isReplaced);
      else yield;
    }
  }

  /** Nobody waits for it in the air. In a mission that keeps UAVs apart only the mission knows where it may fly. */
  get #mayGoHome() {
    const waits = ["sense", "charge"].includes(this.order?.then);
    return this.options.landIdle > 0 && this.flight.isFlying && !waits && this.isFree;
  }

  *#landAtHome(isReplaced) {
    const { flight, plan, edge } = this;
    edge.note("nothing to do: it lands at home until it is sent somewhere");
    while (!isReplaced()) {
      const way = this.homeward, isAnother = () => isReplaced() || this.homeward !== way;
      // A copy: sent back before the mission has told another way, it needs all of this one again.
      if (yield* flight.follow([...way], plan.map.toMetres(plan.home), isAnother)) return yield* flight.land();
    }
  }

  /** It is there. The mission is told so when the scenario's speed allows it. */
  *#arrive(order, to, isReplaced) {
    const { reporter } = this;
    reporter.goal = { order, to, corners: [], isThere: true };
    while (!reporter.canBeThere && !isReplaced()) yield;
    if (isReplaced()) reporter.goal = null;
    else reporter.arrived();
  }

  /** Waits for another battery, and gets ready again; returns whether it is. Without it does not take off again. */
  *#battery(isReplaced) {
    const { safety, vehicle, options, edge } = this;
    safety.isServiced = true;
    edge.note(`waiting for another battery${options.confirm === "battery" ? "" : `; when it is in: touch ${options.confirm}`}`);
    // What it said of the battery before it was changed is of another one.
    let changed_s = options.confirm === "battery" ? this.talk.now() : null;
    const isChanged = () => {
      if (changed_s === null && (this.isConfirmed ||= edge.isChanged())) changed_s = this.talk.now();
      return changed_s !== null && vehicle.battery_s > changed_s && vehicle.battery_percent >= options.charged;
    };
    while (!isChanged()) {
      yield;
      if (isReplaced()) return false;
    }
    this.isReady = false;
    vehicle.forget();
    // The power may have been cut: it is heard anew.
    if (!(yield* this.talk.await(() => this.talk.now() - vehicle.heartbeat_s < 2, 120))) throw new Trouble("it is not heard after its battery was changed", "off");
    yield* this.flight.prepare(false);
    safety.isServiced = this.isHandled = this.isConfirmed = false;
    this.isReady = true;
    return true;
  }

  /** Around zones, if there are any on its way. */
  *#bringHome() {
    const { flight, homeward, vehicle } = this;
    const isAround = homeward.length && flight.isFlying && vehicle.place;
    yield* flight.bringDown(isAround ? yield* flight.passHomeward(homeward) : "home");
  }

  /** Brings it down, puts its settings back, and ends. */
  *#end(how) {
    const { safety, vehicle } = this;
    if (how === "home") yield* this.#bringHome();
    else if (how === "land") yield* this.flight.bringDown("land");
    // A pilot gets it as it was before, at once. On its way down by itself it needs what was set; and what we have not flown is
    // left alone in the air.
    const isPilots = () => safety.phase !== Phase.ground && !vehicle.kind.modes.home.includes(vehicle.mode);
    const isLeft = () => safety.phase === Phase.ground && this.order?.type === "bye";
    while (vehicle.armed && !isPilots() && !isLeft()) yield;
    if (vehicle.kind && this.plan && !(vehicle.armed && isLeft())) yield* this.settings.restore();
    this.edge.note(vehicle.armed ? "somebody else is in command: nothing is commanded any more" : "it is on the ground");
    while (this.order?.type !== "bye") yield;
    this.exitCode = this.hasFailed ? 1 : 0;
  }
}
