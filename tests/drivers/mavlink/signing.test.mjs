// MAVLink 2's signatures: who is believed.
import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { test } from "node:test";
import { FrameReader, FrameWriter, make, minimal } from "../../../drivers/mavlink/frames.mjs";
import { Signing } from "../../../drivers/mavlink/signing.mjs";
import { Box } from "./box.mjs";

const KEY = Buffer.alloc(32, 7), OTHER = Buffer.alloc(32, 8);
const NOW_MS = Date.UTC(2026, 10, 27), MINUTE_MS = 60_000;
const heartbeat = () => make(minimal.Heartbeat, { type: 2, autopilot: 3, baseMode: 1, customMode: 5, systemStatus: 4, mavlinkVersion: 3 });
const writerAt = (unix_ms, key = KEY) => new FrameWriter(3, 1, new Signing(key, () => unix_ms));

test("a signed frame is as the standard has it", () => {
  const bytes = writerAt(NOW_MS).write(heartbeat());
  const plain = new FrameWriter(3, 1).write(heartbeat());
  assert.equal(bytes.length, plain.length + 13);
  assert.equal(bytes[2], 1, "its flag says that it is signed");
  assert.equal(bytes[plain.length], 0, "the link");
  assert.equal(bytes.readUIntLE(plain.length + 1, 6), (NOW_MS - Date.UTC(2015, 0, 1)) * 100, "10 us since 2015");
  const hash = createHash("sha256").update(Buffer.concat([KEY, bytes.subarray(0, -6)])).digest();
  assert.deepEqual(bytes.subarray(-6), hash.subarray(0, 6));
});

test("times grow, also when the clock stands or goes back, and from one program to the next", () => {
  let unix_ms = NOW_MS;
  const signing = new Signing(KEY, () => unix_ms), writer = new FrameWriter(3, 1, signing);
  const timeOf = (bytes) => bytes.readUIntLE(bytes.length - 12, 6);
  const times = [];
  for (const step_ms of [0, 0, 5, -50, 1]) times.push(timeOf(writer.write(heartbeat()))), unix_ms += step_ms;
  times.push(timeOf(writerAt(NOW_MS + 1000).write(heartbeat())));
  for (let i = 1; i < times.length; ++i) assert.ok(times[i] > times[i - 1], String(times));
});

test("what is not signed, or with another key, changed, said before, or old is dropped and counted", () => {
  const signing = new Signing(KEY, () => NOW_MS), reader = new FrameReader(signing);
  const hears = (bytes) => reader.readDatagram(bytes).length;
  const first = writerAt(NOW_MS).write(heartbeat());
  assert.equal(hears(first), 1);
  const changed = Buffer.from(writerAt(NOW_MS + 1).write(heartbeat()));
  changed[changed.length - 1] ^= 1;
  const cases = { unsigned: new FrameWriter(3, 1).write(heartbeat()), "another key": writerAt(NOW_MS + 1, OTHER).write(heartbeat()), changed, "said before": first,
    older: writerAt(NOW_MS - 1).write(heartbeat()) };
  let dropped = 0;
  for (const [name, bytes] of Object.entries(cases)) {
    assert.equal(hears(bytes), 0, name);
    assert.equal(signing.dropped, ++dropped, name);
  }
  assert.equal(hears(writerAt(NOW_MS + 2).write(heartbeat())), 1);
});

test("one that was not heard before may be a minute behind, and each sender has times of its own", () => {
  const signing = new Signing(KEY, () => NOW_MS), reader = new FrameReader(signing);
  const hears = (system, unix_ms) => reader.readDatagram(new FrameWriter(system, 1, new Signing(KEY, () => unix_ms)).write(heartbeat())).length;
  assert.equal(hears(3, NOW_MS - MINUTE_MS - 1), 0);
  assert.equal(hears(3, NOW_MS - MINUTE_MS + 1), 1);
  assert.equal(hears(4, NOW_MS - MINUTE_MS + 1), 1);
});

for (const kind of ["ardupilot", "px4"]) {
  test(`${kind}: driver and autopilot with the same key fly, and nobody else is believed`, () => {
    const box = new Box({ kind, key: KEY }).flying();
    const before = box.signing.dropped, low = writerAt(box.unix_ms + 1000, OTHER);
    assert.equal(before, 0);
    assert.equal(box.hear(low.write(heartbeat())), false);
    assert.equal(box.hear(new FrameWriter(3, 1).write(heartbeat())), false);
    for (const bytes of box.sent.down.slice(-100)) box.hear(bytes);
    const replayed = box.sent.up.filter((bytes) => new FrameReader().readDatagram(bytes).some(({ name }) => name === "COMMAND_INT"));
    const { length } = box.protocol.commands();
    for (const bytes of replayed) box.protocol.hear(bytes);
    assert.ok(replayed.length > 0);
    assert.equal(box.protocol.commands().length, length, "what was commanded before is not commanded again");
    assert.ok(box.signing.dropped >= 100);
    box.until(() => box.said("arrived", 1).length, 300);
    assert.equal(box.failure, null);
  });
}

test("another key than the autopilot's: it is not heard, and nothing is flown", () => {
  const box = new Box({ key: KEY, copterKey: OTHER });
  box.goTo(1500, 400);
  box.run(60);
  assert.ok(box.lines.some(([, line]) => line.type === "not_ready" && line.reason === "a heartbeat of system 3"));
  assert.ok(box.signing.dropped > 20);
  assert.deepEqual(box.protocol.commands(), [], "nor does the autopilot hear us");
});

test("a driver that starts again is believed by an autopilot that has heard the one before", () => {
  const box = new Box({ key: KEY }).flying();
  box.isDead = true;
  box.landed();
  box.startDriver(box.driver.options);
  box.driver.restore();
  box.until(() => box.driver.exitCode !== null, 60);
  assert.equal(box.driver.exitCode, 0);
  assert.equal(box.kept, null);
});
