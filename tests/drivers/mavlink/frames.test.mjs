// Messages against what others have published: the same library on both sides of a test would hide a common error.
import assert from "node:assert/strict";
import { test } from "node:test";
import { ardupilotmega, common, FrameReader, FrameWriter, make, minimal } from "../../../drivers/mavlink/frames.mjs";
import { bitsOf, integerOf } from "../../../drivers/mavlink/talk.mjs";
import { MissionMap } from "../../../drivers/places.mjs";

// Source: rust-mavlink, mavlink/tests/test_shared/mod.rs (HEARTBEAT_V1, HEARTBEAT_V2) and v2_encode_decode_tests.rs
// (COMMAND_LONG_TRUNCATED_V2, STATUSTEXT_V2).
const HEARTBEAT_1 = "fe 09 ef 01 02 00 05 00 00 00 02 03 59 03 03 1f 50";
const HEARTBEAT_2 = "fd 09 00 00 ef 01 02 00 00 00 05 00 00 00 02 03 59 03 03 2e 73";
const COMMAND_LONG = `fd 1e 00 00 00 00 32 4c 00 00 00 00 e6 42 00 40 9c 45${" 00".repeat(20)} ff 01 bc c3`;
const STATUSTEXT = "fd 06 00 00 05 2a 04 fd 00 00 02 79 6f 75 70 69 49 00";

/** Number and CRC_EXTRA of each message that is spoken. It is made of the names, types and order of all fields: where it agrees,
 * so does how a message lies in its bytes. Source: mavlink/c_library_v2, common/common.h and
 * ardupilotmega/ardupilotmega.h, MAVLINK_MESSAGE_CRCS. */
const CRC_EXTRA = [
  [0, 50], [1, 124], [20, 214], [22, 220], [23, 168], [24, 24], [33, 104], [40, 230], [43, 132], [44, 221], [45, 232], [47, 153], [51, 196], [73, 38],
  [75, 158], [76, 152], [77, 143], [147, 154], [162, 189], [180, 52], [230, 163], [242, 104], [253, 83], [263, 133],
];

const bytes = (hex) => Buffer.from(hex.replaceAll(" ", ""), "hex");
const read = (hex) => new FrameReader().readDatagram(bytes(hex));

test("published frames are read", () => {
  for (const hex of [HEARTBEAT_1, HEARTBEAT_2]) {
    const [{ system, component, name, message }] = read(hex);
    assert.deepEqual([system, component, name], [1, 2, "HEARTBEAT"]);
    assert.deepEqual({ ...message }, { customMode: 5, type: 2, autopilot: 3, baseMode: 0x59, systemStatus: 3, mavlinkVersion: 3 });
  }
  const [{ message: command }] = read(COMMAND_LONG);
  assert.deepEqual([command.command, command._param1, command._param2, command._param7], [common.MavCmd.SET_MESSAGE_INTERVAL, 115, 5000, 0]);
  const [{ system, message: text }] = read(STATUSTEXT);
  assert.deepEqual([system, text.severity, text.text], [42, 2, "youpi"]);
});

test("published frames are written, byte for byte", () => {
  const writer = new FrameWriter(1, 2);
  const heartbeat = make(minimal.Heartbeat, { customMode: 5, type: 2, autopilot: 3, baseMode: 0x59, systemStatus: 3, mavlinkVersion: 3 });
  let written = null;
  for (let number = 0; number <= 0xef; ++number) written = writer.write(heartbeat);
  assert.deepEqual(written, bytes(HEARTBEAT_2));
  const text = new FrameWriter(42, 4);
  for (let number = 0; number <= 5; ++number) written = text.write(make(common.StatusText, { severity: 2, text: "youpi" }));
  assert.deepEqual(written, bytes(STATUSTEXT));
  assert.deepEqual(new FrameWriter(0, 50).write(read(COMMAND_LONG)[0].message), bytes(COMMAND_LONG));
});

test("every message lies in its bytes as published", () => {
  const types = Object.fromEntries([minimal, common, ardupilotmega].flatMap(({ REGISTRY }) => Object.values(REGISTRY)).map((type) => [type.MSG_ID, type]));
  for (const [id, crc] of CRC_EXTRA) assert.equal(types[id].MAGIC_NUMBER, crc, types[id].MSG_NAME);
});

test("messages of every class have the fields that their class gives them", () => {
  for (const type of [minimal, common, ardupilotmega].flatMap(({ REGISTRY }) => Object.values(REGISTRY))) {
    const message = make(type, {});
    assert.deepEqual(message, new type(), type.MSG_NAME);
    assert.deepEqual(Object.keys(message).sort(), type.FIELDS.map(({ name }) => name).sort(), "reading one sets them all");
  }
});

test("what is split, joined, or between rubbish is found; what is broken is not", () => {
  const frame = bytes(HEARTBEAT_2);
  const stream = new FrameReader();
  assert.equal(stream.read(frame.subarray(0, 7)).length, 0);
  assert.equal(stream.read(Buffer.concat([frame.subarray(7), Buffer.from("rubbish"), frame, frame.subarray(0, 3)])).length, 2);
  assert.equal(stream.read(frame.subarray(3)).length, 1);
  for (let i = 0; i < frame.length; ++i) {
    const broken = Buffer.from(frame);
    broken[i] ^= 0x10;
    assert.equal(new FrameReader().readDatagram(broken).length, 0, `byte ${i}`);
  }
});

test("rubbish without a beginning is not kept", () => {
  const reader = new FrameReader();
  for (let i = 0; i < 1000; ++i) reader.read(Buffer.alloc(1000, 7));
  assert.equal(reader.read(bytes(HEARTBEAT_2)).length, 1);
});

test("integers as bits", () => {
  for (const value of [0, 1, 2, 300, -7, 16777217]) assert.equal(integerOf(Math.fround(bitsOf(value))), value);
});

// Source: GeographicLib's LocalCartesian, as muster drive --check sends its places.
test("places are those of GeographicLib", () => {
  const map = new MissionMap({ latitude_deg: 52.2, longitude_deg: 0.1 });
  const places = [[4000, 4000, 52.23593358662517, 0.1585510995907747], [4000, 6500, 52.25840101746647, 0.15858066329668644],
    [6500, 4000, 52.235909764013485, 0.19514548249736532], [6500, 6500, 52.25837717568672, 0.1951935234371217]];
  for (const [x_m, y_m, latitude_deg, longitude_deg] of places) {
    const there = map.toMetres({ latitude_deg, longitude_deg });
    assert.ok(Math.hypot(there.x_m - x_m, there.y_m - y_m) < 0.01);
    const back = map.toMetres(map.toDegrees({ x_m, y_m }));
    assert.ok(Math.hypot(back.x_m - x_m, back.y_m - y_m) < 1e-6);
  }
});
