// Pictures that the autopilot or a camera beside it says it has taken: CAMERA_IMAGE_CAPTURED, and ArduPilot's CAMERA_FEEDBACK.
import { MOST_PHOTOS } from "../photos.mjs";

/** Who speaks of pictures: the autopilot, MAV_COMP_ID_CAMERA to MAV_COMP_ID_CAMERA6. */
const SPEAKERS = [1, 100, 101, 102, 103, 104, 105];
/** Times in microseconds that are of a calendar: from 2001 to 2286. */
const FROM_US = 1e15, UNTIL_US = 1e16;

function placeOf(lat, lon) {
  const isNone = (lat === 0 && lon === 0) || Math.abs(lat) > 90e7 || Math.abs(lon) > 180e7;
  return isNone ? null : { latitude_deg: lat / 1e7, longitude_deg: lon / 1e7 };
}

function utcOf(time_us) {
  const us = Number(time_us);
  return us >= FROM_US && us < UNTIL_US ? new Date(us / 1000).toISOString() : null;
}

const readers = {
  CAMERA_IMAGE_CAPTURED: (message) => ({
    camera: message.cameraId, image: message.imageIndex, isTaken: message.captureResult === 1, place: placeOf(message.lat, message.lon),
    altitude_m: message.alt / 1000, height_m: message.relativeAlt / 1000, taken_utc: utcOf(message.timeUtc),
    file_url: String(message.fileUrl).replace(/[^\x20-\x7e]/g, "").trim() || null,
  }),
  CAMERA_FEEDBACK: (message) => ({
    camera: message.camIdx, image: message.imgIdx, isTaken: true, place: placeOf(message.lat, message.lng), altitude_m: message.altMsl,
    height_m: message.altRel, taken_utc: utcOf(message.timeUsec), file_url: null,
  }),
};

export class Pictures {
  #heard = new Set();

  /** `keep(of)`: takes what drivers/photos.mjs keeps; `note`: takes words for people; `map`: of the mission. */
  constructor({ keep, note, map }) {
    Object.assign(this, { keep, note, map });
  }

  /** Takes a frame of the UAV's system, of which only some tell of pictures; `now`: {agent, task, mission_s, place} of the UAV. */
  hear({ component, name, message }, now) {
    if (!Object.hasOwn(readers, name) || !SPEAKERS.includes(component)) return;
    const { camera, image, isTaken, place, ...more } = readers[name](message);
    const key = `${name} ${component} ${camera} ${image}`;  // what got lost is perhaps said again
    if (this.#heard.has(key) || this.#heard.size >= MOST_PHOTOS) return;
    this.#heard.add(key);
    if (!isTaken) return this.note(`picture ${image} was not taken, says its camera`);
    const at = place ?? now.place;
    this.keep({
      agent: now.agent, task: now.task, mission_s: now.mission_s, at: at && { ...this.map.toMetres(at), ...at }, ...more,
      said_by: { message: name, component, camera, image },
    });
  }
}
