#!/usr/bin/env node
// The driver as a program: sockets, clock and files around phone.mjs.
import { once } from "node:events";
import { createInterface } from "node:readline";
import { setTimeout } from "node:timers/promises";
import { beAuto } from "./auto.mjs";
import { codeOf, isLoopback, keptLink, newToken, originsOf } from "./link.mjs";
import { readOptions, UsageError } from "./options.mjs";
import { Phone } from "./phone.mjs";
import { Photos } from "./photos.mjs";
import { PageServer } from "./server.mjs";

const STEP_MS = 100;
/** The page has so long to hear that the mission is over. */
const FAREWELL_MS = 1500;
const PORT_TRIES = 20;

function note(words) {
  process.stderr.write(`phone: ${words}\n`);
}

async function listen(http, address, port) {
  http.listen(port, address);
  await once(http, "listening");
  return http.address().port;
}

/** Listens on the port of before where it is free, or is soon: the driver of before may be about to end. Else on any. */
async function listenAgain(http, address, port) {
  for (let i = 0; i < PORT_TRIES; ++i) {
    try {
      return await listen(http, address, port);
    } catch {
      await setTimeout(STEP_MS);
    }
  }
  return listen(http, address, 0);
}

async function open(server, options, agent) {
  const kept = keptLink(options.run, agent);
  const before = kept.load();
  server.token = before?.token ?? newToken();
  const isAgain = options.port === 0 && before;
  const port = await (isAgain ? listenAgain(server.http, options.listen, before.port) : listen(server.http, options.listen, options.port));
  const origins = originsOf(options, port);
  server.origins = () => origins;
  const url = `${origins[0]}/${server.token}/`;
  kept.save({ agent, url, token: server.token, port });
  if (!isLoopback(options.listen)) {
    note(`WARNING: everybody in the network of ${options.listen} can reach this page; only the token in its link keeps it, and it is not encrypted`);
  }
  note(`the link of ${agent}: ${url}`);
  if (options.isAuto) return;
  const hasColours = Boolean(process.stderr.isTTY) && !process.env.NO_COLOR;
  const code = await codeOf(url, hasColours);
  if (code) process.stderr.write(`${code.join("\n")}\n`);
  else note("no QR code: npm ci --prefix drivers/phone --ignore-scripts brings what draws it");
}

function run(options) {
  const phone = new Phone(options, { now: () => performance.now() / 1000, say: (line) => process.stdout.write(`${JSON.stringify(line)}\n`), note });
  if (options.isAuto) beAuto(phone);
  const photos = options.run ? new Photos(options.run) : null;
  const server = new PageServer({ token: "", origins: () => [], phone, photos, mostBytes: options.mostBytes, tiles: options.tiles, note });
  let overSince = null;
  const end = () => {
    clearInterval(timer);
    server.http.close();
    server.http.closeAllConnections();
    process.stdin.destroy();
  };
  const step = () => {
    phone.step();
    if (phone.over === null) return;
    overSince ??= performance.now();
    // A phone that was there hears it, if it can; nobody else is waited for.
    if (phone.isOverTold || !phone.isHeard || performance.now() - overSince > FAREWELL_MS) end();
  };
  const timer = setInterval(step, STEP_MS);
  process.stdout.on("error", () => {});  // the mission is gone: stdin says so too
  const lines = createInterface({ input: process.stdin });
  lines.on("line", (line) => {
    const isFirst = phone.hello === null;
    phone.hearLine(line);
    if (isFirst && phone.hello) open(server, options, phone.hello.agent).catch((error) => phone.fail(`its page: ${error.message}`));
    if (phone.over !== null) step();
  });
  lines.on("close", () => {
    if (phone.over !== null) return step();
    // The agent's process is gone, and may be started again, with a driver that the page finds at the same link.
    note("nobody speaks to us any more");
    end();
  });
}

try {
  const options = readOptions(process.argv.slice(2));
  if (options) run(options);
} catch (error) {
  note(error.message);
  process.exitCode = error instanceof UsageError ? 2 : 3;
}
