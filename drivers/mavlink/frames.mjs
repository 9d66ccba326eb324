// Bytes to MAVLink messages and back. node-mavlink knows the messages and their checksums; here is only what makes its
// streams into calls, so that a driver is a function of what it hears and of the time.
import { createRequire } from "node:module";

import { SIGNED } from "./signing.mjs";

// By require, not by import: an import searches the text of the package for the names that it exports, which doubles the time to load it.
const { ardupilotmega, common, MavLinkPacketSplitter, MavLinkProtocolV1, MavLinkProtocolV2, minimal } = createRequire(import.meta.url)("node-mavlink");

export { ardupilotmega, common, minimal };

const MESSAGES = { ...minimal.REGISTRY, ...common.REGISTRY, ...ardupilotmega.REGISTRY };
const NO_BYTES = Buffer.alloc(0);
const PROTOCOLS = { [MavLinkProtocolV1.START_BYTE]: new MavLinkProtocolV1(), [MavLinkProtocolV2.START_BYTE]: new MavLinkProtocolV2() };

/**
 * What stands in for the constructor of a class of messages, which takes longer than reading or writing the message: `Bare` makes a
 * message of that class without fields, for callers that set all of them; `defaults` has all fields as the constructor sets them.
 */
function partsOf(type) {
  if (!PARTS.has(type)) {
    const Bare = function () {};
    Bare.prototype = type.prototype;
    Object.assign(Bare, { MSG_NAME: type.MSG_NAME, FIELDS: type.FIELDS });
    const defaults = new type();
    for (const value of Object.values(defaults)) Object.freeze(value);  // lists: all messages share them
    PARTS.set(type, { Bare, defaults });
  }
  return PARTS.get(type);
}

const PARTS = new WeakMap();

class Splitter extends MavLinkPacketSplitter {
  found = [];
  push(frame) {
    if (frame) this.found.push(frame.buffer);
    return true;
  }
  /** What is left of the stream, for want of its end. */
  get rest() {
    return this.buffer;
  }
  drop() {
    this.buffer = NO_BYTES;
  }
}

/** Finds the messages in bytes. Whatever else is in them is passed over. */
export class FrameReader {
  #splitter = new Splitter();
  #signing;

  /** `signing`: of signing.mjs, which says what to believe; null: everything. */
  constructor(signing = null) {
    this.#signing = signing;
  }

  /** Of a stream: what is not complete waits for the rest. Returns [{system, component, name, message}]. */
  read(bytes) {
    this.#splitter._transform(bytes, "buffer", () => {});
    const rest = this.#splitter.rest;
    if (rest.length && !rest.includes(MavLinkProtocolV1.START_BYTE) && !rest.includes(MavLinkProtocolV2.START_BYTE)) this.#splitter.drop();
    const frames = this.#splitter.found.splice(0);
    return frames.filter((frame) => !this.#signing || this.#signing.believes(frame)).flatMap(decode);
  }

  /** Of a datagram, which holds whole frames only. */
  readDatagram(bytes) {
    this.#splitter.drop();
    return this.read(bytes);
  }
}

/** The payload of the message that is being read; used again for the next. */
const PAYLOAD = Buffer.alloc(255);

function decode(bytes) {
  const protocol = PROTOCOLS[bytes[0]];
  const header = protocol.header(bytes);
  const type = MESSAGES[header.msgid];
  if (!type) return [];
  const from = protocol.constructor.PAYLOAD_OFFSET;
  PAYLOAD.fill(0);  // zeros at its end are not sent
  bytes.copy(PAYLOAD, 0, from, from + header.payloadLength);
  return [{ system: header.sysid, component: header.compid, name: type.MSG_NAME, message: protocol.data(PAYLOAD, partsOf(type).Bare) }];
}

/** Makes frames of messages, in MAVLink 2. `signing`: of signing.mjs; null: they are not signed. */
export class FrameWriter {
  #protocol;
  #signing;
  #number = 0;

  constructor(system, component, signing = null) {
    this.#protocol = new MavLinkProtocolV2(system, component, signing ? SIGNED : 0);
    this.#signing = signing;
  }

  write(message) {
    const bytes = this.#protocol.serialize(message, this.#number);
    this.#number = (this.#number + 1) & 255;
    return this.#signing ? this.#signing.sign(bytes) : bytes;
  }
}

/** A message of that class with these fields, all others 0. */
export function make(type, fields) {
  const { Bare, defaults } = partsOf(type);
  return Object.assign(new Bare(), defaults, fields);
}
