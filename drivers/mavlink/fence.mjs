// The autopilot's fence, over MAVLink's mission protocol: read, to be put back, and written. Generators, as talk.mjs has them.
import { common } from "./frames.mjs";
import { Trouble } from "./talk.mjs";

const FENCE = common.MavMissionType.FENCE;
/** MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION and _EXCLUSION: it has to stay in, or out. */
export const STAY_IN = 5001, STAY_OUT = 5002;
const MOST_ITEMS = 200;
const TIMES = 3;
const FIELDS = ["command", "frame", "param1", "param2", "param3", "param4", "x", "y", "z"];

/** Of 1e-7 degrees: autopilots that keep degrees as numbers with a point give places back so much beside. */
const ROUNDING = 2;

/** Whether an item that was written is the one that is read back. */
function isSame(item, has) {
  return item.command === has.command && item.param1 === has.param1 && Math.abs(item.x - has.x) <= ROUNDING && Math.abs(item.y - has.y) <= ROUNDING;
}

/** The autopilot has no room for so many items. */
export class NoRoom extends Trouble {}

const isOfFence = (heard, ...names) => names.includes(heard?.name) && heard.message.missionType === FENCE;

/** The items that it has, to be written again. */
export function* readFence(talk) {
  const count = yield* talk.ask(common.MissionRequestList, () => ({ missionType: FENCE }), (heard) => isOfFence(heard, "MISSION_COUNT"));
  if (!count) throw new Trouble("its fence cannot be read: no answer");
  const items = [];
  while (items.length < Math.min(count.message.count, MOST_ITEMS)) {
    const isNext = (heard) => isOfFence(heard, "MISSION_ITEM_INT") && heard.message.seq === items.length;
    const heard = yield* talk.ask(common.MissionRequestInt, () => ({ seq: items.length, missionType: FENCE }), isNext);
    if (!heard) throw new Trouble(`its fence cannot be read: item ${items.length} of ${count.message.count} is missing`);
    items.push(Object.fromEntries(FIELDS.map((name) => [name, heard.message[name]])));
  }
  talk.sendTo(common.MissionAck, { type: 0, missionType: FENCE });
  return items;
}

/** Items of a polygon. `command`: STAY_IN or STAY_OUT. */
export function polygon(command, corners) {
  return corners.map(({ latitude_deg, longitude_deg }) => ({
    command, frame: 0, param1: corners.length, x: Math.round(latitude_deg * 1e7), y: Math.round(longitude_deg * 1e7), z: 0,
  }));
}

/**
 * Writes it, and reads it back; it has no other then. When the last answer is lost nobody answers any more: then it is written again.
 */
export function* writeFence(talk, items) {
  for (let n = 0; n < TIMES; ++n) {
    if (!(yield* writeOnce(talk, items))) continue;
    const has = yield* readFence(talk);
    if (has.length !== items.length || !items.every((item, i) => isSame(item, has[i]))) throw new Trouble("its fence is not as it was written");
    return;
  }
  throw new Trouble("its fence cannot be written: no answer");
}

/** Returns whether it was answered. */
function* writeOnce(talk, items) {
  const isAsked = (heard) => isOfFence(heard, "MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK");
  let heard = items.length
    ? yield* talk.ask(common.MissionCount, () => ({ count: items.length, missionType: FENCE }), isAsked)
    : yield* talk.ask(common.MissionClearAll, () => ({ missionType: FENCE }), isAsked);
  // It asks for one after the other, and again for what it has not got.
  while (heard && heard.name !== "MISSION_ACK") {
    const seq = heard.message.seq;
    if (seq >= items.length) throw new Trouble(`its fence cannot be written: it asks for item ${seq} of ${items.length}`);
    heard = yield* talk.ask(common.MissionItemInt, () => ({ ...items[seq], seq, missionType: FENCE, autocontinue: 1 }), isAsked);
  }
  if (!heard) return false;
  const result = heard.message.type;
  if (result === common.MavMissionResult.NO_SPACE) throw new NoRoom(`its fence is refused: it has no room for ${items.length} corners`);
  if (result !== 0) throw new Trouble(`its fence is refused: ${common.MavMissionResult[result] ?? `result ${result}`}`);
  return true;
}
