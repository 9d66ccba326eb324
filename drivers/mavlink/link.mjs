// Bytes to and from an autopilot: UDP, TCP, a serial line.
import { spawnSync } from "node:child_process";
import dgram from "node:dgram";
import { openSync } from "node:fs";
import net from "node:net";
import tty from "node:tty";

const AGAIN_MS = 1000;

/**
 * Opens the link of options.mjs. `hear(bytes, isDatagram)` returns whether they are of the autopilot: udpin answers to whom they
 * came from. Returns {send(bytes), close()}. What cannot be sent is lost, as on the air; what goes wrong is said to `note`. When the
 * port cannot be had, that is said to `refuse`; throws when there is no such device.
 */
export function openLink({ kind, host, number }, hear, note, refuse) {
  return { udpin: () => udp(null), udpout: () => udp({ address: host, port: number }), tcp, serial }[kind]();

  function udp(partner) {
    let peer = partner;
    const socket = dgram.createSocket(net.isIPv6(host) ? "udp6" : "udp4");
    let isBound = partner !== null;
    socket.on("listening", () => (isBound = true));
    socket.on("error", (error) => {
      const words = error.code === "EADDRINUSE" ? `port ${number} of ${host} is taken by another program` : error.message;
      if (isBound) note(`${kind}: ${words}`);
      else refuse(`${kind}: ${words}`);
    });
    socket.on("message", (bytes, { address, port }) => {
      if (hear(bytes, true) && !partner) peer = { address, port };
    });
    if (!partner) socket.bind(number, host);
    const send = (bytes) => peer && socket.send(bytes, peer.port, peer.address, () => {});
    return { send, close: () => socket.close() };
  }

  function tcp() {
    let socket = null, timer = null;
    const connect = () => {
      socket = net.connect(number, host);
      socket.setNoDelay(true);
      socket.on("data", (bytes) => hear(bytes, false));
      socket.on("error", (error) => note(`tcp: ${error.message}`));
      socket.on("close", () => (timer = setTimeout(connect, AGAIN_MS)));
    };
    connect();
    const close = () => {
      socket.removeAllListeners("close");
      clearTimeout(timer);
      socket.destroy();
    };
    return { send: (bytes) => socket.writable && !socket.connecting && socket.write(bytes), close };
  }

  function serial() {
    const set = spawnSync("stty", ["-F", host, String(number), "raw", "-echo", "-hupcl", "clocal"], { encoding: "utf8" });
    if (set.status !== 0) throw new Error(`serial: ${(set.stderr || String(set.error)).trim()}`);
    const input = new tty.ReadStream(openSync(host, "r")), output = new tty.WriteStream(openSync(host, "w"));
    input.on("data", (bytes) => hear(bytes, false));
    for (const stream of [input, output]) stream.on("error", (error) => note(`serial: ${error.message}`));
    const close = () => [input, output].forEach((stream) => stream.destroy());
    return { send: (bytes) => output.write(bytes), close };
  }
}
