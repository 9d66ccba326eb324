// Bytes to MAVLink messages and back. node-mavlink knows the messages and their checksums; here is only what makes its
// streams into calls, so that a driver is a function of what it hears and of the time.
import { ardupilotmega, common, MavLinkPacketSplitter, MavLinkProtocolV1, MavLinkProtocolV2, minimal } from "node-mavlink";

import { SIGNED } from "./signing.mjs";

export { ardupilotmega, common, minimal };

const MESSAGES = { ...minimal.REGISTRY, ...common.REGISTRY, ...ardupilotmega.REGISTRY };
const NO_BYTES = Buffer.alloc(0);

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

function decode(bytes) {
  const protocol = bytes[0] === MavLinkProtocolV1.START_BYTE ? new MavLinkProtocolV1() : new MavLinkProtocolV2();
  const header = protocol.header(bytes);
  const type = MESSAGES[header.msgid];
  if (!type) return [];
  return [{ system: header.sysid, component: header.compid, name: type.MSG_NAME, message: protocol.data(protocol.payload(bytes), type) }];
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
  return Object.assign(new type(), fields);
}
