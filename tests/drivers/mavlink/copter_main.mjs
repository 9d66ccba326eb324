#!/usr/bin/env node
// The test copter as a program, over UDP, TCP or a terminal: node copter_main.mjs --at LATITUDE,LONGITUDE [OPTION...]
//   --udp HOST:PORT      sends there, as autopilots do          --tcp PORT   waits for one who connects, on 127.0.0.1
//   --serial PATH        a terminal                             --kind ardupilot|px4, --system N, --speedup X
//   --battery PERCENT, --drain PERCENT_A_SECOND                 --changed-after S: of standing with the motors off it is full
//   --loss SHARE, --delay S (of the wall), --cut FROM:UNTIL     of the link
//   --pilot-at S, --no-fix-at S                                 the pilot takes over; its position is lost
//   --ready S                                                   its estimator takes so long
//   --track                                                     says where it is, ten times a second of the wall
//   --sign-key HEX                                              signs, and believes nobody who does not
// Times are its own seconds since it was started. It ends when its standard input does. Prints what it does.
import dgram from "node:dgram";
import { openSync } from "node:fs";
import net from "node:net";
import tty from "node:tty";
import { parseArgs } from "node:util";
import { Copter } from "./copter.mjs";
import { CopterProtocol } from "./copter_protocol.mjs";
import { Signing } from "../../../drivers/mavlink/signing.mjs";

const STEP_MS = 5, UP_M = 10;
const text = (value) => ({ type: "string", default: value });
const { values } = parseArgs({
  options: {
    at: text("52.2,0.1"), udp: text(""), tcp: text(""), serial: text(""), kind: text("ardupilot"), system: text("1"), speedup: text("1"), battery: text("100"),
    drain: text("0.02"), "changed-after": text("1e9"), loss: text("0"), delay: text("0"), cut: text("1e9:1e9"), "pilot-at": text("1e9"), "no-fix-at": text("1e9"), ready: text("0"), "sign-key": text(""), track: { type: "boolean", default: false },
  },
});
const number = (name) => Number(values[name]);
const [latitude_deg, longitude_deg] = values.at.split(",").map(Number);
const [cut_from, cut_until] = values.cut.split(":").map(Number);
const started = performance.now();
const now = () => ((performance.now() - started) / 1000) * number("speedup");

// Ten seconds without a take-off are nothing by the wall where time runs fast.
const unused_s = Math.max(10, 3 * number("speedup"));
const copter = new Copter({ kind: values.kind, at: { latitude_deg, longitude_deg }, drain_percent_s: number("drain"), unused_s, ready_s: number("ready") });
copter.battery_percent = number("battery");

const isLost = () => Math.random() < number("loss") || (now() >= cut_from && now() < cut_until);
const later = (act) => !isLost() && (number("delay") ? setTimeout(act, 1000 * number("delay")) : act());

let put = () => {};
const signing = values["sign-key"] ? new Signing(Buffer.from(values["sign-key"], "hex"), Date.now) : null;
const protocol = new CopterProtocol(copter, { system: number("system"), send: (bytes) => later(() => put(bytes)), signing });
const hear = (bytes, isDatagram) => later(() => (copter.step(now()), protocol.hear(bytes, isDatagram), protocol.step()));

if (values.udp) {
  const [host, port] = values.udp.split(":");
  const socket = dgram.createSocket("udp4");
  socket.on("message", (bytes) => hear(bytes, true));
  put = (bytes) => socket.send(bytes, Number(port), host, () => {});
} else if (values.tcp) {
  net.createServer((socket) => {
    socket.setNoDelay(true);
    socket.on("data", (bytes) => hear(bytes, false));
    socket.on("error", () => {});
    put = (bytes) => socket.write(bytes);
  }).listen(Number(values.tcp), "127.0.0.1");
} else {
  const input = new tty.ReadStream(openSync(values.serial, "r")), output = new tty.WriteStream(openSync(values.serial, "w"));
  input.setRawMode(true);
  input.on("data", (bytes) => hear(bytes, false));
  put = (bytes) => output.write(bytes);
}

let told = "", zones = 0, idle_s = 0, last_s = 0;
const once = new Set();
function at(name, act) {
  if (once.has(name) || now() < number(name)) return;
  once.add(name);
  act();
}

if (values.track) {
  setInterval(() => {
    const { latitude_deg, longitude_deg } = copter.place;
    process.stdout.write(`track ${JSON.stringify({ unix_ms: Date.now(), latitude_deg, longitude_deg, up_m: copter.at.up })}\n`);
  }, 100);
}
setInterval(() => {
  const time = now();
  copter.step(time);
  idle_s = copter.armed ? 0 : idle_s + time - last_s;
  last_s = time;
  if (idle_s > number("changed-after") && once.has("flown")) copter.battery_percent = copter.charge_percent = 100;
  if (copter.armed) once.add("flown");
  if (copter.at.up > UP_M && !once.has("up")) once.add("up"), process.stdout.write(`${time.toFixed(1)} is up\n`);
  at("pilot-at", () => copter.setMode(values.kind === "px4" ? "POSCTL" : "LOITER"));
  at("no-fix-at", () => (copter.hasFix = false));
  protocol.step();
  const doing = `${copter.mode} ${copter.armed ? "armed" : "disarmed"}`;
  const keepsOut = copter.polygons.filter(({ isOut }) => isOut).length;
  if (keepsOut !== zones) process.stdout.write(`${time.toFixed(1)} keeps out of ${(zones = keepsOut)}\n`);
  if (doing !== told) process.stdout.write(`${time.toFixed(1)} ${(told = doing)}\n`);
}, STEP_MS);
process.stdin.on("end", () => process.exit(0)).resume();
