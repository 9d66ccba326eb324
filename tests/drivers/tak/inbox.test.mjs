// What TAK users say, and what the mission gets of it.
import assert from "node:assert/strict";
import { test } from "node:test";
import { event, toXml } from "../../../drivers/tak/cot.mjs";
import { Inbox } from "../../../drivers/tak/inbox.mjs";
import { Picture } from "../../../drivers/tak/picture.mjs";
import { SCENARIO, begun } from "../../tools/report/page/small_run.mjs";

const ORIGIN = [46.95, 7.45];
const AT = { latitude: 46.955, longitude: 7.455 };

/** An inbox with a mission that takes every order, or refuses it for `refused`. */
function box({ refused = null, allow = ["chief"] } = {}) {
  const run = begun({ scenario: { ...SCENARIO, origin: ORIGIN }, tasks: [[0, 0, [0, 0]]] });
  const picture = new Picture();
  picture.begin(run);
  const made = { run, picture, orders: [], said: [], notes: [] };
  const mission = { run, known: Promise.resolve(), order: async (order) => {
    made.orders.push(order);
    return refused ? { refused } : { task: order.task?.x_km === undefined ? undefined : 100 + made.orders.length };
  }, why: async () => "task:0\n\ndecision   3  0:30:00  lost: uav:0 could sense it\n    to:   another\n" };
  made.inbox = new Inbox({ allow: new Set(allow), mission, picture, say: (to, text) => made.said.push([to.callsign, text]), note: (words) => made.notes.push(words) });
  return made;
}

const marker = (options = {}) => {
  const { uid = "m1", type = "b-m-p-s-m", at = AT, creator = "chief", callsign = "School", now = Date.now(), detail = {} } = options;
  return toXml(event({ uid, type, at, now, holds: 60000, detail: { contact: { $: { callsign } }, creator: { $: { callsign: creator } }, link: { $: { uid: "ANDROID-1", relation: "p-p", parent_callsign: creator } }, ...detail } }));
};
let sent = 0;
const message = (text, { from = "chief", room = "MUSTER" } = {}) => toXml(event({ uid: `GeoChat.ANDROID-1.${++sent}`, type: "b-t-f", at: AT, now: Date.now(), holds: 60000, detail: {
  __chat: { $: { chatroom: room, senderCallsign: from, id: room } }, link: { $: { uid: "ANDROID-1", relation: "p-p" } }, remarks: text } }));

test("a marker becomes a task, once, where it stands; its type gives the priority", async () => {
  for (const [type, priority] of [["b-m-p-s-m", 1], ["b-r-f-h-c", 3], ["b-a-o-tbl", 3], ["a-u-G", 1]]) {
    const { inbox, orders, said } = box();
    const xml = marker({ type });
    await inbox.take(xml);
    await inbox.take(xml);
    await inbox.take(marker({ type, now: Date.now() + 1000 })); // said again, at the same place
    assert.equal(orders.length, 1);
    const [{ id, issuer, order, task }] = orders;
    assert.deepEqual([id, issuer, order, task.priority, task.name, task.external_id], ["tak-m1@46.9550,7.4550", "chief", "task_add", priority, "School", "m1"]);
    // 0.005 degrees are 556 m to the north and 381 m to the east here.
    assert.ok(Math.abs(task.y_km - 0.556) < 0.002 && Math.abs(task.x_km - 0.381) < 0.002, JSON.stringify(task));
    assert.deepEqual(said, [["chief", "reports School: taken as task 101"]]);
  }
});

test("a marker that moves is another task, and the old one is cancelled; one that is deleted too", async () => {
  const { inbox, orders } = box();
  await inbox.take(marker());
  await inbox.take(marker({ at: { latitude: 46.956, longitude: 7.455 }, now: Date.now() + 1 }));
  assert.deepEqual(orders.map(({ order, task }) => [order, task.x_km === undefined ? task : "new"]), [["task_add", "new"], ["task_add", "new"], ["task_cancel", 101]]);
  await inbox.take(toXml(event({ uid: "x", type: "t-x-d-d", at: AT, now: Date.now(), holds: 60000, detail: { link: { $: { uid: "m1", relation: "p-p" } }, creator: { $: { callsign: "chief" } } } })));
  assert.deepEqual([orders.length, orders[3].order, orders[3].task], [4, "task_cancel", 102]);
  await inbox.take(marker({ uid: "e1", type: "b-a-o-tbl" }));
  await inbox.take(marker({ uid: "e1", type: "b-a-o-can", now: Date.now() + 2 }));
  assert.deepEqual([orders[5].order, orders[5].task], ["task_cancel", 105]);
});

test("only those who are allowed are heard, and nobody by default", async () => {
  for (const allow of [[], ["somebody"]]) {
    const { inbox, orders, notes, said } = box({ allow });
    await inbox.take(marker());
    await inbox.take(message("cancel 0"));
    assert.deepEqual([orders.length, said.length, inbox.counts.refused], [0, 0, 2]);
    assert.match(notes[0], /a report of chief is not heard/);
  }
  // Who a marker is of says its creator, not its own name.
  const { inbox, orders } = box();
  await inbox.take(marker({ callsign: "chief", creator: "stranger" }));
  assert.equal(orders.length, 0);
});

test("what is refused by the mission is told to who said it", async () => {
  const { inbox, said } = box({ refused: "there is no room for another task" });
  await inbox.take(marker());
  assert.deepEqual(said, [["chief", "reports School: refused: there is no room for another task"]]);
});

test("commands in chat", async () => {
  const { inbox, orders, said } = box();
  for (const text of ["status 0", "why 0", "pin 0 0 1", "PIN uav:0 worker:0 task:1", "unpin 1", "charge 0", "cancel 1", "fly me", "pin 1", "cancel -1", "status 999"]) await inbox.take(message(text));
  assert.deepEqual(orders.map(({ id, issuer, ...order }) => order), [{ order: "pin", agents: ["uav:0", "worker:0"], task: 1 }, { order: "pin", agents: ["uav:0", "worker:0"], task: 1 },
    { order: "unpin", task: 1 }, { order: "charge_now", agents: ["uav:0"] }, { order: "task_cancel", task: 1 }]);
  assert.deepEqual(said[0], ["chief", "Task 0: open"]);
  assert.deepEqual(said[1], ["chief", "Decision 3: lost: uav:0 could sense it; to:   another"]);
  assert.equal(said.filter(([, text]) => text.startsWith("I know: ")).length, 4);
  // What people say to each other in a room is none of ours.
  await inbox.take(message("who has coffee?", { room: "All Chat Rooms" }));
  assert.equal(said.length, 2 + 5 + 4);
});

test("our own events, and those that mean nothing here, are ignored", async () => {
  const { inbox, orders, picture } = box();
  for (const made of picture.due(Date.now())) await inbox.take(toXml(made));
  await inbox.take(marker({ type: "a-f-G-U-C" }));
  await inbox.take(marker({ type: "t-x-takp-v" }));
  assert.equal(orders.length, 0);
  assert.equal(inbox.counts.ignored, inbox.counts.heard);
});
