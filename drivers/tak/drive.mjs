#!/usr/bin/env node
// A driver for a TAK user who takes the part of a worker or a vehicle: docs/guide/tak.md.
import { createInterface } from "node:readline";
import { Phone } from "../phone/phone.mjs";
import { NoEvent, readEvent } from "./cot.mjs";
import { Links } from "./links.mjs";
import { UsageError, readDriverOptions } from "./options.mjs";
import { Person } from "./person.mjs";

const STEP_MS = 100;
const FAREWELL_MS = 500;

const note = (words) => void process.stderr.write(`tak: ${words}\n`);

async function run(options) {
  const phone = new Phone({ ...options, isAuto: false, photos: false }, { now: () => performance.now() / 1000, say: (line) => process.stdout.write(`${JSON.stringify(line)}\n`), note });
  let isUnread = false;
  const links = new Links(options, { note, joined: () => person.repeat(), heard: (xml) => {
    try {
      person.hear(readEvent(xml, Date.now()), Date.now());
    } catch (error) {
      if (!(error instanceof NoEvent)) throw error;
      if (!isUnread) note(`an event is dropped: ${error.message}; others are dropped without a word`);
      isUnread = true;
    }
  } });
  const person = new Person({ callsign: options.callsign, phone, send: (object) => links.send(object), session: phone.session,
    clock: (ms) => new Date(ms).toTimeString().slice(0, 5) });
  const step = () => {
    phone.step();
    if (links.isHeard) person.step(Date.now());
  };
  const timer = setInterval(step, STEP_MS);
  const end = () => {
    clearInterval(timer);
    step();
    setTimeout(() => links.close(), FAREWELL_MS);
    process.stdin.destroy();
  };
  process.stdout.on("error", () => {}); // the mission is gone: stdin says so too
  const lines = createInterface({ input: process.stdin });
  lines.on("line", (line) => {
    phone.hearLine(line);
    if (phone.over !== null) end();
  });
  lines.on("close", () => {
    if (phone.over !== null) return;
    note("nobody speaks to us any more");
    end();
  });
  await links.open();
  if (links.port) note(`listening on ${options.bind}:${links.port}`);
}

try {
  const options = readDriverOptions(process.argv.slice(2));
  if (options) await run(options);
} catch (error) {
  note(error.message);
  process.exitCode = error instanceof UsageError ? 2 : 3;
}
