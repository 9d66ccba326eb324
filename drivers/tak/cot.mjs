// Cursor on Target: events as objects and as XML. Source of types and details: MITRE's CoT schema 2.0, and what ATAK shares.
import { XMLBuilder, XMLParser } from "fast-xml-parser";

const XML = { ignoreAttributes: false, attributesGroupName: "$", attributeNamePrefix: "" };
const builder = new XMLBuilder({ ...XML, suppressEmptyNode: true, suppressBooleanAttributes: false });
const parser = new XMLParser({ ...XML, parseTagValue: false, parseAttributeValue: false, processEntities: true });

export const UNKNOWN = "9999999.0";
export const LONGEST = 64 * 1024; // bytes of an event
const LONGEST_TEXT = 1000;
const FUTURE_MS = 5 * 60_000; // clocks differ by that much

export class NoEvent extends Error {}

const clean = (text, most = LONGEST_TEXT) => String(text ?? "").replace(/[\p{Cc}\p{Cf}]+/gu, " ").trim().slice(0, most);

/** An event: `at` is {latitude, longitude}, `detail` as fast-xml-parser writes it; it holds from `now` for `holds` milliseconds. */
export function event({ uid, type, how = "m-g", at, now, holds, detail = {} }) {
  const time = (ms) => new Date(ms).toISOString();
  return { event: {
    $: { version: "2.0", uid, type, how, time: time(now), start: time(now), stale: time(now + holds) },
    point: { $: { lat: at.latitude.toFixed(7), lon: at.longitude.toFixed(7), hae: UNKNOWN, ce: UNKNOWN, le: UNKNOWN } },
    detail,
  } };
}

export const toXml = (object) => `<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n${builder.build(object)}\n`;

/** A message of a chat room, or to one person: `to` is {callsign, uid}, of a room both are its name. */
export function chat({ from, to, text, at, now, number }) {
  const messageId = `${from.uid}.${number}`;
  return event({ uid: `GeoChat.${from.uid}.${to.uid}.${messageId}`, type: "b-t-f", how: "h-g-i-g-o", at, now, holds: 24 * 3600_000, detail: {
    __chat: { $: { parent: "RootContactGroup", groupOwner: "false", messageId, chatroom: to.callsign, id: to.uid, senderCallsign: from.callsign },
      chatgrp: { $: { uid0: from.uid, uid1: to.uid, id: to.uid } } },
    link: { $: { uid: from.uid, type: "a-f-G-I", relation: "p-p" } },
    remarks: { $: { source: `BAO.F.ATAK.${from.uid}`, to: to.uid, time: new Date(now).toISOString() }, "#text": text.split("\n").map((line) => clean(line)).join("\n") },
  } });
}

/** A way over these places, as a route. */
export function route({ uid, callsign, places, now, holds, remarks = "", isOnFoot = false }) {
  const link = places.map(({ latitude, longitude }, i) => ({ $: { uid: `${uid}.${i}`, callsign: i === places.length - 1 ? callsign : "",
    type: i === 0 || i === places.length - 1 ? "b-m-p-w" : "b-m-p-c", point: `${latitude.toFixed(7)},${longitude.toFixed(7)}`, relation: "c" } }));
  return event({ uid, type: "b-m-r", at: places[0], now, holds, detail: { link, link_attr: { $: { color: "-16711681", stroke: "3", type: isOnFoot ? "On Foot" : "Vehicle",
    method: isOnFoot ? "Walking" : "Driving", direction: "Infil", routetype: "Primary", order: "Ascending Check Points", prefix: "CP", planningmethod: "Infil" } },
  contact: { $: { callsign } }, remarks } });
}

/** What was shown as `uid` is there no more. */
export const deletion = ({ uid, type, at, now }) => event({ uid: `${uid}.gone`, type: "t-x-d-d", at, now, holds: 60_000, detail: { link: { $: { uid, type, relation: "none" } }, __forcedelete: {} } });

const first = (node) => (Array.isArray(node) ? node[0] : node);
const attributes = (node) => first(node)?.$ ?? {};
const words = (node) => (typeof first(node) === "object" ? first(node)?.["#text"] : first(node));

/**
 * What an event says: {uid, type, time, stale (milliseconds), at, ce (m, null: unknown), callsign, remarks, links, chat}. Throws NoEvent where it is
 * none, is over, or comes from the future.
 */
export function readEvent(xml, now) {
  if (/<!/.test(xml)) throw new NoEvent("it declares a document type");
  let top;
  try {
    top = parser.parse(xml).event;
  } catch (error) {
    throw new NoEvent(`it is no XML: ${clean(error.message, 80)}`);
  }
  const { uid, type, time, stale } = attributes(top);
  const point = attributes(top?.point);
  const degrees = (text) => (/^\s*[-+]?\d/.test(text ?? "") ? Number(text) : NaN);
  const [latitude, longitude, from, until] = [degrees(point.lat), degrees(point.lon), Date.parse(time), Date.parse(stale)];
  if (!uid || !type || uid.length > 300 || !/^[a-z]-[A-Za-z0-9-]{1,60}$/.test(type)) throw new NoEvent("it has no uid or type");
  if (!(Math.abs(latitude) <= 90 && Math.abs(longitude) <= 180)) throw new NoEvent("it is nowhere on the earth");
  if (!Number.isFinite(from) || !Number.isFinite(until)) throw new NoEvent("it has no times");
  if (from > now + FUTURE_MS) throw new NoEvent("it is from the future");
  if (until < now) throw new NoEvent("it is over");
  const detail = first(top.detail) || {};
  const links = [detail.link ?? []].flat().map(attributes);
  const room = attributes(detail.__chat);
  const ce = degrees(point.ce);
  return { uid: clean(uid), type, time: from, stale: until, at: { latitude, longitude }, ce: ce >= 0 && ce < Number(UNKNOWN) ? ce : null,
    callsign: clean(attributes(detail.contact).callsign, 80), creator: clean(attributes(detail.creator).callsign, 80),
    remarks: clean(words(detail.remarks)), links, cancels: attributes(detail.emergency).cancel === "true",
    chat: detail.__chat === undefined ? null : { sender: clean(room.senderCallsign, 80), room: clean(room.chatroom, 80), uid: clean(links[0]?.uid ?? "", 300) } };
}

/** Parts a stream of events; what is longer than an event may be, or begins as none, is given up: `take` throws NoEvent then. */
export class Splitter {
  #text = "";
  #decoder = new TextDecoder("utf-8");

  /** The whole events so far. */
  take(bytes) {
    this.#text += this.#decoder.decode(bytes, { stream: true });
    const found = [];
    for (;;) {
      const end = this.#text.indexOf("</event>");
      const alone = /^\s*(<\?xml[^>]*>\s*)?<event\b[^>]*\/>/.exec(this.#text);
      if (alone && (end < 0 || alone[0].length <= end)) {
        this.#text = this.#text.slice(alone[0].length);
        continue; // an event without a point is none
      }
      if (end < 0) break;
      found.push(this.#text.slice(0, end + "</event>".length));
      this.#text = this.#text.slice(end + "</event>".length);
    }
    if (this.#text.length > LONGEST || /^\s*[^\s<]/.test(this.#text)) throw new NoEvent(this.#text.length > LONGEST ? `an event is longer than ${LONGEST} bytes` : "what comes is no XML");
    if (found.some((text) => text.length > LONGEST)) throw new NoEvent(`an event is longer than ${LONGEST} bytes`);
    return found;
  }
}
