// Starts the programs of a test on ports of their own, waits for what they say, and ends them.
import { spawn } from "node:child_process";
import dgram from "node:dgram";
import { once } from "node:events";
import { mkdtempSync, rmSync } from "node:fs";
import net from "node:net";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";
import { MissionMap } from "../../../drivers/places.mjs";

const here = dirname(fileURLToPath(import.meta.url));
export const MAIN = join(here, "../../../drivers/mavlink/main.mjs");
const WAIT_MS = 60_000;
/** Where muster drive --check has its agent. */
export const ORIGIN = { latitude_deg: 52.2, longitude_deg: 0.1 };
const { latitude_deg, longitude_deg } = new MissionMap(ORIGIN).toDegrees({ x_m: 4000, y_m: 4000 });
export const AT = `${latitude_deg},${longitude_deg}`;

/** A port of 127.0.0.1 that nobody uses. */
export async function freePort(isTcp = false) {
  const socket = isTcp ? net.createServer().listen(0, "127.0.0.1") : dgram.createSocket("udp4").bind(0, "127.0.0.1");
  await once(socket, "listening");
  const { port } = socket.address();
  socket.close();
  await once(socket, "close");
  return port;
}

/** The report of muster drive --check --json, behind what it and the driver say meanwhile. */
export const reportIn = (lines) => JSON.parse(lines.slice(lines.findIndex((line) => line.startsWith("{"))).join("\n"));

/** Lines that are kept, and waited for. */
class Lines {
  lines = [];
  #waiting = [];

  keep(line) {
    this.lines.push(line);
    this.look(false);
  }

  look(isOver) {
    this.#waiting = this.#waiting.filter(({ isIt, from, resolve, reject }) => {
      const line = this.lines.slice(from).find(isIt);
      if (line !== undefined) resolve(line);
      else if (isOver) reject(new Error(`ended without it: ${isIt}\n${this.lines.join("\n")}`));
      return line === undefined && !isOver;
    });
  }

  /** A line like that, from the line with that number on. */
  async line(isIt, from = 0) {
    let timer = null;
    const late = new Promise((_, reject) => (timer = setTimeout(() => reject(new Error(`not said: ${isIt}\n${this.lines.join("\n")}`)), WAIT_MS)));
    const found = new Promise((resolve, reject) => this.#waiting.push({ isIt, from, resolve, reject }));
    this.look(false);
    return Promise.race([found, late]).finally(() => clearTimeout(timer));
  }
}

/** A program, and what it says. */
export class Program extends Lines {
  constructor(command, words, options = {}) {
    super();
    this.child = spawn(command, words, { stdio: ["pipe", "pipe", "pipe"], ...options });
    this.ended = once(this.child, "close").then(([code, signal]) => (this.look(true), code ?? signal));
    this.child.stdin.on("error", () => {});
    for (const stream of [this.child.stdout, this.child.stderr]) {
      createInterface({ input: stream }).on("line", (line) => this.keep(line));
    }
  }

  say(line) {
    this.child.stdin.write(`${JSON.stringify(line)}\n`);
  }

  /** Waits for a line of JSON of that type. */
  async said(type) {
    return JSON.parse(await this.line((line) => line.startsWith("{") && JSON.parse(line).type === type));
  }
}

/** Runs `body({start(command, words), copter(words), folder})`; what was started is ended behind it. */
export async function withPrograms(body) {
  const folder = mkdtempSync(join(tmpdir(), "muster-mavlink-"));
  const programs = [], copters = [];
  const start = (command, words, options) => {
    programs.push(new Program(command, words, options));
    return programs.at(-1);
  };
  // A process for each is dear. One at a terminal has its own, so that this one never has a terminal.
  const copter = async (more) => {
    const words = ["--at", AT, ...more];
    let one = new Lines();
    if (words.includes("--serial")) one = start(process.execPath, [join(here, "copter_main.mjs"), ...words]);
    else copters.push((await import("./copter_program.mjs")).startCopter(words, (line) => one.keep(line)));
    await one.line((line) => line.includes("disarmed"));
    return one;
  };
  try {
    return await body({ start, copter, folder });
  } finally {
    for (const stop of copters) stop();
    for (const { child } of programs) child.kill("SIGKILL");
    await Promise.all(programs.map((program) => program.ended));
    rmSync(folder, { recursive: true, force: true });
  }
}
