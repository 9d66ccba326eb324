// A server of a live page that takes orders, in place of muster's: the page as muster live serves it, events and answers as
// a test makes them.
import { spawn } from "node:child_process";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { after } from "node:test";
import { inflateSync } from "node:zlib";
import { MUSTER_PROGRAM, file } from "./support.mjs";

export const TOKEN = "a1b2c3";
const servers = [];
after(() => { // pages have gone by then
  for (const server of servers) {
    server.closeAllConnections();
    server.close();
  }
});

const WORDS = ["open", "reserved", "sensing", "done", "unreported", "expired", "cancelled", "held"];

/** The live page, as muster live serves it of any run. */
export async function livePage(run) {
  const live = spawn(MUSTER_PROGRAM, ["live", file(run), "--port", "0"], { stdio: ["ignore", "pipe", "inherit"] });
  try {
    const url = await new Promise((resolve, reject) => {
      live.stdout.once("data", (data) => resolve(String(data).trim()));
      live.once("exit", (code) => reject(new Error(`muster live ended with ${code}`)));
    });
    return await (await fetch(url)).text();
  } finally {
    live.kill("SIGINT");
  }
}

/** The run that a page of a report holds, as a mission that has come to `minutes`; `room` vacant tasks and UAVs at the ends. */
export function liveRun(page, minutes, room = 2) {
  const run = JSON.parse(inflateSync(Buffer.from(readFileSync(file(page), "utf8").match(/x-muster-run">([^<]*)</)[1], "base64")));
  delete run.report;
  const now = minutes * 60000;
  // Nobody knows what comes after it.
  const until = (rows, width, column = 0) => rows.filter((_, i) => rows[i - (i % width) + column] <= now);
  for (const [key, width] of [["stops", 4], ["spans", 2], ["tasks", 2]]) run[key] = run[key].map(([index, from, rows]) => [index, from, until(rows, width)]).filter(([, , rows]) => rows.length);
  run.done[1] = until(run.done[1], 2);
  run.activities[1] = until(run.activities[1], 6, 4);
  for (const key of ["decisions", "events"]) run[key][1] = run[key][1].filter((row) => row[1] <= now);
  run.processes = [];
  const { scenario } = run;
  const n = scenario.tasks.length / 3;
  scenario.task_times = Array.from({ length: n }, () => [0, null, null, 1, ""]);
  for (let i = 0; i < room; ++i) {
    scenario.tasks.push(0, 0, 1000);
    scenario.task_times.push([null, null, null, 1, ""]);
    run.tasks.push([n + i, 0, [0, 4]]);
  }
  run.words.tasks = WORDS;
  return Object.assign(run, { now_ms: now, ended: false });
}

/** Serves `html` and the run; `answer(order)` gives [status, body] of an order, or a promise of it. */
export async function serve(html, run, answer) {
  const given = [];
  const listening = new Set();
  const server = createServer(async (request, response) => {
    const reply = (status, type, body) => response.writeHead(status, { "Content-Type": type, Connection: "close" }).end(body);
    if (request.url === "/") return reply(200, "text/html; charset=utf-8", html);
    if (request.url === "/events") {
      response.writeHead(200, { "Content-Type": "text/event-stream" });
      response.write(`event: chunk\ndata: ${JSON.stringify(run)}\n\n`);
      listening.add(response);
      return undefined;
    }
    if (request.url.startsWith("/why/task:")) return reply(200, "text/plain", "task:1\n\ndecision   6  1:00:00  lost: uav:1 and worker:2 could sense it\n");
    if (request.url === "/what-if") return reply(200, "text/plain", "the decision weighs 1.000, 0.420 less than without\n");
    if (!request.url.startsWith("/orders")) return reply(404, "text/plain", "");
    if (request.headers.authorization !== `Bearer ${TOKEN}`) return reply(403, "application/json", "{}");
    let text = "";
    for await (const part of request) text += part;
    const order = request.method === "POST" ? JSON.parse(text) : { asked: decodeURIComponent(request.url.slice("/orders/".length)) };
    given.push(order);
    const [status, body] = await answer(order, given);
    return reply(status, "application/json", JSON.stringify(body));
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  servers.push(server);
  const tell = (chunk) => {
    for (const response of listening) response.write(`event: chunk\ndata: ${JSON.stringify({ epoch_ms: 0, ended: false, now_ms: run.now_ms, ...chunk })}\n\n`);
  };
  return { url: `http://127.0.0.1:${server.address().port}/`, given, tell };
}
