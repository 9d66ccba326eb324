// A person's part in virtual time: what the mission is told.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Box, helloOf, map, TICK_S } from "./box.mjs";

const GOAL = { x_m: 4300, y_m: 4000 };

function near(found, expected, within_m = 0.5) {
  assert.ok(Math.hypot(found.x_m - expected.x_m, found.y_m - expected.y_m) <= within_m, `${JSON.stringify(found)}, expected ${JSON.stringify(expected)}`);
}

test("a worker goes there, says so, senses and says done", () => {
  const box = new Box();
  const id = box.goTo(GOAL);
  assert.deepEqual(box.sync().order.stage, "going");
  box.pass(1, () => box.sync(box.place({ x_m: 4000 + 5 * (box.wall_s - 1000), y_m: 4000 })));
  near(box.last("state").at, { x_m: 4145, y_m: 4000 }, 6);
  assert.equal(box.last("state").mission_s, 30, "a place of now is told as of now");
  box.pass(2);
  assert.equal(box.press("here", { order: id }), "");
  assert.deepEqual(box.last("arrived"), { type: "arrived", id });
  box.pass(1);
  near(box.last("state").at, GOAL);
  const work = box.work("sense");
  assert.equal(box.sync().order.stage, "working");
  assert.match(box.press("done", { order: id }), /something else/);
  assert.equal(box.press("done", { order: work }), "");
  assert.deepEqual(box.last("done"), { type: "done", id: work });
  box.tell({ type: "bye", reason: "it is over" });
  assert.equal(box.sync().over, "it is over");
  assert.ok(box.phone.isOverTold);
  assert.deepEqual(box.wrong, []);
});

test("a vehicle says that the battery is changed", () => {
  const box = new Box(helloOf({ agent: "vehicle:1", class: "vehicle", speed_m_s: 12.5 }));
  const id = box.goTo(GOAL, { then: "charge", task: null, charging_point: 2 });
  box.pass(1);
  box.press("here", { order: id });
  const work = box.work("charge");
  assert.equal(box.sync().order.work, "charge");
  box.press("done", { order: work });
  assert.deepEqual(box.said.filter(({ type }) => type !== "state").map(({ type }) => type), ["hello", "ready", "arrived", "done"]);
  assert.deepEqual(box.wrong, []);
});

test("what is sent twice is taken once, with the same answer", () => {
  const box = new Box();
  const id = box.goTo({ x_m: 4010, y_m: 4000 });
  box.pass(1);
  const item = box.item("here", { order: id });
  assert.deepEqual(box.sync(item).results, { [item.id]: "" });
  box.cancel();
  assert.deepEqual(box.sync(item).results, { [item.id]: "" }, "it was taken, though it would not be now");
  const stale = box.item("here", { order: 99 });
  assert.match(box.sync(stale).results[stale.id], /something else/);
  assert.match(box.sync(stale).results[stale.id], /something else/);
  assert.equal(box.said.filter(({ type }) => type === "arrived").length, 1);
});

test("what was pressed for an order of before, or for a driver of before, is not taken", () => {
  const box = new Box();
  const first = box.goTo(GOAL);
  box.pass(3);
  box.cancel("somebody else does it");
  assert.equal(box.sync().stopped, "somebody else does it");
  assert.match(box.press("here", { order: first }), /something else since/);
  const second = box.goTo(GOAL);
  assert.match(box.press("here", { order: second, session: "of-before" }), /started again/);
  assert.equal(box.last("arrived"), undefined);
  assert.match(box.press("dance"), /not known/);
});

test("'I am here' far from there is asked back once", () => {
  const box = new Box();
  const id = box.goTo({ x_m: 6200, y_m: 4000 });
  box.pass(1, () => box.sync(box.place({ x_m: 4010, y_m: 4000 })));
  assert.equal(box.press("here", { order: id }), "your phone is 2.2 km from there; if you are there, press again");
  assert.equal(box.sync().order.stage, "going");
  assert.equal(box.press("here", { order: id }), "", "the person knows better");
  assert.equal(box.sync().order.stage, "held");
  // What the phone told minutes ago says nothing.
  const old = new Box();
  const other = old.goTo({ x_m: 6200, y_m: 4000 });
  old.pass(1, () => old.sync(old.place({ x_m: 4010, y_m: 4000 })));
  old.pass(4);
  assert.equal(old.press("here", { order: other }), "");
});

test("a person in a car is told as far as the speed allows, and does not fail", () => {
  const box = new Box();
  box.goTo({ x_m: 9000, y_m: 4000 });
  box.pass(1, () => box.sync(box.place({ x_m: 6000, y_m: 4000 })));
  near(box.last("state").at, { x_m: 4150, y_m: 4000 });
  assert.ok(box.sync().told.is_limited);
  near(box.sync().place, { x_m: 6000, y_m: 4000 });
  box.pass(1);
  near(box.last("state").at, { x_m: 4300, y_m: 4000 });
  box.pass(20);
  near(box.last("state").at, { x_m: 6000, y_m: 4000 });
  assert.ok(!box.sync().told.is_limited);
  assert.deepEqual(box.wrong, []);
});

test("'I am here' sooner than the speed allows is held until it does", () => {
  const box = new Box();
  const id = box.goTo(GOAL);  // 60 s
  box.pass(1);
  box.press("here", { order: id });
  assert.equal(box.last("arrived"), undefined);
  assert.equal(box.sync().order.stage, "held");
  assert.equal(box.sync().order.held_until_s, 60);
  box.sync(box.place({ x_m: 4290, y_m: 4005 }));
  box.pass(1);
  assert.equal(box.last("arrived").id, id);
  assert.equal(box.mission_s, 60);
  assert.deepEqual(box.wrong, []);
});

test("what was said of an order that is cancelled moves nobody any more", () => {
  const box = new Box();
  const id = box.goTo(GOAL);
  box.pass(1);
  box.press("here", { order: id });
  box.cancel();
  const { at } = box.last("state");
  box.pass(3);
  near(box.last("state").at, at, 0);
});

test("who has worked there was there until then: the next way takes its time", () => {
  const box = new Box();
  box.goTo({ x_m: 4010, y_m: 4000 });
  box.pass(1);
  box.press("here", { order: 1 });
  box.work("sense");
  box.pass(4);
  box.press("done", { order: 2 });
  const next = box.goTo({ x_m: 4310, y_m: 4000 });  // 60 s
  box.press("here", { order: next });
  box.pass(1);
  assert.notEqual(box.last("arrived").id, next);
  box.pass(1);
  assert.equal(box.last("arrived").id, next);
  assert.deepEqual(box.wrong, []);
});

test("places that are inexact, outside, impossible or old are not told", () => {
  const box = new Box();
  box.goTo(GOAL);
  box.pass(1, () => box.sync(box.place({ x_m: 4050, y_m: 4050 }, 250)));
  assert.equal(box.sync().place.trouble, "inexact");
  box.pass(1, () => box.sync(box.place({ x_m: -50, y_m: 4050 })));
  assert.equal(box.sync().place.trouble, "outside");
  for (const wrong of [{ latitude_deg: 91 }, { longitude_deg: "1" }, { accuracy_m: -1 }, { accuracy_m: null }]) {
    const item = { ...box.place(GOAL), ...wrong };
    assert.match(box.sync(item).results[item.id], /is not a number/);
  }
  near(box.last("state").at, box.hello.at, 0);
  assert.equal(box.last("state").mission_s, 0, "of the time when it was there: the mission expects it as planned");
  box.sync(box.place({ x_m: 4100, y_m: 4000 }));
  box.sync(box.place({ x_m: 4000, y_m: 4000 }, 8, box.wall_s - 20));
  box.pass(1);
  near(box.last("state").at, { x_m: 4100, y_m: 4000 });
});

test("minutes without connection: it is answered for, then what waited counts, in order", () => {
  const box = new Box();
  const id = box.goTo(GOAL);
  box.pass(1, () => box.sync());
  const waiting = [];
  box.pass(10, () => waiting.push(box.place({ x_m: Math.min(4300, 4000 + 5 * (box.wall_s - 1030)), y_m: 4000 })));
  assert.equal(box.said.filter(({ type }) => type === "state").length, 11, "one answer a tick");
  waiting.push(box.item("here", { order: id }, box.wall_s - 200));
  for (let i = 0; i < waiting.length; i += 100) box.sync(...waiting.slice(i, i + 100));
  assert.equal(box.last("arrived").id, id);
  assert.match(box.notes.join("\n"), /here, pressed 3 min ago/);
  assert.deepEqual(box.wrong, []);
});

test("no word from the phone for ten minutes: it has failed, and not before", () => {
  const box = new Box();
  box.goTo({ x_m: 9000, y_m: 9000 });
  box.sync();
  box.pass(20);
  assert.equal(box.last("failed"), undefined);
  box.pass(1);
  assert.deepEqual(box.last("failed"), { type: "failed", id: 1, reason: "no word from the phone for 10 min" });
  const states = box.said.length;
  box.pass(3);
  assert.equal(box.said.length, states, "nothing counts behind it");
  assert.equal(box.sync().failed, "no word from the phone for 10 min");
});

test("until the phone is there the mission plans without its person", () => {
  const box = new Box();
  assert.equal(box.said[0].not_ready, "a word of its phone");
  box.pass(40);  // 20 min
  assert.equal(box.last("failed"), undefined);
  assert.equal(box.last("ready"), undefined);
  box.sync();
  box.sync();
  assert.equal(box.said.filter(({ type }) => type === "ready").length, 1);
  assert.equal(new Box(undefined, { isAuto: true }).said[0].not_ready, undefined);
});

test("nobody is missed before the agent takes part", () => {
  const box = new Box(helloOf({ online_from_s: 1800 }));
  box.sync();
  box.pass(79);
  assert.equal(box.last("failed"), undefined);
  box.pass(2);
  assert.match(box.last("failed").reason, /no word/);
});

test("cannot: out of the mission, with the words of the person", () => {
  const box = new Box();
  box.goTo(GOAL);
  box.press("cannot", { reason: ` the bridge\n\u202eis\0 down ${"x".repeat(400)}` });
  const { id, reason } = box.last("failed");
  assert.equal(id, 1);
  assert.match(reason, /^says: the bridge is down x+$/);
  assert.ok(Buffer.byteLength(reason) <= 500);
  assert.match(box.press("here", { order: 1 }), /out of the mission/);
});

test("who cannot be driven has failed with the reason", () => {
  assert.match(new Box(helloOf({ rate: null })).last("failed").reason, /needs a rate/);
  assert.match(new Box(helloOf({ agent: "uav:1", class: "uav" })).last("failed").reason, /not for a uav/);
});

test("without an origin the buttons work", () => {
  const box = new Box(helloOf({ origin: null }));
  const id = box.goTo({ x_m: 4010, y_m: 4000 });
  box.pass(1);
  const item = box.place(GOAL);
  assert.match(box.sync(item).results[item.id], /no origin/);
  assert.equal(box.press("here", { order: id }), "");
  assert.equal(box.last("arrived").id, id);
});

test("lines that are none, and requests that are none", () => {
  const box = new Box();
  for (const line of ["", "{", "[]", "null", "1", '{"type":"dance"}', '{"type":"toString"}']) box.phone.hearLine(line);
  for (const asked of [null, {}, { items: [] }, { sent_ms: 1, items: {} }, { sent_ms: 1, items: [null] }, { sent_ms: 1, items: [{ id: "x", at_ms: 1 }] },
    { sent_ms: 1, items: [{ id: "long-enough" }] }, { sent_ms: "1", items: [] }, { sent_ms: 1, items: Array(300).fill({}) }]) {
    assert.throws(() => box.phone.sync(asked), TypeError, JSON.stringify(asked));
  }
  assert.deepEqual(box.said.map(({ type }) => type), ["hello"]);
});

test("at any rate, whatever the phone tells and presses, the mission finds nothing impossible", () => {
  let seed = 4;
  const random = (n) => (seed = (seed * 48271) % 2147483647) % n;
  for (let round = 0; round < 60; ++round) {
    const box = new Box(helloOf({ rate: [1, 7, 60][random(3)] }));
    let isWorking = false, order = 0;
    for (let i = 0; i < 60; ++i) {
      const what = random(8);
      if (what === 0 && !isWorking) order = box.goTo({ x_m: random(10000), y_m: random(10000) });
      else if (what === 1 && order && !isWorking) (box.cancel(), order = 0);
      else if (what === 2 && order) box.press("here", { order });
      else box.pass(1 + random(3), () => box.sync(box.place({ x_m: random(10000), y_m: random(10000) }, 5 + random(120), box.wall_s - random(40))));
      isWorking = box.phone.order?.stage === "working";
      if (box.phone.order?.stage === "there" && !isWorking) {
        box.pass(1);
        box.press("done", { order: box.work("sense") });
        box.phone.order = null;
        order = 0;
      }
    }
    assert.deepEqual(box.wrong, [], `round ${round}`);
    assert.ok(box.said.filter(({ type }) => type === "state").length === box.ticks, "one answer a tick");
  }
});

test("degrees are metres of the mission's map", () => {
  near(map.toMetres(map.toDegrees({ x_m: 1234, y_m: 5678 })), { x_m: 1234, y_m: 5678 }, 1e-6);
  assert.equal(TICK_S, 30);
});

test("a message reaches the mission, a call for help stands until something else is said", () => {
  const box = new Box();
  box.pass(1, () => box.sync());
  assert.equal(box.press("message", { text: " the  way\nis blocked " }), "");
  assert.deepEqual(box.last("message"), { type: "message", text: "the way is blocked" });
  assert.equal(box.sync().called, null);
  assert.equal(box.press("message", { text: "trapped", help: true }), "");
  assert.deepEqual(box.last("message"), { type: "message", text: "trapped", help: true });
  assert.equal(box.sync().called, "trapped");
  box.press("message", { text: "all right again" });
  assert.equal(box.sync().called, null);
  assert.match(box.press("message", { text: " \n " }), /nothing in that message/);
  assert.match(box.press("message", {}), /nothing in that message/);
});

test("who has left the mission may still call for help", () => {
  const box = new Box();
  box.pass(1, () => box.sync());
  box.press("cannot", { reason: "hurt" });
  assert.match(box.press("pause"), /out of the mission/);
  assert.equal(box.press("message", { text: "I bleed", help: true }), "");
  assert.deepEqual(box.last("message"), { type: "message", text: "I bleed", help: true });
  assert.equal(box.sync().called, "I bleed");
  box.tell({ type: "bye", reason: "it is over" });
  assert.match(box.press("message", { text: "too late" }), /out of the mission/);
});

test("words of any language are as long as the mission takes, and no letter is cut", () => {
  const box = new Box();
  box.pass(1, () => box.sync());
  for (const [letter, most] of [["x", 480], ["é", 240], ["困", 160], ["😀", 120]]) {
    box.press("message", { text: letter.repeat(600) });
    assert.equal(box.last("message").text, letter.repeat(most));
  }
});

test("a break: nothing new is planned with the person until it is over, and what it was told goes on", () => {
  const box = new Box();
  box.pass(1, () => box.sync());
  const id = box.goTo(GOAL);
  assert.equal(box.press("pause"), "");
  assert.equal(box.press("pause"), "");
  assert.deepEqual(box.said.filter(({ type }) => type === "not_ready"), [{ type: "not_ready", reason: "the end of a break" }]);
  assert.ok(box.sync().isPaused);
  box.pass(2);
  assert.equal(box.press("here", { order: id }), "");
  assert.equal(box.last("arrived").id, id);
  const before = box.said.length;
  assert.equal(box.press("resume"), "");
  assert.deepEqual(box.said.slice(before), [{ type: "ready" }]);
  assert.equal(box.sync().isPaused, false);
});

test("a person who is late says by how much: the mission expects it then", () => {
  const box = new Box();
  box.pass(1, () => box.sync());
  const id = box.goTo(GOAL);  // 60 s away, planned for second 90
  assert.equal(box.press("late", { order: id, minutes: 10 }), "");
  box.pass(1);
  assert.equal(box.last("state").expected_s, 690);
  assert.equal(box.sync().order.expected_s, 690);
  assert.match(box.press("late", { order: 99, minutes: 10 }), /something else/);
  assert.match(box.press("late", { order: id, minutes: -3 }), /minutes/);
  box.pass(4);
  box.press("late", { order: id, minutes: 5 });  // the planned time is over: from now on
  box.pass(1);
  assert.equal(box.last("state").expected_s, 180 + 300);
  box.goTo({ x_m: 4000, y_m: 4100 });
  box.pass(1);
  assert.equal(box.last("state").expected_s, undefined, "that was of another way");
  assert.deepEqual(box.wrong, []);
});
