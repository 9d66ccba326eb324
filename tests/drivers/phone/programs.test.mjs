// The driver as a program: in muster drive --check, killed, and with command lines that cannot be.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { createServer } from "node:net";
import { once } from "node:events";
import { join } from "node:path";
import { test } from "node:test";
import { readOptions, UsageError } from "../../../drivers/phone/options.mjs";
import { helloOf } from "./box.mjs";
import { reportIn } from "../mavlink/programs.mjs";
import { bePhone, linkOf, MAIN, sync, withPrograms } from "./programs.mjs";

const MUSTER = process.env.MUSTER_PROGRAM;
const NO_MUSTER = MUSTER ? false : "MUSTER_PROGRAM names no muster";
const commandOf = (...words) => [process.execPath, MAIN, ...words].map((word) => `'${word}'`).join(" ");

const STEPS = { worker: ["goto 1", "sense 2", "goto 3", "sense 4", "goto 5", "goto 6", "goto 7"], vehicle: ["goto 1", "charge 2", "goto 3", "charge 4", "goto 5", "goto 6", "goto 7"] };

for (const kind of ["worker", "vehicle"]) {
  for (const rate of ["max", "60"]) {
    test(`--auto passes muster drive --check as a ${kind} at ${rate}`, { skip: NO_MUSTER }, () => withPrograms(async ({ start }) => {
      const check = start(MUSTER, ["drive", "--check", commandOf("--auto"), "--class", kind, "--rate", rate, "--json"]);
      assert.equal(await check.ended, 0, check.lines.join("\n"));
      const report = reportIn(check.lines);
      assert.deepEqual([report.wrong, report.steps.map(({ what }) => what)], [[], STEPS[kind]]);
    }));
  }
}

test("a phone that presses the buttons of its page passes muster drive --check", { skip: NO_MUSTER }, () => withPrograms(async ({ start, folder }) => {
  const check = start(MUSTER, ["drive", "--check", commandOf("--run", folder), "--class", "worker", "--rate", "60"]);
  // "I am here" at once: the driver tells it when the worker can be there.
  const pressed = await bePhone(await linkOf(check));
  assert.equal(await check.ended, 0, check.lines.join("\n"));
  assert.deepEqual(pressed, ["here", "done", "here", "done", "here", "here", "here"]);
}));

test("full speed without --auto, and a phone for a UAV: refused with the reason", { skip: NO_MUSTER }, () => withPrograms(async ({ start }) => {
  for (const [words, reason] of [[["--class", "worker"], /needs a rate/], [["--class", "uav", "--rate", "600"], /not for a uav/]]) {
    const check = start(MUSTER, ["drive", "--check", commandOf(), ...words]);
    assert.equal(await check.ended, 4);
    assert.match(check.lines.join("\n"), reason);
  }
}));

test("killed and started again in the same run directory it has the same link", () => withPrograms(async ({ start, folder }) => {
  const begin = async () => {
    const driver = start(process.execPath, [MAIN, "--run", folder]);
    driver.say(helloOf());
    return [driver, await linkOf(driver)];
  };
  const [first, link] = await begin();
  const before = await sync(link);
  first.child.kill("SIGKILL");
  await first.ended;
  await assert.rejects(sync(link));
  const [second, again] = await begin();
  assert.equal(again, link);
  const after = await sync(link);
  assert.notEqual(after.session, before.session);
  assert.equal(JSON.parse(readFileSync(join(folder, "phones", "worker-4.json"), "utf8")).url, link);
  await second.line((line) => line.includes("▀"));  // the code to scan
  // Its process ends without a word: that is not the mission's end, and a third takes over while it goes.
  second.child.stdin.end();
  const [third, same] = await begin();
  assert.equal(same, link);
  assert.equal(await second.ended, 0);
  assert.equal((await sync(link)).over, null);
  third.child.kill("SIGKILL");
  await third.ended;
  // Somebody else has its port by now: the token stays.
  const other = createServer().listen(Number(new URL(link).port), "127.0.0.1");
  await once(other, "listening");
  const [, moved] = await begin();
  assert.equal(new URL(moved).pathname, new URL(link).pathname);
  assert.notEqual(new URL(moved).port, new URL(link).port);
  other.close();
}));

test("the phone hears that the mission is over before the driver ends", () => withPrograms(async ({ start }) => {
  const driver = start(process.execPath, [MAIN]);
  driver.say(helloOf());
  const link = await linkOf(driver);
  assert.equal((await sync(link)).photos, false);
  driver.say({ type: "bye", reason: "all is done" });
  await driver.line((line) => line.includes("the mission is over: all is done"));
  assert.equal((await sync(link)).over, "all is done");
  assert.equal(await driver.ended, 0);
}));

test("a network that others are in is said loudly, and a port that is taken is a reason", () => withPrograms(async ({ start }) => {
  const driver = start(process.execPath, [MAIN, "--listen", "0.0.0.0"]);
  driver.say(helloOf());
  await driver.line((line) => line.includes("WARNING: everybody in the network"));
  const other = createServer().listen(0, "127.0.0.1");
  await once(other, "listening");
  const second = start(process.execPath, [MAIN, "--port", String(other.address().port)]);
  second.say(helloOf());
  assert.match((await second.said("failed")).reason, /its page: listen EADDRINUSE/);
  other.close();
}));

test("a command line that cannot be is refused", () => {
  const run = (...words) => spawnSync(process.execPath, [MAIN, ...words], { encoding: "utf8", input: "" });
  const { status, stderr } = run("--port", "x");
  assert.equal(status, 2, stderr);
  assert.match(stderr, /--port: found 'x'/);
  // The others are refused in the same way.
  for (const [words, reason] of [[["--port", "1.5"], /--port/], [["--port", "70000"], /--port/], [["--listen", "here"], /--listen: found 'here'/],
    [["--url", "ftp://x"], /--url/], [["--url", "https://x/y"], /--url/], [["--lost-after", "1"], /--lost-after/], [["--accuracy", ""], /--accuracy/],
    [["--photo-mb", "0"], /--photo-mb/], [["--none"], /none/], [["word"], /word/]]) {
    assert.throws(() => readOptions(words), { constructor: UsageError, message: reason });
  }
  assert.equal(run("--help").status, 0);
});
