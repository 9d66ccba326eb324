#!/usr/bin/env node
// The driver as a program: sockets, clock and files around driver.mjs.
import { spawn } from "node:child_process";
import { mkdirSync, readFileSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { dirname } from "node:path";
import { createInterface } from "node:readline";
import { setTimeout } from "node:timers/promises";
import { PhotoFolder } from "../photos.mjs";
import { readOptions, UsageError } from "./options.mjs";

const STEP_MS = 50, FAST_STEP_MS = 5, AFTER_MS = 200;
/** A mission greets at once. */
const GREETING_MS = 500;
/** As long as nothing else is known. */
const FIRST_WAIT = "a word of its autopilot";

function note(words) {
  process.stderr.write(`mavlink: ${words}\n`);
}

/** An object in a file, that is whole or not there. */
function keptIn(path) {
  return {
    load() {
      try {
        return JSON.parse(readFileSync(path, "utf8"));
      } catch (error) {
        if (error.code === "ENOENT") return null;
        throw error;
      }
    },
    save(object) {
      mkdirSync(dirname(path), { recursive: true });
      writeFileSync(`${path}.new`, JSON.stringify(object, null, 1));
      renameSync(`${path}.new`, path);
    },
    drop: () => rmSync(path, { force: true }),
  };
}

/** Whether somebody has made the file; it is taken away. */
function takeFile(path) {
  try {
    rmSync(path);
    return true;
  } catch {
    return false;
  }
}

/** Takes what is known of a picture, for the run directory if there is one; what goes wrong there does not concern the flight. */
function pictureKeeper(folder) {
  const photos = folder ? new PhotoFolder(folder) : null;
  return (of) => {
    try {
      const name = photos?.keep({ ...of, taken_utc: of.taken_utc ?? new Date().toISOString() });
      if (name) note(`a picture: ${name}`);
    } catch (error) {
      note(`a picture's file: ${error.message}`);
    }
  };
}

function say(line) {
  process.stdout.write(`${JSON.stringify(line)}\n`);
}

/**
 * The mission's lines, which are kept until somebody hears them. The first is answered at once: what speaks MAVLink takes a
 * sixth of a second of processor time to load, and a mission waits for a greeting only so long, also where many drivers start.
 */
class Lines {
  #kept = [];
  #isClosed = false;
  #hear = null;

  constructor(system) {
    const lines = createInterface({ input: process.stdin });
    this.first = new Promise((resolve) => lines.once("line", resolve).once("close", resolve));
    lines.once("line", (line) => isHello(line) && say({ type: "hello", version: 1, name: `mavlink system ${system}`, not_ready: FIRST_WAIT }));
    lines.on("line", (line) => (this.#hear ? this.#hear.line(line) : this.#kept.push(line)));
    lines.on("close", () => (this.#hear ? this.#hear.close() : (this.#isClosed = true)));
  }

  to(hear) {
    this.#hear = hear;
    for (const line of this.#kept.splice(0)) hear.line(line);
    if (this.#isClosed) hear.close();
  }
}

function isHello(line) {
  try {
    return JSON.parse(line)?.type === "hello";
  } catch {
    return false;
  }
}

/** A mission ends its drivers a moment after its own end. A program of its own does what is left: the way home around zones, the settings. */
function leaveRestorer() {
  spawn(process.execPath, [...process.argv.slice(1), "--restore", "--after", String(process.pid)], { detached: true, stdio: "ignore" }).unref();
}

function isRunning(pid) {
  try {
    return process.kill(pid, 0);
  } catch (error) {
    return error.code === "EPERM";
  }
}

async function run(options) {
  while (options.after && isRunning(options.after)) await setTimeout(AFTER_MS);  // it has the port
  const kept = keptIn(options.kept);
  if (options.after && !kept.load()) return;
  const lines = options.restore ? null : new Lines(options.system);
  await Promise.race([lines?.first, setTimeout(GREETING_MS, null, { ref: false })]);
  const { Driver } = await import("./driver.mjs");
  const { FrameReader } = await import("./frames.mjs");
  const { openLink } = await import("./link.mjs");
  const { Signing } = await import("./signing.mjs");
  const { signKey } = options, signing = signKey && new Signing(signKey.bytes, Date.now);
  if (signKey?.isOpen) note(`others can read the key: chmod 600 ${signKey.path}`);
  const reader = new FrameReader(signing);
  const now = () => (performance.now() / 1000) * options.speedup;
  let link = null;
  const driver = new Driver(options, {
    now,
    say,
    send: (bytes) => link?.send(bytes),
    note,
    kept,
    isChanged: () => takeFile(options.confirm),
    keepPicture: pictureKeeper(options.run),
    signing,
  });
  const endWhenOver = () => {
    if (driver.exitCode === null) return;
    clearInterval(timer);
    if (signing?.dropped) note(`${signing.dropped} messages were not signed with our key, or were old: they were passed over`);
    link?.close();
    process.stdin.destroy();
    process.exitCode = driver.exitCode;
  };
  const hear = (bytes, isDatagram) => {
    const frames = isDatagram ? reader.readDatagram(bytes) : reader.read(bytes);
    const isHeard = frames.filter((frame) => driver.hearFrame(frame)).length > 0;
    endWhenOver();
    return isHeard;
  };
  try {
    link = openLink(options.link, hear, note, (words) => (driver.refuse(words), endWhenOver()));
  } catch (error) {
    driver.refuse(error.message);
  }
  const timer = setInterval(() => (driver.step(), endWhenOver()), options.speedup > 1 ? FAST_STEP_MS : STEP_MS);
  process.stdout.on("error", () => {});  // the mission is gone: stdin says so too
  if (driver.exitCode !== null) return endWhenOver();
  if (options.restore) return driver.restore();
  let isLeft = false;
  const leave = () => {
    if (!driver.isUnfinished || isLeft) return;
    isLeft = true;
    driver.leaveWayHome();
    leaveRestorer();
  };
  lines.to({
    line: (line) => (driver.hearLine(line), leave(), endWhenOver()),
    close: () => {
      if (driver.order?.type !== "bye") driver.bye("nobody speaks to us any more");
      leave();
      endWhenOver();
    },
  });
}

try {
  const options = readOptions(process.argv.slice(2));
  if (options) await run(options);
} catch (error) {
  note(error.message);
  process.exitCode = error instanceof UsageError ? 2 : 3;
}
