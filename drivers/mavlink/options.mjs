// The command line.
import { readFileSync, statSync } from "node:fs";
import { homedir } from "node:os";
import { join } from "node:path";
import { parseArgs } from "node:util";

const HELP = `node main.mjs --connect LINK --system N [OPTION...]

Takes a UAV's part in a mission (docs/guide/drivers.md) with an autopilot that speaks MAVLink, ArduPilot's Copter or PX4
(docs/guide/mavlink.md).

  --connect LINK      udpin:[HOST:]PORT, udpout:HOST:PORT, tcp:HOST:PORT or serial:PATH:BAUD
  --system N          the autopilot's system id, 1 to 250
  --altitude M        above home, of uav:0 (default: 40)
  --altitude-step M   each further UAV flies so much higher (default: 5)
  --ceiling M         no UAV flies higher (default: 120)
  --reserve PERCENT   it comes home with so much battery left, and has no range 10 % above (default: 25)
  --land-idle S       with nothing to do for so long it lands at home, until it is sent somewhere; 0: never (default: 120)
  --confirm HOW       that the battery was changed: FILE, which somebody makes then, or battery, its report alone, for
                      simulators (default: system-N.changed in the folder of --keep)
  --cells N           of the battery, in series, 1 to 24 (default: what PX4 has set; with ArduPilot it has to be said)
  --charged PERCENT   and it reports at least so much (default: 90)
  --camera HOW        what the autopilot is told for a picture: digicam (DO_DIGICAM_CONTROL), image (IMAGE_START_CAPTURE) or
                      none (default: digicam)
  --run DIR           the mission's run directory: of each picture that the autopilot or its camera reports a file of what is known
                      of it goes to DIR/photos (default: none)
  --sign-key FILE     signs what is sent, and believes only what is signed with this key: a file of 64 hex digits that nobody
                      else can read (default: no signatures)
  --speedup X         the vehicle is simulated, and its time runs X times as fast (default: 1)
  --own-system N      our own system id; the autopilot's SYSID_MYGCS (default: 255)
  --keep FOLDER       where the settings that were changed are kept until they are put back (default: ~/.local/state/muster)
  --restore           only puts them back
  --after PID         with --restore: when that program has ended and the UAV has landed, up to 15 minutes later; if the program
                      left a way home around zones, it is flown first
`;

/** Of a file's mode: what it lets others than its owner do. */
const OTHERS = 0o077;

export class UsageError extends Error {}

function number(values, name, low, high) {
  const value = Number(values[name]);
  if (!(values[name].trim() && value >= low && value <= high)) throw new UsageError(`--${name}: found '${values[name]}', expected a number from ${low} to ${high}`);
  return value;
}

function link(text) {
  const found = /^(udpin|udpout|tcp|serial):(?:(.+):)?([0-9]+)$/.exec(text);
  const expected = "udpin:[HOST:]PORT, udpout:HOST:PORT, tcp:HOST:PORT or serial:PATH:BAUD";
  if (!found) throw new UsageError(`--connect: found '${text}', expected ${expected}`);
  const [, kind, at, last] = found;
  const host = at ?? (kind === "udpin" ? "127.0.0.1" : "");
  if (!host || (kind !== "serial" && Number(last) > 65535)) throw new UsageError(`--connect: found '${text}', expected ${expected}`);
  return { kind, host, number: Number(last), text };
}

/** {bytes, path, isOpen}: 32 bytes, and whether others can read the file; null: none is named. */
function key(path) {
  if (!path) return null;
  let text;
  try {
    text = readFileSync(path, "utf8").trim();
  } catch (error) {
    throw new UsageError(`--sign-key: ${path} cannot be read (${error.code}), expected a file of 64 hex digits`);
  }
  if (/^[0-9a-f]{64}$/i.test(text)) return { bytes: Buffer.from(text, "hex"), path, isOpen: (statSync(path).mode & OTHERS) !== 0 };
  throw new UsageError(`--sign-key: ${path}: found ${text.length} characters, expected 64 hex digits`);
}

/** The options; null: help was asked for, and given. Throws UsageError. */
export function readOptions(argv) {
  const defaults = {
    connect: "", system: "", altitude: "40", "altitude-step": "5", ceiling: "120", reserve: "25", "land-idle": "120", confirm: "", charged: "90", cells: "0", camera: "digicam",
    run: "", speedup: "1", "sign-key": "", "own-system": "255", after: "0", keep: join(process.env.XDG_STATE_HOME || join(homedir(), ".local", "state"), "muster"),
  };
  const options = Object.fromEntries(Object.entries(defaults).map(([name, value]) => [name, { type: "string", default: value }]));
  let values;
  try {
    ({ values } = parseArgs({ args: argv, options: { ...options, restore: { type: "boolean" }, help: { type: "boolean", short: "h" } } }));
  } catch (error) {
    throw new UsageError(error.message.split(". ")[0]);
  }
  if (values.help) {
    process.stdout.write(HELP);
    return null;
  }
  if (!["digicam", "image", "none"].includes(values.camera)) throw new UsageError(`--camera: found '${values.camera}', expected digicam, image or none`);
  const connect = link(values.connect);
  const system = number(values, "system", 1, 250);
  return {
    link: connect, system, ownSystem: number(values, "own-system", 1, 255), altitude: number(values, "altitude", 5, 1000),
    altitudeStep: number(values, "altitude-step", 0, 100), ceiling: number(values, "ceiling", 5, 1000), reserve: number(values, "reserve", 10, 80),
    landIdle: number(values, "land-idle", 0, 86400),
    confirm: values.confirm || join(values.keep, `system-${system}.changed`), charged: number(values, "charged", 1, 100), cells: number(values, "cells", 0, 24), camera: values.camera,
    run: values.run || null, speedup: number(values, "speedup", 1, 1000), signKey: key(values["sign-key"]), kept: join(values.keep, `system-${system}.json`), restore: values.restore === true,
    after: number(values, "after", 0, 2 ** 31),
  };
}
