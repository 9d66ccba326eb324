// Asking an autopilot, and hearing what it answers. What takes time is a generator: it yields until something is heard (it is
// then resumed with {name, message}) or time has passed (resumed with nothing), and never waits by itself.
import { common, make } from "./frames.mjs";

/** A question without an answer is asked again after so long, this often in all. */
const REPEAT_S = 0.5;
const TIMES = 4;
/** It has said that it is at it: the end may take so long. */
const AT_IT_S = 10;
/** Of what it took, but refuses to take again: its effect shows by then. */
const EFFECT_S = 2;
const WORDS_S = 0.3;

const { ACCEPTED, IN_PROGRESS } = common.MavResult;

/** Why it cannot go on; `then`: what is to be done: "home", "land", or "off", hands off. */
export class Trouble extends Error {
  constructor(reason, then = "home") {
    super(reason);
    this.then = then;
  }
}

export class Talk {
  /**
   * `send`: takes a message. `now`: the time in seconds. `patience`: a time as long as it should at least be waited.
   * `mayCommand`: why nothing may be commanded now, or null.
   */
  constructor({ vehicle, send, now, patience, mayCommand }) {
    Object.assign(this, { vehicle, send, now, patience, mayCommand });
  }

  get #target() {
    return { targetSystem: this.vehicle.system, targetComponent: 1 };
  }

  sendTo(type, fields) {
    this.send(make(type, { ...this.#target, ...fields }));
  }

  /** Asks until that is answered; returns the answer, null: none. `isAnswer`: of {name, message}, or of nothing, at a tick. */
  *ask(type, fields, isAnswer, { times = TIMES, before = () => {} } = {}) {
    for (let n = 0; n < times; ++n) {
      before(n);
      this.sendTo(type, fields(n));
      const until = this.now() + this.patience(REPEAT_S);
      while (this.now() < until) {
        const heard = yield;
        if (isAnswer(heard)) return heard ?? true;
      }
    }
    return null;
  }

  /** Waits until that is so; returns whether it was by then. */
  *await(isSo, seconds) {
    const until = this.now() + this.patience(seconds);
    while (!isSo()) {
      if (this.now() >= until) return false;
      yield;
    }
    return true;
  }

  /**
   * Commands. `what`: for people. `isSeen`: its effect, which counts as an acknowledgement, so that one that gets lost does not
   * matter. Throws Trouble when it is refused, or nothing is answered.
   */
  *command(what, { command, params, place, z, frame }, isSeen = () => false) {
    const before = () => {
      const why = this.mayCommand();
      if (why) throw why;
    };
    const fields = (n) => {
      const given = Object.fromEntries(params.map((value, i) => [`_param${i + 1}`, value]));
      if (!place) return { command, confirmation: n, ...given };
      const where = { _param5: Math.round(place.latitude_deg * 1e7), _param6: Math.round(place.longitude_deg * 1e7), _param7: z };
      return { command, frame, ...given, ...where };
    };
    let times = 0;
    const isAck = (heard) => heard?.name === "COMMAND_ACK" && heard.message.command === command;
    const heard = yield* this.ask(place ? common.CommandInt : common.CommandLong, fields, (some) => isAck(some) || isSeen(),
      { before: () => (++times, before()) });
    let result = heard === null ? null : heard.message?.result ?? ACCEPTED;
    if (result !== null && !isAck(heard)) result = ACCEPTED;  // seen
    if (result === IN_PROGRESS) {
      const until = this.now() + this.patience(AT_IT_S);
      while (result === IN_PROGRESS && this.now() < until) {
        const more = yield;
        if (isAck(more)) result = more.message.result;
        if (isSeen()) result = ACCEPTED;
      }
    }
    if (result === ACCEPTED) return;
    // It may have taken it the first time, when its answer was lost.
    if (times > 1 && (yield* this.await(isSeen, EFFECT_S))) return;
    // Its words come a moment behind its answer.
    if (result !== null) yield* this.await(() => this.vehicle.words(this.now()) !== "", WORDS_S);
    const words = this.vehicle.words(this.now());
    const why = result === null ? "is not answered" : `is refused: ${common.MavResult[result] ?? `result ${result}`}`;
    throw new Trouble(`${what} ${why}${words ? ` (${words})` : ""}`);
  }

  /** A setting that is called one of these, whichever it has: {name, value, type}; null: none of them. */
  *read(...names) {
    const isOne = (heard) => heard?.name === "PARAM_VALUE" && names.includes(heard.message.paramId);
    const others = names.slice(1);
    const before = () => others.forEach((paramId) => this.sendTo(common.ParamRequestRead, { paramId, paramIndex: -1 }));
    const heard = yield* this.ask(common.ParamRequestRead, () => ({ paramId: names[0], paramIndex: -1 }), isOne, { before });
    return heard && { name: heard.message.paramId, ...this.#valueOf(heard.message) };
  }

  /** Sets it; returns whether it has that value then. */
  *write(name, value, type) {
    const raw = this.vehicle.kind.integersAsBits && type < REAL32 ? bitsOf(value) : value;
    const isSet = (heard) => isValueOf(name)(heard) && isClose(this.#valueOf(heard.message).value, value);
    return (yield* this.ask(common.ParamSet, () => ({ paramId: name, paramValue: raw, paramType: type }), isSet)) !== null;
  }

  #valueOf({ paramValue, paramType }) {
    const isBits = this.vehicle.kind.integersAsBits && paramType < REAL32;
    return { value: isBits ? integerOf(paramValue) : paramValue, type: paramType };
  }
}

const REAL32 = 9;  // MAV_PARAM_TYPE; below are the integers

function isValueOf(name) {
  return (heard) => heard?.name === "PARAM_VALUE" && heard.message.paramId === name;
}

/** Settings are floats of 32 bits on the wire. */
export function isClose(a, b) {
  return Math.abs(a - b) <= 1e-5 * Math.max(1, Math.abs(b));
}

const words = new DataView(new ArrayBuffer(4));

/** PX4 sends an integer as the float with the same bits. */
export function bitsOf(integer) {
  words.setInt32(0, integer);
  return words.getFloat32(0);
}

export function integerOf(float) {
  words.setFloat32(0, float);
  return words.getInt32(0);
}
