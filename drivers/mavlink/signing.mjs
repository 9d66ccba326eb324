// MAVLink 2's signatures: who has the key may speak. https://mavlink.io/en/guide/message_signing.html
import { createHash } from "node:crypto";

/** Of the incompatibility flags, the third byte of a frame: it is signed. */
export const SIGNED = 1;
const MAVLINK_2 = 0xfd, FLAGS_AT = 2, SYSTEM_AT = 5, COMPONENT_AT = 6;
/** Behind the frame: link, time, signature. */
const TIME_BYTES = 6, SIGNATURE_BYTES = 6, TAIL_BYTES = 1 + TIME_BYTES + SIGNATURE_BYTES;
const EPOCH_MS = Date.UTC(2015, 0, 1);
/** Signatures count in 10 us. */
const A_MS = 100, A_MINUTE = 60_000 * A_MS;
const OUR_LINK = 0;

export class Signing {
  /** Frames that were not believed. */
  dropped = 0;
  #key;
  #unix_ms;
  #last = 0;          // of all times that were sent or believed
  #heard = new Map(); // "system component link" -> the time of its last frame

  /** `key`: 32 bytes. `unix_ms()`: the time of the clock. With it times grow from one program to the next. */
  constructor(key, unix_ms) {
    this.#key = key;
    this.#unix_ms = unix_ms;
  }

  get #now() {
    return Math.floor((this.#unix_ms() - EPOCH_MS) * A_MS);
  }

  #signature(bytes) {
    return createHash("sha256").update(this.#key).update(bytes).digest().subarray(0, SIGNATURE_BYTES);
  }

  /** The frame with its signature. It says already that it is signed. */
  sign(frame) {
    const tail = Buffer.alloc(1 + TIME_BYTES);
    this.#last = Math.max(this.#now, this.#last + 1);
    tail.writeUInt8(OUR_LINK);
    tail.writeUIntLE(this.#last, 1, TIME_BYTES);
    const whole = Buffer.concat([frame, tail]);
    return Buffer.concat([whole, this.#signature(whole)]);
  }

  /** Whether to believe that frame: its signature is right, and it is newer than all of its sender before. */
  believes(frame) {
    const isBelieved = this.#isRight(frame) && this.#isNew(frame);
    if (!isBelieved) this.dropped += 1;
    return isBelieved;
  }

  #isRight(frame) {
    if (frame[0] !== MAVLINK_2 || !(frame[FLAGS_AT] & SIGNED) || frame.length < TAIL_BYTES) return false;
    const end = frame.length - SIGNATURE_BYTES;
    return this.#signature(frame.subarray(0, end)).equals(frame.subarray(end));
  }

  /** One that was not heard before may be a minute behind. */
  #isNew(frame) {
    const tail = frame.length - TAIL_BYTES, time = frame.readUIntLE(tail + 1, TIME_BYTES);
    const sender = `${frame[SYSTEM_AT]} ${frame[COMPONENT_AT]} ${frame[tail]}`;
    if (time <= (this.#heard.get(sender) ?? Math.max(this.#now, this.#last) - A_MINUTE)) return false;
    this.#heard.set(sender, time);
    this.#last = Math.max(this.#last, time);
    return true;
  }
}
