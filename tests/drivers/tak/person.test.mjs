// A TAK user's part in virtual time: what the user is told and shown, and what the mission hears.
import assert from "node:assert/strict";
import { test } from "node:test";
import { event, readEvent, toXml } from "../../../drivers/tak/cot.mjs";
import { Person } from "../../../drivers/tak/person.mjs";
import { Box, helloOf, map } from "../phone/box.mjs";

const GOAL = { x_m: 4300, y_m: 4000 };

/** A person with a TAK device, and a mission that tells the driver what to do. */
class Field {
  sent = [];
  #number = 0;

  constructor(hello) {
    this.box = new Box(hello);
    this.person = new Person({ callsign: "Jenny", phone: this.box.phone, send: (object) => this.sent.push(readEvent(toXml(object), this.now)),
      clock: (ms) => `${Math.round((ms - this.now) / 1000)} s from now`, session: "s" });
  }
  get now() {
    return Math.round(this.box.wall_s * 1000);
  }
  #hear(options) {
    this.person.hear(readEvent(toXml(event({ how: "m-g", now: this.now, holds: 60_000, at: { latitude: 0, longitude: 0 }, ...options })), this.now), this.now);
    this.person.step(this.now);
  }
  stands(place, { callsign = "Jenny", uid = "ANDROID-1" } = {}) {
    const { latitude_deg: latitude, longitude_deg: longitude } = map.toDegrees(place);
    this.#hear({ uid, type: "a-f-G-U-C", at: { latitude, longitude }, detail: { contact: { $: { callsign } } } });
  }
  writes(text, { from = "Jenny", room = "MUSTER worker:4", uid = `GeoChat.ANDROID-1.${++this.#number}` } = {}) {
    this.#hear({ uid, type: "b-t-f", detail: { __chat: { $: { chatroom: room, senderCallsign: from, id: room } }, link: { $: { uid: "ANDROID-1", relation: "p-p" } }, remarks: text } });
  }
  get words() {
    return this.sent.filter(({ chat }) => chat).map(({ remarks }) => remarks);
  }
  /** Newest of that type. */
  shown(type) {
    return this.sent.findLast((one) => one.type === type);
  }
}

test("a task's name is said with its number", () => {
  const field = new Field();
  field.stands({ x_m: 4000, y_m: 4000 });
  field.box.goTo(GOAL, { task_name: "School" });
  field.person.step(field.now);
  assert.match(field.words.at(-1), /^go to task 12, School, meet uav:3 there by/);
  assert.equal(field.shown("b-m-p-w-GOTO").callsign, "Task 12, School");
});

test("a worker walks, says here, senses and says done", () => {
  const field = new Field();
  const { box } = field;
  field.stands({ x_m: 4000, y_m: 4000 });
  assert.match(field.words.at(-1), /^wait; you will be told where to go \(write: here/);
  const id = box.goTo(GOAL);
  field.person.step(field.now);
  assert.equal(field.words.at(-1), "go to task 12, meet uav:3 there by 60 s from now; there, write: here");
  assert.equal(field.shown("b-m-p-w-GOTO").callsign, "Task 12");
  assert.equal(field.shown("b-m-r").links.length, 2);
  box.pass(1, () => field.stands({ x_m: 4000 + 5 * (box.wall_s - 1000), y_m: 4000 }));
  assert.ok(Math.abs(box.last("state").at.x_m - 4145) < 6, JSON.stringify(box.last("state")));
  box.pass(2);
  field.writes("Here");
  assert.deepEqual(box.last("arrived"), { type: "arrived", id });
  assert.equal(field.words.at(-1), "you are at task 12; wait for uav:3");
  assert.deepEqual(field.sent.filter(({ type }) => type === "t-x-d-d").map(({ links }) => links[0].uid), ["muster.worker.4.goto", "muster.worker.4.way"]);
  const work = box.work("sense");
  field.person.step(field.now);
  assert.equal(field.words.at(-1), "sensing of task 12 has begun (60 s); when it is finished, write: done");
  field.writes("done", { uid: "GeoChat.x" });
  field.writes("done", { uid: "GeoChat.x" });
  assert.deepEqual(box.said.filter(({ type }) => type === "done"), [{ type: "done", id: work }]);
  box.tell({ type: "bye", reason: "the end" });
  field.person.step(field.now);
  assert.equal(field.words.at(-1), "the mission is over: the end");
  assert.deepEqual(box.wrong, []);
});

test("a vehicle changes a battery", () => {
  const field = new Field(helloOf({ agent: "vehicle:1", class: "vehicle", speed_m_s: 12.5 }));
  const { box } = field;
  field.stands({ x_m: 4000, y_m: 4000 });
  box.goTo(GOAL, { then: "charge", task: null, charging_point: 2 });
  box.pass(1);
  field.writes("I am here", { room: "MUSTER vehicle:1" });
  const work = box.work("charge");
  field.person.step(field.now);
  assert.equal(field.words.at(-1), "change the battery (60 s); then write: battery changed");
  field.writes("battery changed", { room: "MUSTER vehicle:1" });
  assert.deepEqual(box.last("done"), { type: "done", id: work });
});

test("only the person is heard, and only what is meant for us", () => {
  const field = new Field();
  const { box } = field;
  const id = box.goTo(GOAL);
  field.stands(GOAL, { callsign: "Somebody", uid: "ANDROID-2" });
  field.writes("here", { from: "Somebody" });
  field.writes("here", { room: "All Chat Rooms" });
  assert.equal(field.words.length, 0, "nobody is there to be told");
  box.pass(1);
  assert.equal(box.last("arrived"), undefined);
  assert.deepEqual(box.last("state").at, { x_m: 4000, y_m: 4000 });
  field.stands({ x_m: 4000, y_m: 4000 });
  assert.match(field.words.at(-1), /^go to task 12/);
  assert.equal(box.phone.order.goto.id, id);
});

test("who cannot says why, and is out; what cannot be taken is said", () => {
  const field = new Field();
  const { box } = field;
  field.stands({ x_m: 4000, y_m: 4000 });
  field.writes("here");
  assert.equal(field.words.at(-1), "you are not sent anywhere");
  field.writes("done");
  assert.equal(field.words.at(-1), "nothing of yours has begun");
  box.goTo({ x_m: 9000, y_m: 4000 });
  field.person.step(field.now);
  field.writes("here");
  assert.match(field.words.at(-1), /^your phone is 5.0 km from there; if you are there, press again/);
  field.writes("what?");
  assert.match(field.words.at(-1), /^go to task 12.*\(write: here, done, battery changed, cannot WHY\)$/);
  field.writes("cannot");
  assert.match(field.words.at(-1), /say why/);
  assert.equal(box.last("failed"), undefined);
  field.writes("Cannot the bridge is gone");
  assert.equal(box.last("failed").reason, "says: the bridge is gone");
  assert.equal(field.words.at(-1), "you are out of the mission: says: the bridge is gone");
});

test("who was away is told again; who joins is shown the goal again", () => {
  const field = new Field();
  const { box } = field;
  field.stands({ x_m: 4000, y_m: 4000 });
  box.goTo(GOAL);
  field.person.step(field.now);
  const before = field.words.length;
  field.stands({ x_m: 4001, y_m: 4000 });
  assert.equal(field.words.length, before);
  box.wall_s += 90;
  field.stands({ x_m: 4002, y_m: 4000 });
  assert.equal(field.words.length, before + 1);
  const shown = field.sent.length;
  field.person.repeat();
  field.person.step(field.now);
  assert.deepEqual(field.sent.slice(shown).map(({ type }) => type), ["a-f-G-I", "b-m-p-w-GOTO", "b-m-r"]);
});
