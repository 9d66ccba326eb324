#!/usr/bin/env node
// The driver as a program: sockets, clock and files around driver.mjs.
import { mkdirSync, readFileSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { dirname } from "node:path";
import { createInterface } from "node:readline";
import { PhotoFolder } from "../photos.mjs";
import { Driver } from "./driver.mjs";
import { FrameReader } from "./frames.mjs";
import { openLink } from "./link.mjs";
import { readOptions, UsageError } from "./options.mjs";

const STEP_MS = 50, FAST_STEP_MS = 5;

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
function pictureKeeper({ run }) {
  const photos = run ? new PhotoFolder(run) : null;
  return (of) => {
    try {
      const name = photos?.keep({ ...of, taken_utc: of.taken_utc ?? new Date().toISOString() });
      if (name) note(`a picture: ${name}`);
    } catch (error) {
      note(`a picture's file: ${error.message}`);
    }
  };
}

function run(options) {
  const reader = new FrameReader();
  const now = () => (performance.now() / 1000) * options.speedup;
  let link = null;
  const driver = new Driver(options, {
    now,
    say: (line) => process.stdout.write(`${JSON.stringify(line)}\n`),
    send: (bytes) => link.send(bytes),
    note,
    kept: keptIn(options.kept),
    isChanged: () => takeFile(options.confirm),
    keepPicture: pictureKeeper(options),
  });
  const endWhenOver = () => {
    if (driver.exitCode === null) return;
    clearInterval(timer);
    link.close();
    process.stdin.destroy();
    process.exitCode = driver.exitCode;
  };
  const hear = (bytes, isDatagram) => {
    const frames = isDatagram ? reader.readDatagram(bytes) : reader.read(bytes);
    const isHeard = frames.filter((frame) => driver.hearFrame(frame)).length > 0;
    endWhenOver();
    return isHeard;
  };
  link = openLink(options.link, hear, note);
  const timer = setInterval(() => (driver.step(), endWhenOver()), options.speedup > 1 ? FAST_STEP_MS : STEP_MS);
  process.stdout.on("error", () => {});  // the mission is gone: stdin says so too
  if (options.restore) return driver.restore();
  const lines = createInterface({ input: process.stdin });
  lines.on("line", (line) => (driver.hearLine(line), endWhenOver()));
  lines.on("close", () => {
    if (driver.order?.type !== "bye") driver.bye("nobody speaks to us any more");
    endWhenOver();
  });
}

try {
  const options = readOptions(process.argv.slice(2));
  if (options) run(options);
} catch (error) {
  note(error.message);
  process.exitCode = error instanceof UsageError ? 2 : 3;
}
