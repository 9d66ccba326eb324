#!/usr/bin/env node
// A mission on the screens of TAK clients: docs/guide/tak.md.
import { constants, setPriority } from "node:os";
import { Inbox } from "./inbox.mjs";
import { Links } from "./links.mjs";
import { Mission } from "./mission.mjs";
import { UsageError, readOptions } from "./options.mjs";
import { Picture } from "./picture.mjs";
import { chat } from "./cot.mjs";

const MOST_LINES = 20; // of a decision in the room
const QUIET_MS = 10_000; // a note that says the same again comes no sooner

const told = new Map();
/** For the person who runs it. `once`: what makes it the same as an earlier one, which is not told again for a while. */
function note(words, once = words) {
  const now = Date.now();
  if (now - (told.get(once) ?? 0) < QUIET_MS) return;
  if (told.size > 1000) told.clear();
  told.set(once, now);
  process.stderr.write(`tak: ${words}\n`);
}

async function run(options) {
  setPriority(constants.priority.PRIORITY_BELOW_NORMAL); // a mission on this machine comes first
  const picture = new Picture(options);
  let number = 0;
  const waiting = []; // events that are due, to be sent as the pace allows
  const say = (to, text) => {
    if (!picture.run) return;
    waiting.unshift(chat({ from: picture.self, to, text, at: picture.hasPlaces ? picture.middle : { latitude: 0, longitude: 0 }, now: Date.now(), number: `${process.pid}-${++number}` }));
    drain();
  };
  const mission = new Mission(options.mission, { note, changed: (fresh, isNew) => {
    if (isNew) picture.begin(fresh);
    if (isNew && !picture.hasPlaces) note("the scenario has no origin: it is nowhere on the earth, so nothing can be shown");
  } });
  const inbox = new Inbox({ allow: options.allow, mission, picture, say, note });
  const links = new Links(options, { note, heard: (xml) => void inbox.take(xml).catch((error) => note(`an event is dropped: ${error.message}`)), joined: () => picture.repeat() });
  await links.open();
  if (links.port) process.stdout.write(`listening on ${options.bind}:${links.port}\n`);

  function drain() {
    const budget = Math.max(1, Math.floor(options.most * options.every));
    for (let i = 0; i < budget && waiting.length > 0; ++i) if (!links.send(waiting.shift())) return;
  }
  const room = (lines) => {
    if (!options.room || lines.length === 0) return;
    const more = lines.length > MOST_LINES ? [`and ${lines.length - MOST_LINES} more`] : [];
    say({ callsign: options.room, uid: options.room }, [...lines.slice(0, MOST_LINES), ...more].join("\n"));
  };
  const step = () => {
    if (!links.isHeard || !picture.run) return;
    // What has not been sent yet is old by now; events that wait are made anew.
    if (waiting.length === 0) waiting.push(...picture.due(Date.now()));
    room(picture.news());
    drain();
  };
  const timer = setInterval(step, 1000 * options.every);
  const end = () => {
    clearInterval(timer);
    mission.close();
    links.close();
    const { heard, taken, refused, unreadable } = inbox.counts;
    note(`sent ${links.counts.sent} events; heard ${heard}: ${taken} taken, ${refused} refused, ${unreadable} unreadable, ${links.counts.dropped} dropped`);
  };
  for (const signal of ["SIGINT", "SIGTERM"]) process.once(signal, end);
  await mission.follow();
  if (!mission.isOver) return;
  // All that the mission came to is shown before the end.
  for (let i = 0, isLast = false; i < 600 && links.isHeard && !links.closed; ++i) {
    step();
    if (waiting.length === 0 && isLast) break;
    isLast = waiting.length === 0; // what was waiting may be older than the end
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
  if (links.closed) return; // it was told to end meanwhile
  note("the mission is over");
  end();
}

try {
  const options = readOptions(process.argv.slice(2));
  if (options) await run(options);
} catch (error) {
  process.stderr.write(`tak: ${error.message}\n`);
  process.exitCode = error instanceof UsageError ? 2 : 3;
}
