// What the page keeps and says, without a browser.
import assert from "node:assert/strict";
import { webcrypto } from "node:crypto";
import { test } from "node:test";
import { frame, roundLength_m } from "../../../drivers/phone/page/map.mjs";
import { Noise } from "../../../drivers/phone/page/noise.mjs";
import { Queue } from "../../../drivers/phone/page/queue.mjs";
import { ahead, lengthOf } from "../../../drivers/phone/page/way.mjs";
import { action, clock, direction, duration, length, lines, title, whereabouts } from "../../../drivers/phone/page/words.mjs";
import { Box, helloOf, map } from "./box.mjs";

globalThis.crypto ??= webcrypto;  // Node 18 has it under another name

class Storage {
  kept = new Map();
  getItem(key) { return this.kept.get(key) ?? null; }
  setItem(key, value) { this.kept.set(key, value); }
  removeItem(key) { this.kept.delete(key); }
}

test("what was pressed is kept in order until it is taken, and outlives the page", () => {
  const storage = new Storage();
  const queue = new Queue(storage, "k");
  queue.add({ type: "here", order: 1, at_ms: 1 });
  queue.add({ type: "place", at_ms: 2 });
  queue.add({ type: "done", order: 2, at_ms: 3 });
  const again = new Queue(storage, "k");
  const sent = again.next();
  assert.deepEqual(sent.map(({ type, order }) => [type, order]), [["here", 1], ["place", undefined], ["done", 2]]);
  assert.equal(new Set(sent.map(({ id }) => id)).size, 3);
  assert.ok(sent.every((item) => !("isSent" in item)));
  assert.deepEqual(again.next(), sent, "until it is answered it is sent again as it was");
  assert.deepEqual([again.isWaiting("here", 1), again.isWaiting("here", 2), again.pressed.length], [true, false, 2]);
  const settled = again.settle({ [sent[0].id]: "", [sent[2].id]: "too late" });
  assert.deepEqual(settled.map(([{ type }, why]) => [type, why]), [["here", ""], ["done", "too late"]]);
  again.settle({ [sent[1].id]: "" });
  assert.equal(storage.kept.size, 0, "nothing is left of it");
});

test("an hour of places is some dozen, the newest among them; nothing pressed goes", () => {
  const queue = new Queue(new Storage(), "k");
  queue.add({ type: "here", order: 1, at_ms: 0 });
  for (let s = 0; s < 3600; ++s) queue.add({ type: "place", at_ms: 1000 * s });
  assert.ok(queue.items.length <= 62, String(queue.items.length));
  assert.deepEqual([queue.items[0].type, queue.items.at(-1).at_ms], ["here", 3_599_000]);
  const times = queue.items.slice(1).map(({ at_ms }) => at_ms);
  assert.deepEqual(times, [...times].sort((a, b) => a - b));
  assert.equal(queue.next().length, queue.items.length);
});

test("without storage, with a full one or with rubbish in it the page goes on", () => {
  const full = { getItem: () => "{rubbish", setItem: () => { throw new Error("full"); }, removeItem: () => {} };
  for (const storage of [null, full]) {
    const queue = new Queue(storage, "k");
    queue.add({ type: "here", order: 1, at_ms: 1 });
    assert.equal(queue.next().length, 1);
  }
});

test("numbers in words", () => {
  assert.deepEqual([clock(0), clock(3725.4), clock(-3)], ["0:00:00", "1:02:05", "0:00:00"]);
  assert.deepEqual([duration(42), duration(-90), duration(5400)], ["42 s", "2 min", "1 h 30 min"]);
  assert.deepEqual([length(123), length(1234)], ["120 m", "1.2 km"]);
  const from = { x_m: 0, y_m: 0 };
  assert.deepEqual([[0, 1], [1, 1], [1, 0], [0, -1], [-1, 0], [-1, 1]].map(([x_m, y_m]) => direction(from, { x_m, y_m })),
    ["north", "north-east", "east", "south", "west", "north-west"]);
});

test("a person is told what to do, at each stage", () => {
  const box = new Box();
  const words = () => {
    const view = box.sync();
    return [title(view), action(view)?.text, ...lines(view, box.mission_s, 0)].join(" | ");
  };
  assert.equal(words(), "Nothing to do yet |  | Stay where you are.");
  const id = box.goTo({ x_m: 4300, y_m: 4300 });
  assert.match(words(), /^Go to task 12 \| I am here \| 420 m to the north-east \| By 0:01:25 \(\d\d:\d\d\), in 1 min \| With uav:3$/);
  box.press("here", { order: id });
  assert.match(words(), /You said that you are there\. The mission takes it at 0:01:25: sooner is more than its 5 m\/s/);
  box.pass(3);
  assert.equal(words(), "Wait here for uav:3 |  | It comes for task 12.");
  const work = box.work("sense");
  assert.match(words(), /^At task 12: the UAV is at work \| Done \| With uav:3\. Planned until 0:02:30/);
  box.press("done", { order: work });
  assert.equal(words(), "Done; wait here |  | You will be told where to go next.");
  box.cancel("the UAV has failed");
  assert.match(words(), /^Stop where you are \| {2}\| the UAV has failed/);
  box.press("cannot", { reason: "tired" });
  assert.equal(words(), "You are out of the mission |  | says: tired");
});

test("a task's name is said with its number", () => {
  const box = new Box();
  box.goTo({ x_m: 4300, y_m: 4300 }, { task_name: "School" });
  assert.equal(title(box.sync()), "Go to task 12, School");
});

test("what people should know of a task is said until it is done", () => {
  const box = new Box();
  const has = () => lines(box.sync(), 0, 0).includes("Third floor, ring twice");
  box.goTo(box.hello.at, { task_note: "Third floor, ring twice" });
  assert.ok(has(), "on the way");
  box.pass(1);
  box.press("here", { order: 1 });
  assert.ok(has(), "while waiting");
  box.work("sense");
  assert.ok(has(), "at work");
});

test("a vehicle is asked for the battery, and one who begins later is told when", () => {
  const box = new Box(helloOf({ agent: "vehicle:0", class: "vehicle", online_from_s: 600, rate: 60 }));
  assert.deepEqual(lines(box.sync(), 0, 0), ["You take part from 0:10:00, in 10 min."]);
  box.goTo(box.hello.at, { then: "charge", task: null, charging_point: 2 });
  box.pass(1);
  box.press("here", { order: 1 });
  box.work("charge");
  assert.equal(action(box.sync()).text, "Battery changed");
  assert.equal(title(box.sync()), "At charging point 2: change the battery");
});

test("the phone's place is told with what is wrong with it", () => {
  const box = new Box();
  const words = (gps = "") => whereabouts(box.sync(), gps, box.mission_s);
  assert.match(words("no https"), /not known: no https\. The buttons work/);
  box.sync(box.place({ x_m: 4000, y_m: 4100 }, 12));
  assert.equal(words(), "Your place is good to 12 m.");
  box.pass(4);
  assert.equal(words(), "Your place is good to 12 m, 2 min old.");
  box.sync(box.place({ x_m: 4000, y_m: 4100 }, 300));
  assert.match(words(), /300 m\. Worse than 100 m is not told/);
  box.sync(box.place({ x_m: -4000, y_m: 4100 }));
  assert.match(words(), /outside/);
  box.pass(1, () => box.sync(box.place({ x_m: 9000, y_m: 4100 })));
  assert.match(words(), /ahead of the 5 m\/s/);
  assert.match(whereabouts(new Box(helloOf({ origin: null })).sync(), "", 0), /nowhere on the earth/);
});

test("the map shows what matters, and a round scale", () => {
  const area = { width_m: 10000, height_m: 10000 };
  const close = frame([{ x_m: 10, y_m: 10 }], area);
  assert.ok(close.scale <= (260 - 68) / 200 + 1e-9);
  const both = frame([{ x_m: 0, y_m: 0 }, { x_m: 3000, y_m: 1000 }], area);
  assert.deepEqual([both.x_m, both.y_m], [1500, 500]);
  assert.ok(3000 * both.scale <= 292 + 1e-9);
  assert.deepEqual([roundLength_m(1), roundLength_m(0.1), roundLength_m(0.05)], [100, 1000, 2000]);
});

const at = (x_m, y_m) => ({ x_m, y_m });

test("the way that is left begins at the part of the way that is nearest", () => {
  const way = [at(0, 0), at(400, 0), at(400, 300), at(1000, 300)];
  assert.deepEqual(ahead(way, at(0, 0)), way);
  assert.equal(lengthOf(ahead(way, at(0, 0))), 1300);
  assert.deepEqual(ahead(way, at(100, 20)), [at(100, 20), ...way.slice(1)], "beside the road");
  assert.deepEqual(ahead(way, at(400, 0)), [at(400, 0), ...way.slice(2)], "a corner is behind who stands on it");
  assert.deepEqual(ahead(way, at(900, 310)), [at(900, 310), at(1000, 300)]);
});

test("a person is told the way by road, and its length from where the person is", () => {
  const box = new Box();
  box.goTo(at(4400, 4300), { via: [at(4400, 4000)] });
  assert.deepEqual(box.sync().order.way, [at(4000, 4000), at(4400, 4000), at(4400, 4300)]);
  assert.equal(lines(box.sync(), 0, 0)[0], "700 m by road to the north-east");
  box.pass(1, () => box.sync(box.place(at(4100, 4000))));
  assert.equal(lines(box.sync(), 30, 0)[0], "600 m by road to the north-east");
  box.goTo(at(4400, 4300), { via: [] });
  assert.equal(box.sync().order.way.length, 2, "a straight way by road");
  box.goTo(at(4400, 4300));
  assert.equal(box.sync().order.way, null, "a mission without roads");
  assert.match(lines(box.sync(), 30, 0)[0], /^\d+ m to the north-east$/);
});

test("corners in degrees are places of the map", () => {
  const box = new Box();
  const degrees = ({ latitude_deg, longitude_deg }) => ({ latitude_deg, longitude_deg });
  box.goTo(at(4400, 4300), { via: [degrees(map.toDegrees(at(4400, 4000)))] });
  const [, corner] = box.sync().order.way;
  assert.ok(Math.hypot(corner.x_m - 4400, corner.y_m - 4000) < 0.01, JSON.stringify(corner));
});

test("a person is told when the partner is expected", () => {
  const box = new Box();
  const id = box.goTo({ x_m: 4300, y_m: 4000 });  // there by second 60
  box.tell({ type: "meeting", id, mission_s: 0, expected_s: 100 });
  const said = () => lines(box.sync(), box.mission_s, 0).filter((line) => line.startsWith("uav:3 is expected"));
  assert.deepEqual(said(), [], "at the same time, or nearly so");
  box.tell({ type: "meeting", id, mission_s: 0, expected_s: 400 });
  assert.match(said()[0], /^uav:3 is expected at 0:06:40 .*in 7 min$/);
  box.pass(2);
  box.press("here", { order: id });
  assert.equal(box.sync().order.stage, "there");
  assert.match(said()[0], /in 6 min$/);
  box.tell({ type: "meeting", id: 99, mission_s: 60, expected_s: 900 });
  assert.match(said()[0], /in 6 min$/, "that is of another order");
  box.pass(12);
  assert.deepEqual(said(), [], "it is late: by how much nobody knows");
});

test("the phone vibrates when there is something new, and only after the page has been touched: browsers refuse it before", () => {
  const userActivation = { hasBeenActive: false };
  let times = 0;
  const before = Object.getOwnPropertyDescriptor(globalThis, "navigator");
  Object.defineProperty(globalThis, "navigator", { value: { userActivation, vibrate: () => times++ }, configurable: true });
  try {
    const noise = new Noise({ addEventListener() {}, setAttribute() {}, getAttribute: () => "false" }, null);
    const heard = (now) => {
      noise.hear(now);
      return times;
    };
    assert.deepEqual([heard("wait"), heard("go to task 1")], [0, 0]);
    userActivation.hasBeenActive = true;
    assert.deepEqual([heard("go to task 1"), heard("go to task 2"), heard("go to task 2")], [0, 1, 1]);
  } finally {
    if (before) Object.defineProperty(globalThis, "navigator", before);
    else delete globalThis.navigator;
  }
});
