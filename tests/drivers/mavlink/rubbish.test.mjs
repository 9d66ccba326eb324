// Bytes that nobody should believe: no crash, and no command because of one.
import assert from "node:assert/strict";
import { test } from "node:test";
import { ardupilotmega, common, FrameReader, FrameWriter, make, minimal } from "../../../drivers/mavlink/frames.mjs";
import { Box } from "./box.mjs";

const SEED = 20261123, COUNT = 10_000;

function randomFrom(seed) {
  let state = seed;
  const next = () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
  return { next, below: (most) => Math.floor(next() * most), bytes: (length) => Buffer.from(Array.from({ length }, () => Math.floor(next() * 256))) };
}

const TYPES = [...Object.values(minimal.REGISTRY), ...Object.values(common.REGISTRY), ...Object.values(ardupilotmega.REGISTRY)];

/** A frame of that sender, whole, with any bytes in it. */
function anyFrame(random, system, component, type = TYPES[random.below(TYPES.length)]) {
  const payload = random.bytes(Math.min(255, type.PAYLOAD_LENGTH));
  class Any extends type {}
  Object.assign(Any, { FIELDS: [{ name: "payload", offset: 0, size: 1, type: "uint8_t[]", length: payload.length }] });
  return new FrameWriter(system, component).write(make(Any, { payload: [...payload] }));
}

/** A frame of the copter, broken in one of the ways of a bad link. */
function broken(random, frame) {
  const bytes = Buffer.from(frame);
  const ways = [
    () => bytes.subarray(0, 1 + random.below(bytes.length - 1)),
    () => Buffer.concat([bytes.subarray(1 + random.below(bytes.length - 1)), random.bytes(random.below(40))]),
    () => {
      const changed = Buffer.from(bytes);
      for (let n = 1 + random.below(4); n > 0; --n) changed[random.below(changed.length)] ^= 1 << random.below(8);
      return changed.equals(bytes) ? changed.subarray(1) : changed;
    },
    () => random.bytes(1 + random.below(300)),
    () => Buffer.concat([Buffer.from([0xfd, random.below(256)]), random.bytes(random.below(300))]),
  ];
  return ways[random.below(ways.length)]();
}

for (const kind of ["ardupilot", "px4"]) {
  test(`${kind}: ${COUNT} changed or random datagrams, and frames of others, in flight: nothing is commanded`, () => {
    const random = randomFrom(SEED);
    const box = new Box({ kind }).flying();
    const frames = [];
    const heartbeat = make(minimal.Heartbeat, { type: 2, autopilot: 3, baseMode: 1, customMode: 5, systemStatus: 4 });
    const pieces = [
      make(common.CommandAck, { command: 192, result: 2 }), make(common.GlobalPositionInt, { lat: 1, lon: 1, relativeAlt: -5000 }),
      make(common.SysStatus, { batteryRemaining: 1 }), heartbeat, make(common.FenceStatus, { breachStatus: 1 }), make(common.GpsRawInt, { timeUsec: 0n }),
    ];
    const own = new FrameWriter(3, 1);
    for (const piece of pieces) frames.push(own.write(piece));
    const before = box.protocol.commands().length, reader = new FrameReader();
    let heard = 0;
    for (let n = 0; n < COUNT; ++n) {
      let bytes = broken(random, frames[n % frames.length]);
      // Of other systems, and of what else is on board: whole, and true or not none of ours.
      if (n % 4 === 0) bytes = anyFrame(random, [1, 2, 4, 255][random.below(4)], 1);
      if (n % 4 === 1) bytes = anyFrame(random, 3, 2 + random.below(250));
      for (const frame of reader.readDatagram(bytes)) heard += box.driver.hearFrame(frame) ? 1 : 0;
      if (n % 10 === 0) box.step();
    }
    assert.equal(heard, 0, `seed ${SEED}`);
    assert.equal(box.failure, null);
    assert.deepEqual(box.protocol.commands().slice(before), []);
    box.until(() => box.said("arrived", 1).length, 300);
  });

  test(`${kind}: whole messages of the autopilot with any bytes in them: no crash, and nothing but coming home or landing`, () => {
    const random = randomFrom(SEED + 1);
    const reader = new FrameReader();
    let heard = 0;
    for (let round = 0; round < 20; ++round) {
      const box = new Box({ kind }).flying();
      const before = box.protocol.commands().length;
      for (let n = 0; n < COUNT / 20; ++n) {
        for (const frame of reader.readDatagram(anyFrame(random, 3, 1))) heard += box.driver.hearFrame(frame) ? 1 : 0;
        if (n % 10 === 0) box.step();
      }
      box.run(10);
      // Streams that it stopped are asked for again.
      const given = new Set(box.protocol.commands().slice(before).map(([, , { command }]) => command).filter((command) => command !== 511));
      for (const command of given) assert.ok([20, 21].includes(command), `command ${command}, seed ${SEED + 1}, round ${round}`);
    }
    assert.ok(heard > 0.99 * COUNT);
  });

  test(`${kind}: any bytes while it gets ready: it says so, or goes on`, () => {
    const random = randomFrom(SEED + 2);
    const reader = new FrameReader();
    const box = new Box({ kind });
    for (let n = 0; n < COUNT / 10; ++n) {
      for (const frame of reader.readDatagram(broken(random, anyFrame(random, 3, 1)))) box.driver.hearFrame(frame);
      box.step();
    }
    box.ready();
    assert.equal(box.copter.armed, false);
  });
}

test("lines that no mission says are passed over", () => {
  const random = randomFrom(SEED + 3);
  const box = new Box().flying();
  const lines = ["", "{", "null", "7", "[]", '"goto"', "{}", '{"type":"hello"}', '{"type":"toString"}', '{"type":"__proto__"}', '{"type":"time"}', '{"type":"time","mission_s":"x"}'];
  for (let n = 0; n < 1000; ++n) lines.push(random.bytes(random.below(100)).toString("latin1"));
  const before = box.protocol.commands().length;
  for (const line of lines) box.driver.hearLine(line);
  box.run(5);
  assert.equal(box.protocol.commands().length, before);
  assert.equal(box.failure, null);
});
