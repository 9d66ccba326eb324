// Connections to TAK: a server over TCP or TLS, clients that connect to us, a multicast group.
import { createSocket } from "node:dgram";
import { connect as connectTcp, createServer } from "node:net";
import { connect as connectTls } from "node:tls";
import { NoEvent, Splitter, event, toXml } from "./cot.mjs";

const MOST_BEHIND = 4 * 1024 * 1024; // bytes that a client has not taken yet; then the rest waits
const LONGEST_WAIT_MS = 10_000;
const MOST_A_SECOND = 100; // events of one sender; what is more is dropped
const BURST = 500;

/** What comes from one sender: parted, limited. */
class Intake {
  #splitter = new Splitter();
  #left = BURST;
  #at = performance.now();

  constructor(heard, counts) {
    Object.assign(this, { heard, counts });
  }

  /** Throws NoEvent when nothing that comes can be read any more. */
  take(bytes, answer) {
    for (const xml of this.#splitter.take(bytes)) {
      const now = performance.now();
      this.#left = Math.min(BURST, this.#left + ((now - this.#at) / 1000) * MOST_A_SECOND);
      this.#at = now;
      if (/type=["']t-x-c-t["']/.test(xml)) {
        answer?.(toXml(event({ uid: "muster-pong", type: "t-x-c-t-r", at: { latitude: 0, longitude: 0 }, now: Date.now(), holds: 20_000 })));
      } else if (this.#left < 1) {
        ++this.counts.dropped;
      } else {
        --this.#left;
        this.heard(xml);
      }
    }
  }
}

/** All connections. `heard(xml)`: an event that came; `joined()`: somebody new listens; `note(words, once)`. */
export class Links {
  #sockets = new Set();
  #timer = null; // of the next try to connect
  #closers = [];

  constructor(options, { heard, joined, note }) {
    Object.assign(this, { options, heard, joined, note });
    this.counts = { sent: 0, behind: 0, dropped: 0 };
  }

  /** Resolves when it listens where it is to listen. Throws where that cannot be. */
  async open() {
    const { connect, listen, bind, multicast } = this.options;
    if (connect) this.#connect(500);
    if (multicast) await this.#join(multicast);
    if (listen === null) return;
    const server = createServer((socket) => this.#welcome(socket, `${socket.remoteAddress}:${socket.remotePort}`));
    await new Promise((resolve, reject) => server.once("error", reject).listen(listen, bind, resolve));
    this.port = server.address().port;
    this.#closers.push(() => server.close());
  }

  #connect(wait) {
    const { host, port } = this.options.connect;
    const { tls } = this.options;
    const socket = tls ? connectTls({ host, port, ...tls }) : connectTcp({ host, port });
    let isOpen = false;
    socket.once(tls ? "secureConnect" : "connect", () => {
      isOpen = true;
      this.note(`connected to ${host}:${port}`);
      this.#welcome(socket, `${host}:${port}`);
    });
    const failed = (error) => { this.trouble = error?.message ?? "the server closed the connection"; };
    socket.once("error", failed);
    socket.once("close", () => {
      if (this.closed) return;
      const next = isOpen ? 500 : Math.min(2 * wait, LONGEST_WAIT_MS);
      this.note(`${host}:${port}: ${this.trouble ?? "the server closed the connection"}; trying again`, `lost ${this.trouble}`);
      this.trouble = undefined;
      this.#timer = setTimeout(() => this.#connect(next), next);
    });
  }

  #welcome(socket, name) {
    const intake = new Intake(this.heard, this.counts);
    socket.setNoDelay(true);
    this.#sockets.add(socket);
    socket.on("data", (bytes) => {
      try {
        intake.take(bytes, (xml) => socket.write(xml));
      } catch (error) {
        if (!(error instanceof NoEvent)) throw error;
        ++this.counts.dropped;
        this.note(`${name}: ${error.message}; it is cut off`);
        socket.destroy();
      }
    });
    socket.on("error", () => {});
    socket.on("close", () => this.#sockets.delete(socket));
    this.joined();
  }

  async #join({ host, port }) {
    const socket = createSocket({ type: "udp4", reuseAddr: true });
    await new Promise((resolve, reject) => socket.once("error", reject).bind(port, resolve));
    socket.addMembership(host);
    socket.setMulticastTTL(this.options.ttl);
    socket.on("error", (error) => this.note(`${host}:${port}: ${error.message}`, error.message));
    const intakes = new Map();
    socket.on("message", (bytes, { address }) => {
      if (!intakes.has(address) && intakes.size < 1000) intakes.set(address, new Intake(this.heard, this.counts));
      try {
        intakes.get(address)?.take(Buffer.concat([bytes, Buffer.from("\n")]));
      } catch {
        ++this.counts.dropped;
        intakes.delete(address);
      }
    });
    this.group = (xml) => socket.send(xml, port, host);
    this.#closers.push(() => socket.close());
  }

  /** Whether somebody may hear what is sent. */
  get isHeard() {
    return this.#sockets.size > 0 || this.group !== undefined;
  }

  /** Sends an event to all. False: somebody has not taken what was sent before; it is sent all the same, but more should wait. */
  send(object) {
    const xml = toXml(object);
    let keepsUp = true;
    for (const socket of this.#sockets) {
      if (socket.writableLength > 4 * MOST_BEHIND) {
        ++this.counts.behind;
        socket.destroy();
        continue;
      }
      socket.write(xml);
      if (socket.writableLength > MOST_BEHIND) keepsUp = false;
    }
    this.group?.(xml);
    ++this.counts.sent;
    return keepsUp;
  }

  /** Ends all connections. A second time it does nothing more; nothing that is sent afterwards goes to the group. */
  close() {
    this.closed = true;
    this.group = undefined;
    clearTimeout(this.#timer);
    for (const socket of this.#sockets) socket.end();
    for (const close of this.#closers.splice(0)) close();
    setTimeout(() => { for (const socket of this.#sockets) socket.destroy(); }, 500).unref();
  }
}
