// The mission as events: what is said, how often, and how it ends.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Picture } from "../../../drivers/tak/picture.mjs";
import { SCENARIO, begun } from "../../tools/report/page/small_run.mjs";

const NOW = Date.parse("2026-03-01T12:00:00Z");
const scenario = { ...SCENARIO, origin: [46.95, 7.45] };
const at = (run, t, more = {}) => run.apply({ now_ms: t, epoch_ms: 0, ended: false, ...more });

function made() {
  const run = begun({ scenario, stops: [[0, 0, [0, 0, 0, 30000, 60000, 600, 0, 29400, 90000, 600, 300, 29100]], [1, 0, [0, 100, 100, 0]]],
    spans: [[0, 0, [0, 2]], [1, 0, [0, 1]]], tasks: [[1, 0, [0, 4, 60000, 0]]], now_ms: 60000 });
  const picture = new Picture();
  picture.begin(run);
  return { run, picture };
}
const byUid = (events) => new Map(events.map(({ event }) => [event.$.uid, event]));

test("agents with course, speed, battery and what they do; tasks and charging points as spots", () => {
  const { run, picture } = made();
  const events = byUid(picture.due(NOW));
  assert.deepEqual([...events.keys()], ["muster.r", "muster.r.uav.0", "muster.r.worker.0", "muster.r.task.0", "muster.r.task.1", "muster.r.charge.0"]);
  const uav = events.get("muster.r.uav.0");
  assert.deepEqual([uav.$.type, uav.detail.track.$.course, uav.detail.track.$.speed, uav.detail.status.$.battery], ["a-f-A-M-H-Q", "90.0", "10.00", "98"]);
  assert.deepEqual([uav.$.time, uav.$.stale], ["2026-03-01T12:00:00.000Z", "2026-03-01T12:01:00.000Z"]);
  // 600 m east of the origin.
  assert.ok(Math.abs(Number(uav.point.$.lon) - 7.45 - 600 / (111320 * Math.cos(46.95 * Math.PI / 180))) < 1e-4);
  assert.equal(events.get("muster.r.worker.0").detail.__group.$.role, "Team Member");
  assert.equal(events.get("muster.r.task.0").detail.color.$.argb, String(0xffffff00 | 0), "open, of normal priority");
  at(run, 90000, { tasks: [[0, 0, [0, 0, 90000, 3]]] });
  const later = byUid(picture.due(NOW + 1000));
  assert.equal(later.get("muster.r.uav.0").detail.track.$.course, "0.0", "it flies north now");
  assert.equal(later.get("muster.r.task.0").detail.color.$.argb, String(0xff00cc44 | 0), "done");
  assert.deepEqual([...later.keys()], ["muster.r.uav.0", "muster.r.task.0"], "what has not changed is not said again");
});

test("how high a UAV flies that is kept apart from others", () => {
  const { run, picture } = made();
  at(run, 60000, { altitudes: [0, [[0, 0, 0, 20000, 60, 90000, 60]]] });
  assert.match(byUid(picture.due(NOW)).get("muster.r.uav.0").detail.remarks, /, 60 m above the ground$/);
});

test("what stays as it is, is said again before it goes stale, and to somebody new at once", () => {
  const { picture } = made();
  picture.due(NOW);
  assert.equal(picture.due(NOW + 29_000).length, 0);
  assert.deepEqual([...byUid(picture.due(NOW + 31_000)).keys()], ["muster.r", "muster.r.uav.0", "muster.r.worker.0"]);
  picture.repeat();
  assert.equal(picture.due(NOW + 32_000).length, 6);
});

test("an agent that fails raises an alert, and its return ends it", () => {
  const { run, picture } = made();
  picture.due(NOW);
  at(run, 61000, { spans: [[0, 1, [61000, 6]]] });
  const alert = [...byUid(picture.due(NOW + 1000)).values()].find(({ $ }) => $.type === "b-a-o-pan");
  assert.deepEqual([alert.$.uid, alert.detail.link.$.uid], ["muster.r.alert.failed.uav:0", "muster.r.uav.0"]);
  at(run, 62000, { spans: [[0, 2, [62000, 1]]] });
  const over = byUid(picture.due(NOW + 2000)).get("muster.r.alert.failed.uav:0");
  assert.deepEqual([over.$.type, over.detail.emergency.$.cancel], ["b-a-o-can", "true"]);
  assert.equal(byUid(picture.due(NOW + 3000)).get("muster.r.alert.failed.uav:0"), undefined);
});

test("a zone in force is a shape; one that is lifted is not said any more", () => {
  const { run, picture } = made();
  at(run, 61000, { road_changes: [[61000, [["z1", "airfield", 61000, [], [[0, 0, 500, 0, 500, 500]]]]]] });
  const zone = byUid(picture.due(NOW)).get("muster.r.zone.z1");
  assert.deepEqual([zone.$.type, zone.detail.contact.$.callsign, zone.detail.link.length], ["u-d-f", "airfield", 4]);
  at(run, 62000, { road_changes: [[61000, [["z1", "airfield", 61000, [], [[0, 0, 500, 0, 500, 500]]]]], [62000, []]] });
  picture.repeat();
  assert.equal(byUid(picture.due(NOW)).get("muster.r.zone.z1"), undefined);
});

test("closed roads are lines, as long as they are closed", () => {
  const run = begun({ scenario: { ...scenario, roads: { source: "s", classes: [["road", 5, 50]], lines: [[0, 0, 0, 500, 0, 500, 500], [0, 1, 1, 2, 2]] } }, now_ms: 60000 });
  const picture = new Picture();
  picture.begin(run);
  at(run, 61000, { road_changes: [[61000, [["c1", "flood", 61000, [0]]]]] });
  const road = byUid(picture.due(NOW)).get("muster.r.closed.c1.0");
  assert.deepEqual([road.$.type, road.detail.contact.$.callsign, road.detail.link.length], ["u-d-f", "flood", 3]);
  at(run, 62000, { road_changes: [[61000, [["c1", "flood", 61000, [0]]]], [62000, []]] });
  picture.repeat();
  assert.equal(byUid(picture.due(NOW)).get("muster.r.closed.c1.0"), undefined);
});

test("with ways: the way ahead as a route, which goes when it is over", () => {
  const run = begun({ scenario, stops: [[0, 0, [0, 0, 0, 30000, 60000, 600, 0, 29400, 90000, 600, 300, 29100]], [1, 0, [0, 100, 100, 0]]], spans: [[0, 0, [0, 2]], [1, 0, [0, 1]]],
    now_ms: 60000, decisions: [0, [[0, 0, 1, 1, 1, 10, "certified", [7, 0, 0, -1, 1, -1, 900, 900, 1]]]] });
  const picture = new Picture({ ways: true });
  picture.begin(run);
  const way = byUid(picture.due(NOW)).get("muster.r.way.uav.0");
  assert.deepEqual([way.$.type, way.detail.contact.$.callsign, way.detail.link[0].$.type], ["b-m-r", "uav:0 to task 1", "b-m-p-w"]);
  assert.ok(way.detail.link.length >= 3, "here, the corner, the goal");
  assert.equal(byUid(picture.due(NOW + 1000)).get("muster.r.way.uav.0"), undefined);
  at(run, 61000, { spans: [[0, 1, [61000, 1]]] });
  const gone = byUid(picture.due(NOW + 2000)).get("muster.r.way.uav.0.gone");
  assert.deepEqual([gone.$.type, gone.detail.link.$.uid], ["t-x-d-d", "muster.r.way.uav.0"]);
  assert.equal(byUid(picture.due(NOW + 3000)).get("muster.r.way.uav.0.gone"), undefined);
});

test("the room hears of a decision once", () => {
  const { run, picture } = made();
  at(run, 60000, { decisions: [0, [[0, 60000, 1, 1, 1, 10, "certified", [7, 0, 0, -1, 1, -1, 900, 900, 1]]]] });
  assert.deepEqual(picture.news(), ["Task 1: uav:0 and worker:0"]);
  assert.deepEqual(picture.news(), []);
});

test("a mission without an origin shows nothing", () => {
  const picture = new Picture();
  picture.begin(begun());
  assert.deepEqual([picture.hasPlaces, picture.due(NOW)], [false, []]);
});
