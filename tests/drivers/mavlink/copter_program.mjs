// The test copter with a link and a clock, as copter_main.mjs has it; tests have it in their own process.
import dgram from "node:dgram";
import { openSync } from "node:fs";
import net from "node:net";
import tty from "node:tty";
import { parseArgs } from "node:util";
import { Copter } from "./copter.mjs";
import { CopterProtocol } from "./copter_protocol.mjs";
import { Signing } from "../../../drivers/mavlink/signing.mjs";

const STEP_MS = 5, TRACK_MS = 100, UP_M = 10;
const text = (value) => ({ type: "string", default: value });
const OPTIONS = {
  at: text("52.2,0.1"), udp: text(""), tcp: text(""), serial: text(""), kind: text("ardupilot"), system: text("1"), speedup: text("1"), battery: text("100"),
  drain: text("0.02"), "changed-after": text("1e9"), loss: text("0"), delay: text("0"), cut: text("1e9:1e9"), "pilot-at": text("1e9"), "no-fix-at": text("1e9"),
  ready: text("0"), "sign-key": text(""), track: { type: "boolean", default: false },
};

/** Of the options: {put(bytes), close()}. `hear(bytes, isDatagram)`. */
function openLink({ udp, tcp, serial }, hear) {
  if (udp) {
    const [host, port] = udp.split(":");
    const socket = dgram.createSocket("udp4");
    socket.on("message", (bytes) => hear(bytes, true));
    return { put: (bytes) => socket.send(bytes, Number(port), host, () => {}), close: () => socket.close() };
  }
  if (tcp) {
    let partner = null;
    const server = net.createServer((socket) => {
      socket.setNoDelay(true);
      socket.on("data", (bytes) => hear(bytes, false));
      socket.on("error", () => {});
      partner = socket;
    }).listen(Number(tcp), "127.0.0.1");
    return { put: (bytes) => partner?.write(bytes), close: () => (server.close(), partner?.destroy()) };
  }
  const input = new tty.ReadStream(openSync(serial, "r")), output = new tty.WriteStream(openSync(serial, "w"));
  input.setRawMode(true);
  input.on("data", (bytes) => hear(bytes, false));
  return { put: (bytes) => output.write(bytes), close: () => (input.destroy(), output.destroy()) };
}

function copterOf(values) {
  const [latitude_deg, longitude_deg] = values.at.split(",").map(Number), speedup = Number(values.speedup);
  // Ten seconds without a take-off are nothing by the wall where time runs fast.
  const unused_s = Math.max(10, 3 * speedup);
  const copter = new Copter({ kind: values.kind, at: { latitude_deg, longitude_deg }, drain_percent_s: Number(values.drain), unused_s, ready_s: Number(values.ready) });
  copter.battery_percent = Number(values.battery);
  return copter;
}

class Program {
  #once = new Set();
  #told = "";
  #zones = 0;
  #idle_s = 0;
  #last_s = 0;

  constructor(words, say) {
    this.values = parseArgs({ options: OPTIONS, args: words }).values;
    this.say = say;
    const { values } = this, speedup = this.#number("speedup"), started = performance.now();
    this.now = () => ((performance.now() - started) / 1000) * speedup;
    this.copter = copterOf(values);
    const signing = values["sign-key"] ? new Signing(Buffer.from(values["sign-key"], "hex"), Date.now) : null;
    this.protocol = new CopterProtocol(this.copter, { system: this.#number("system"), send: (bytes) => this.#later(() => this.link.put(bytes)), signing });
    this.link = openLink(values, (bytes, isDatagram) => this.#later(() => this.#hear(bytes, isDatagram)));
    this.timers = [setInterval(() => this.#step(), STEP_MS)];
    if (values.track) this.timers.push(setInterval(() => this.#track(), TRACK_MS));
  }

  #number(name) {
    return Number(this.values[name]);
  }

  get #isLost() {
    const [cut_from, cut_until] = this.values.cut.split(":").map(Number), loss = this.#number("loss");
    return (loss > 0 && Math.random() < loss) || (this.now() >= cut_from && this.now() < cut_until);
  }

  #later(act) {
    if (this.#isLost) return;
    const delay_s = this.#number("delay");
    if (delay_s) setTimeout(() => this.link && act(), 1000 * delay_s);
    else if (this.link) act();
  }

  #hear(bytes, isDatagram) {
    this.copter.step(this.now());
    this.protocol.hear(bytes, isDatagram);
    this.protocol.step();
  }

  /** At the time of that option, once. */
  #at(name, act) {
    if (this.#once.has(name) || this.now() < this.#number(name)) return;
    this.#once.add(name);
    act();
  }

  #track() {
    const { place: { latitude_deg, longitude_deg }, at } = this.copter;
    this.say(`track ${JSON.stringify({ unix_ms: Date.now(), latitude_deg, longitude_deg, up_m: at.up })}`);
  }

  #step() {
    const { copter } = this, once = this.#once, time = this.now(), says = (words) => this.say(`${time.toFixed(1)} ${words}`);
    copter.step(time);
    this.#idle_s = copter.armed ? 0 : this.#idle_s + time - this.#last_s;
    this.#last_s = time;
    if (this.#idle_s > this.#number("changed-after") && once.has("flown")) copter.battery_percent = copter.charge_percent = 100;
    if (copter.armed) once.add("flown");
    if (copter.at.up > UP_M && !once.has("up")) once.add("up"), says("is up");
    this.#at("pilot-at", () => copter.setMode(copter.kind === "px4" ? "POSCTL" : "LOITER"));
    this.#at("no-fix-at", () => (copter.hasFix = false));
    this.protocol.step();
    const doing = `${copter.mode} ${copter.armed ? "armed" : "disarmed"}`;
    const keepsOut = copter.polygons.filter(({ isOut }) => isOut).length;
    if (keepsOut !== this.#zones) says(`keeps out of ${(this.#zones = keepsOut)}`);
    if (doing !== this.#told) says((this.#told = doing));
  }

  stop() {
    this.timers.forEach(clearInterval);
    this.link.close();
    this.link = null;
  }
}

/** Starts it with these words of the command line; `say(line)` takes what it does. Returns how to end it. */
export function startCopter(words, say) {
  const program = new Program(words, say);
  return () => program.stop();
}
