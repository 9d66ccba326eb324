// What is kept of the pictures that a UAV takes.
import assert from "node:assert/strict";
import { mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { ardupilotmega, common, FrameReader, FrameWriter, make } from "../../../drivers/mavlink/frames.mjs";
import { PhotoFolder } from "../../../drivers/photos.mjs";
import { Box, START } from "./box.mjs";

const PLACE = { x_m: 1500, y_m: 900 };

/** A UAV that senses at task 7. */
function sensing(settings) {
  const box = new Box(settings).ready();
  box.tell({ type: "goto", id: 1, mission_s: 0, to: PLACE, expected_s: 100, then: "sense", task: 7, charging_point: null, partner: "worker:1" });
  box.until(() => box.said("arrived", 1).length, 300);
  box.tell({ type: "sense", id: 2, mission_s: box.now, for_s: 60 });
  return box;
}

/** The driver hears that message of that component of its UAV's, or of another system's. */
function hear(box, message, component = 1, system = 3) {
  for (const frame of new FrameReader().readDatagram(new FrameWriter(system, component).write(message))) box.driver.hearFrame(frame);
}

const SAID_BY = {
  ardupilot: { message: "CAMERA_FEEDBACK", component: 1, camera: 0, image: 1 },
  px4: { message: "CAMERA_IMAGE_CAPTURED", component: 1, camera: 1, image: 0 },
};

for (const kind of ["ardupilot", "px4"]) {
  test(`${kind}: a picture is kept with its place, altitude, time and task`, () => {
    const box = sensing({ kind });
    box.until(() => box.said("done", 2).length, 100);
    assert.equal(box.pictures.length, 1);
    const [{ at, ...of }] = box.pictures;
    assert.ok(Math.hypot(at.x_m - PLACE.x_m, at.y_m - PLACE.y_m) < 3, JSON.stringify(at));
    const again = box.map.toMetres(at);
    assert.ok(Math.hypot(again.x_m - at.x_m, again.y_m - at.y_m) < 0.01);
    assert.ok(Math.abs(of.height_m - 55) < 2 && Math.abs(of.altitude_m - of.height_m - 12) < 0.01);
    assert.ok(Math.abs(of.mission_s - box.copter.photos[0].at_s) < 1);
    assert.match(of.taken_utc, /^2026-11-23T/);
    assert.deepEqual([of.agent, of.task, of.file_url, of.said_by], ["uav:3", 7, null, SAID_BY[kind]]);
  });

  test(`${kind}: a camera with a link of its own tells where the picture is`, () => {
    const box = sensing({ kind, options: { camera: "image" } });
    box.until(() => box.said("done", 2).length, 100);
    assert.deepEqual(box.pictures.map(({ task, file_url, said_by }) => [task, file_url, said_by.component]), [[7, "http://192.168.144.25/DCIM/IMG_0001.JPG", 100]]);
    assert.equal(box.failure, null);
  });
}

test("what is said twice is one picture; what failed, or is of others, is none", () => {
  const box = sensing({ options: { camera: "none" } });
  const captured = (fields) => make(common.CameraImageCaptured, { timeUtc: 0n, q: [1, 0, 0, 0], captureResult: 1, fileUrl: "", ...fields });
  for (let n = 0; n < 3; ++n) hear(box, captured({ imageIndex: 4 }), 100);
  hear(box, captured({ imageIndex: 5 }), 100);
  hear(box, captured({ imageIndex: 5 }), 101);
  assert.deepEqual(box.pictures.map(({ said_by }) => [said_by.component, said_by.image]), [[100, 4], [100, 5], [101, 5]]);
  hear(box, captured({ imageIndex: 6, captureResult: 0 }), 100);
  hear(box, captured({ imageIndex: 7 }), 191);
  hear(box, captured({ imageIndex: 7 }), 100, 4);
  assert.equal(box.pictures.length, 3);
  assert.match(box.notes.at(-1), /picture 6 was not taken/);
});

test("without a place of its own it is the UAV's, and without a time none is made up", () => {
  const box = sensing({ options: { camera: "none" } });
  hear(box, make(ardupilotmega.CameraFeedback, { timeUsec: 12_000_000n, imgIdx: 9, altMsl: NaN }));
  const [{ at, taken_utc }] = box.pictures;
  assert.ok(Math.hypot(at.x_m - PLACE.x_m, at.y_m - PLACE.y_m) < 3);
  assert.equal(taken_utc, null);
});

test("on the way to no task it is of no task, and none is kept after the mission's end", () => {
  const box = new Box().ready();
  hear(box, make(ardupilotmega.CameraFeedback, { timeUsec: 0n, imgIdx: 1 }));
  assert.deepEqual(box.pictures.map(({ task }) => task), [null]);
  box.tell({ type: "bye", reason: "it is over" });
  hear(box, make(ardupilotmega.CameraFeedback, { timeUsec: 0n, imgIdx: 2 }));
  assert.equal(box.pictures.length, 1);
});

test("a camera that never stops fills a thousand files, not the disk", () => {
  const box = new Box().ready();
  for (let imgIdx = 0; imgIdx < 3000; ++imgIdx) hear(box, make(ardupilotmega.CameraFeedback, { timeUsec: 0n, imgIdx }));
  assert.equal(box.pictures.length, 1000);
  assert.equal(box.failure, null);
});

test("a picture's file has the name that photos have, and takes the place of none", () => {
  const run = mkdtempSync(join(tmpdir(), "muster-pictures-"));
  try {
    const folder = new PhotoFolder(run), of = { agent: "uav:3", task: 7, mission_s: 50.4, at: { ...START, latitude_deg: 52, longitude_deg: 0 }, file_url: null };
    assert.equal(folder.keep(of), "uav-3_task-7_500m-400m_50s_1");
    assert.equal(new PhotoFolder(run).keep(of), "uav-3_task-7_500m-400m_50s_2");
    assert.equal(folder.keep({ ...of, task: null, at: null }), "uav-3_no-task_nowhere_50s_1");
    mkdirSync(join(run, "photos"), { recursive: true });
    writeFileSync(join(run, "photos", "uav-3_task-7_500m-400m_50s_3.json"), "somebody else's");
    assert.equal(folder.keep(of), "uav-3_task-7_500m-400m_50s_4");
    const words = JSON.parse(readFileSync(join(run, "photos", "uav-3_task-7_500m-400m_50s_1.json"), "utf8"));
    assert.deepEqual(words, { version: 1, photo: null, ...of });
    assert.equal(readdirSync(join(run, "photos")).length, 5, "no parts are left");
  } finally {
    rmSync(run, { recursive: true });
  }
});
