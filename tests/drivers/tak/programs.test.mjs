// The bridge as a program, beside a mission over LCM, and TAK clients that see and say.
import assert from "node:assert/strict";
import { createSocket } from "node:dgram";
import { once } from "node:events";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { connect, createServer } from "node:net";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { setTimeout as sleep } from "node:timers/promises";
import { createServer as createTlsServer } from "node:tls";
import { fileURLToPath } from "node:url";
import { MissionMap, distance_m, towards } from "../../../drivers/places.mjs";
import { Splitter, event, readEvent, toXml } from "../../../drivers/tak/cot.mjs";
import { readDriverOptions, readOptions, UsageError } from "../../../drivers/tak/options.mjs";
import { Program } from "../mavlink/programs.mjs";

const MAIN = join(dirname(fileURLToPath(import.meta.url)), "../../../drivers/tak/main.mjs");
const DRIVE = join(dirname(MAIN), "drive.mjs");
const FIELD_TEST = join(dirname(MAIN), "../../scenarios/field_test.json");
const { MUSTER_PROGRAM } = process.env;
const ORIGIN = { latitude_deg: 46.85, longitude_deg: 7.3 };

/** A TAK client, or who a TAK server stands for: keeps the newest of each event. */
class Client {
  events = new Map();
  all = [];

  constructor(socket) {
    this.socket = socket;
    const splitter = new Splitter();
    socket.on("error", () => {});
    socket.on("data", (bytes) => {
      for (const xml of splitter.take(bytes)) {
        const read = readEvent(xml, Date.now() - 5000);
        this.events.set(read.uid, { ...read, xml });
        this.all.push(read);
      }
    });
  }

  async until(isIt, what) {
    for (let i = 0; i < 1200; ++i) {
      const found = isIt(this);
      if (found) return found;
      await sleep(50);
    }
    throw new Error(`never came: ${what}; ${[...this.events.keys()].join(" ")}`);
  }

  say(options) {
    this.socket.write(toXml(event({ now: Date.now(), holds: 60000, ...options })));
  }
}

/**
 * Runs `body({start, folder, mission(options), bridge(address, options), open})`. Programs that were started are ended
 * behind it, and the servers and sockets that `open` was told of are closed: a test that fails ends, too.
 */
async function withPrograms(body) {
  const folder = mkdtempSync(join(tmpdir(), "muster-tak-"));
  const programs = [];
  const opened = [];
  const open = (socket) => {
    opened.push(socket);
    return socket;
  };
  const start = (command, words) => {
    programs.push(new Program(command, words));
    return programs.at(-1);
  };
  const run = async (...words) => assert.equal(await start(MUSTER_PROGRAM, words).ended, 0, words.join(" "));
  const mission = async (rate) => {
    const scenario = join(folder, "scenario.json");
    await run("scenario", "--preset", "Random_1", "--origin", `${ORIGIN.latitude_deg},${ORIGIN.longitude_deg}`, "--out", scenario);
    const program = start(MUSTER_PROGRAM, ["run", scenario, "--live=0", "--control", "--rate", String(rate), "--out", join(folder, "run")]);
    const line = await program.line((some) => some.startsWith("live at "));
    return { program, address: line.slice("live at ".length), run: join(folder, "run") };
  };
  const bridge = (address, ...words) => start(process.execPath, [MAIN, address, "--every", "0.1", ...words]);
  try {
    return await body({ start, run, mission, bridge, folder, open });
  } finally {
    for (const socket of opened) (socket.destroy ?? socket.close).call(socket);
    for (const { child } of programs) child.kill("SIGKILL");
    await Promise.all(programs.map((program) => program.ended));
    rmSync(folder, { recursive: true, force: true });
  }
}

async function client(bridge) {
  const line = await bridge.line((some) => some.startsWith("listening on "));
  const socket = connect(Number(line.split(":").at(-1)), "127.0.0.1"); // it closes when the bridge is ended
  await once(socket, "connect");
  return new Client(socket);
}

const withinAMinute = () => ({ signal: AbortSignal.timeout(60_000) });
const colour = ({ xml }) => Number(/argb="(-?\d+)"/.exec(xml)[1]);
const GREEN = 0xff00cc44 | 0;
const markerAt = (place) => {
  const { latitude_deg: latitude, longitude_deg: longitude } = new MissionMap(ORIGIN).toDegrees(place);
  return { uid: "marker-1", type: "b-r-f-h-c", at: { latitude, longitude }, detail: { contact: { $: { callsign: "Bus stop" } }, creator: { $: { callsign: "chief" } } } };
};

test("a mission is seen as it is; a report becomes a task, and is done; a bridge that starts again doubles nothing", async () => {
  await withPrograms(async ({ mission, bridge, run }) => {
    const { program, address, run: folder } = await mission(600);
    let tak = bridge(address, "--listen", "0", "--allow", "chief");
    let phone = await client(tak);
    phone.say(markerAt({ x_m: 14000, y_m: 15000 }));
    const uid = await phone.until(({ events }) => [...events.keys()].find((key) => key === "muster.run.task.120"), "the task of the report");
    assert.equal(phone.events.get(uid).callsign, "Task 120 Bus stop");
    tak.child.kill("SIGKILL");
    await tak.ended;
    tak = bridge(address, "--listen", "0", "--allow", "chief");
    phone = await client(tak);
    phone.say(markerAt({ x_m: 14000, y_m: 15000 }));
    await phone.until(({ all }) => all.some(({ type }) => type === "b-t-f"), "news in the room");
    assert.equal(await Promise.race([tak.ended, program.ended.then(() => "the mission")]), 0, tak.lines.join("\n"));
    assert.match(tak.lines.join("\n"), /the mission is over/);
    // The end, as the report has it. Its tasks are all there, each in its colour.
    program.child.kill("SIGINT");
    assert.equal(await program.ended, 0);
    const report = JSON.parse(readFileSync(join(folder, "report.json"), "utf8"));
    assert.equal(report.tasks_total, 121, "the report was one task");
    assert.equal(report.tasks[120].status, "done");
    const tasks = report.tasks.filter(({ status }) => status !== "unreported"); // not the places that orders may fill
    assert.equal(tasks.length, 121);
    for (const { id, status } of tasks) assert.equal(colour(phone.events.get(`muster.run.task.${id}`)) === GREEN, status === "done", `task ${id} is ${status}`);
    const agents = [...phone.events.values()].filter(({ type }) => /^a-f-(A-M-H-Q|G-U-C|G-E-V-C)$/.test(type));
    assert.ok(agents.length >= 80, `${agents.length} agents were seen`);
    await run("audit", folder);
  });
});

test("a TAK server that goes away is found again; who may not order is not heard", async () => {
  await withPrograms(async ({ mission, bridge, open }) => {
    const { address } = await mission(60);
    const server = open(createServer());
    const listen = (port) => new Promise((resolve) => server.listen(port, "127.0.0.1", resolve));
    await listen(0);
    const { port } = server.address();
    const tak = bridge(address.split("#")[0], "--connect", `127.0.0.1:${port}`, "--allow", "chief");
    const accept = async () => new Client(open((await once(server, "connection", withinAMinute()))[0]));
    let other = await accept();
    await other.until(({ events }) => events.has("muster.run.task.0"), "task 0");
    other.socket.destroy();
    await new Promise((resolve) => server.close(resolve));
    await tak.line((line) => line.includes("trying again"));
    await listen(port);
    other = await accept();
    await other.until(({ events }) => events.has("muster.run.task.0"), "task 0 again");
    other.say({ ...markerAt({ x_m: 14000, y_m: 15000 }), detail: { contact: { $: { callsign: "x" } }, creator: { $: { callsign: "stranger" } } } });
    await tak.line((line) => line.includes("a report of stranger is not heard"));
    other.say(markerAt({ x_m: 14000, y_m: 15000 }));
    await tak.line((line) => line.includes("refused: this bridge has no token of the mission"));
    tak.child.kill("SIGTERM");
    assert.equal(await tak.ended, 0);
  });
});

test("over TLS with a certificate of its own, and to a multicast group of this machine", async (t) => {
  await withPrograms(async ({ mission, bridge, start, folder, open }) => {
    const [cert, key] = ["cert.pem", "key.pem"].map((name) => join(folder, name));
    const made = start("openssl", ["req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2",
      "-subj", "/CN=localhost", "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", key, "-out", cert]);
    made.child.on("error", () => {});
    if (await made.ended !== 0) return t.skip("no openssl to make a certificate");
    const { address } = await mission(60);
    const pem = readFileSync(cert);
    const server = open(createTlsServer({ cert: pem, key: readFileSync(key), ca: pem, requestCert: true, rejectUnauthorized: true }));
    await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
    const group = open(createSocket({ type: "udp4", reuseAddr: true }));
    await new Promise((resolve) => group.bind(0, resolve));
    group.addMembership("239.2.3.1");
    const heard = new Promise((resolve) => group.on("message", (bytes) => /task\.0"/.test(bytes) && resolve()));
    const tak = bridge(address, "--connect", `127.0.0.1:${server.address().port}`, "--tls", "--cert", cert, "--key", key, "--ca", cert,
      "--multicast", `239.2.3.1:${group.address().port}`, "--ttl", "0");
    const [socket] = await once(server, "secureConnection", withinAMinute());
    open(socket);
    assert.ok(socket.authorized);
    await new Client(socket).until(({ events }) => events.has("muster.run.task.0"), "task 0");
    await Promise.race([heard, once(group, "close", withinAMinute())]); // rejects after a minute
    tak.child.kill("SIGINT");
    assert.equal(await tak.ended, 0);
  });
});

/**
 * A person with a TAK device at the end of that connection: walks to what is shown, writes what is asked for. `of`: {map, at (metres), speed_m_s, rate}.
 * Ends with the connection.
 */
async function walk(tak, { map, at, speed_m_s, rate }) {
  const here = { ...at };
  let isOpen = true;
  tak.socket.once("close", () => { isOpen = false; });
  const degreesHere = () => {
    const { latitude_deg: latitude, longitude_deg: longitude } = map.toDegrees(here);
    return { latitude, longitude };
  };
  const self = await tak.until(({ all }) => all.find(({ type }) => type === "a-f-G-I"), "the driver's contact");
  let [heard, n] = [0, 0];
  const written = [];
  const write = (text) => {
    written.push(text);
    tak.say({ uid: `GeoChat.${self.uid}.${++n}`, type: "b-t-f", at: degreesHere(), detail: { __chat: { $: { chatroom: self.callsign, id: self.uid, senderCallsign: "Jenny" } },
      link: { $: { uid: `ANDROID-${self.uid}`, relation: "p-p" } }, remarks: text } });
  };
  const STEP_MS = 100;
  for (let goal = null, doneAt = null; isOpen; await sleep(STEP_MS)) {
    const chats = tak.all.filter(({ chat }) => chat);
    for (; heard < chats.length; ++heard) {
      const words = chats[heard].remarks;
      const [, amount, unit] = /\((\d+) (s|min)\)/.exec(words) ?? [];
      goal = words.startsWith("go to ") ? "unseen" : null;
      doneAt = amount ? Date.now() + (1000 * amount * (unit === "s" ? 1 : 60)) / rate : null;
    }
    if (goal === "unseen") {
      const { at: to } = await tak.until(({ all }) => all.findLast(({ type }) => type === "b-m-p-w-GOTO"), "the goal");
      goal = map.toMetres({ latitude_deg: to.latitude, longitude_deg: to.longitude });
    }
    if (goal) {
      const way = (speed_m_s * rate * STEP_MS) / 1000;
      Object.assign(here, towards(here, goal, way));
      if (distance_m(here, goal) < 2) {
        write("here");
        goal = null;
      }
    }
    if (doneAt !== null && Date.now() > doneAt) {
      write(/^change/.test(chats.at(-1).remarks) ? "battery changed" : "done");
      doneAt = null;
    }
    tak.say({ uid: `ANDROID-${self.uid}`, type: "a-f-G-U-C", at: degreesHere(), detail: { contact: { $: { callsign: "Jenny" } } } });
  }
  return { written, agent: self.uid };
}

test("TAK users take the parts of a worker and a vehicle: three places of three", async () => {
  await withPrograms(async ({ start, run, folder, open }) => {
    const scenario = JSON.parse(readFileSync(FIELD_TEST, "utf8"));
    const RATE = 30;
    const server = open(createServer());
    await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
    const specs = { "muster.worker.0": scenario.workers[0], "muster.vehicle.0": scenario.vehicles[0] };
    const parts = [];
    server.on("connection", (socket) => parts.push((async () => {
      const tak = new Client(open(socket));
      const { uid } = await tak.until(({ all }) => all.find(({ type }) => type === "a-f-G-I"), "the driver's contact");
      const { x_km, y_km, speed_km_per_min: speed } = specs[uid];
      return walk(tak, { map: new MissionMap(scenario.origin), at: { x_m: 1000 * x_km, y_m: 1000 * y_km }, speed_m_s: (1000 * speed) / 60, rate: RATE });
    })()));
    const driver = `'${process.execPath}' '${DRIVE}' --callsign Jenny --connect 127.0.0.1:${server.address().port}`;
    const out = join(folder, "run");
    const mission = start(MUSTER_PROGRAM, ["run", FIELD_TEST, "--policy", "rollout", "--rate", String(RATE), "--quiet", "--out", out, "--driver", `worker:0=${driver}`, "--driver", `vehicle:0=${driver}`]);
    assert.equal(await mission.ended, 0, mission.lines.join("\n"));
    const people = await Promise.all(parts);
    const report = JSON.parse(readFileSync(join(out, "report.json"), "utf8"));
    assert.equal(report.tasks_done, 3, `${JSON.stringify(people)} ${readFileSync(join(out, "worker.stderr"), "utf8")}`);
    assert.equal(report.events.agent_failed ?? 0, 0);
    const worker = people.find(({ agent }) => agent === "muster.worker.0");
    assert.deepEqual([worker.written.filter((text) => text === "here").length >= 3, worker.written.filter((text) => text === "done").length], [true, 3]);
    await run("audit", out);
  });
});

test("rubbish, floods and what never ends are dropped; others go on", async () => {
  await withPrograms(async ({ mission, bridge }) => {
    const { address } = await mission(60);
    const tak = bridge(address, "--listen", "0", "--allow", "chief");
    const good = await client(tak);
    const endless = await client(tak);
    endless.socket.write(`<event a="${"x".repeat(10 * 1024 * 1024)}`);
    await new Promise((resolve, reject) => {
      endless.socket.once("close", resolve);
      setTimeout(() => reject(new Error("it is not cut off")), 30_000).unref();
    });
    const flood = await client(tak);
    for (let i = 0; i < 5000; ++i) flood.say({ ...markerAt({ x_m: 1, y_m: 1 }), uid: `f${i}`, type: "a-f-G-U-C" });
    await good.until(({ events }) => events.has("muster.run.task.0"), "task 0");
    good.say(markerAt({ x_m: 14000, y_m: 15000 }));
    await good.until(({ events }) => events.has("muster.run.task.120"), "the task of the report");
    tak.child.kill("SIGINT");
    assert.equal(await tak.ended, 0);
    const [, dropped] = /(\d+) dropped/.exec(tak.lines.join("\n"));
    assert.ok(Number(dropped) > 1000, tak.lines.join("\n"));
  });
});

test("what is wrong with the command line is said, with exit code 2", async () => {
  await withPrograms(async ({ start }) => {
    const good = "http://127.0.0.1:1/";
    for (const [main, wrong] of [[MAIN, /MISSION: found 0 addresses/], [DRIVE, /--callsign: found none/]]) {
      const program = start(process.execPath, [main]);
      assert.equal(await program.ended, 2, main);
      assert.match(program.lines.join("\n"), wrong);
    }
    // The others are refused in the same way.
    const isRefused = (read, words, wrong) => assert.throws(() => read(words), { constructor: UsageError, message: wrong });
    for (const [words, wrong] of [[["ftp://x", "--listen", "0"], /MISSION: found 'ftp:\/\/x'/], [[good], /expected one of them/], [[good, "--connect", "host"], /--connect: found 'host'/],
      [[good, "--listen", "70000"], /--listen: found '70000'/], [[good, "--multicast", "10.0.0.1:5"], /a multicast group/], [[good, "--listen", "0", "--cert", "x"], /without --tls/],
      [[good, "--connect", "a:1", "--tls", "--ca", "/nowhere"], /--ca: ENOENT/], [[good, "--fly"], /fly/]]) {
      isRefused(readOptions, words, wrong);
    }
    for (const [words, wrong] of [[["--callsign", "J"], /expected one of them/], [["x", "--callsign", "J"], /found 'x'/],
      [["--callsign", "J", "--listen", "0", "--accuracy", "0"], /--accuracy: found '0'/]]) {
      isRefused(readDriverOptions, words, wrong);
    }
  });
});
