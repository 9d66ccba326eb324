// Events as text and back, and what must not get through.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import { test } from "node:test";
import { LONGEST, NoEvent, Splitter, chat, event, readEvent, toXml } from "../../../drivers/tak/cot.mjs";

const NOW = Date.parse("2026-03-01T12:00:00Z");
const AT = { latitude: 46.95, longitude: 7.45 };

/** Two readers that others wrote: node-cot and, below it, xml-js. */
const { XML } = await import("../../../drivers/tak/node_modules/@tak-ps/node-cot/index.js");
const xmljs = createRequire(new URL("../../../drivers/tak/package.json", import.meta.url))("xml-js");

/** An event as ATAK shares one (Source: the tests of node-cot 2.1.3), with other times. */
const jenny = (time, stale, more = "") => `<event version="2.0" uid="ANDROID-deadbeef" type="a-f-G-U-C" how="m-g" time="${time}" start="${time}" stale="${stale}"><point lat="1.234567" lon="-3.141592" hae="-25.7" ce="9.9" le="9999999.0"/><detail><takv os="29" version="4.0.0.0 (deadbeef).1234567890-CIV" device="Some Android Device" platform="ATAK-CIV"/><contact xmppUsername="xmpp@host.com" endpoint="*:-1:stcp" callsign="JENNY"/><uid Droid="JENNY"/>${more}<status battery="78"/><track course="80.24833892285461" speed="0.0"/></detail></event>`;

test("what we write is read alike by three readers, whatever is in a name", () => {
  for (const name of ["Town hall", "A & B <c> \"d\" 'e'", "Çarşı 東京 🚁", "x]]>y", "true"]) {
    const xml = toXml(event({ uid: `muster.r.${name}`, type: "b-m-p-s-m", at: AT, now: NOW, holds: 60000, detail: { contact: { $: { callsign: name } }, status: { $: { readiness: "true" } }, remarks: name } }));
    const ours = readEvent(xml.slice(xml.indexOf("<event")), NOW);
    assert.deepEqual([ours.callsign, ours.remarks, ours.at, ours.stale - ours.time], [name, name, AT, 60000]);
    for (const read of [new XML(xml).raw, xmljs.xml2js(xml, { compact: true })]) {
      assert.equal(read.event.detail.contact._attributes.callsign, name);
      assert.equal(read.event.detail.status._attributes.readiness, "true");
      assert.equal(read.event.detail.remarks._text, name);
      assert.deepEqual([Number(read.event.point._attributes.lat), Number(read.event.point._attributes.lon)], [46.95, 7.45]);
      assert.equal(read.event._attributes.stale, "2026-03-01T12:01:00.000Z");
    }
  }
});

test("a chat message says from whom, to whom and what, line by line", () => {
  const xml = toXml(chat({ from: { uid: "muster.r", callsign: "MUSTER" }, to: { uid: "ANDROID-1", callsign: "JENNY" }, text: "Task 1\nTask 2\u0007", at: AT, now: NOW, number: 3 }));
  const { chat: said, remarks } = readEvent(xml, NOW);
  assert.deepEqual([said.sender, said.room, said.uid, remarks], ["MUSTER", "JENNY", "muster.r", "Task 1 Task 2"]);
  assert.match(new XML(xml).raw.event.detail.remarks._text, /^Task 1\nTask 2$/);
});

test("an event of ATAK is read", () => {
  const read = readEvent(jenny("2026-03-01T11:59:59.771Z", "2026-03-01T12:06:14.771Z"), NOW);
  assert.deepEqual([read.uid, read.type, read.callsign, read.at, read.chat], ["ANDROID-deadbeef", "a-f-G-U-C", "JENNY", { latitude: 1.234567, longitude: -3.141592 }, null]);
});

test("what is no event, over or from the future is refused with the reason", () => {
  const good = jenny("2026-03-01T11:59:59Z", "2026-03-01T12:06:14Z");
  const refused = (xml) => {
    try {
      readEvent(xml, NOW);
    } catch (error) {
      if (error instanceof NoEvent) return error.message;
      throw error;
    }
    return "";
  };
  assert.equal(refused(good), "");
  const bomb = `<!DOCTYPE event [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>${good.replace("JENNY", "&b;")}`;
  assert.match(refused(bomb), /document type/);
  assert.match(refused(jenny("2026-03-01T11:00:00Z", "2026-03-01T11:59:00Z")), /over/);
  assert.match(refused(jenny("2026-03-01T13:00:00Z", "2026-03-01T14:00:00Z")), /future/);
  assert.match(refused(jenny("yesterday", "2026-03-01T14:00:00Z")), /no times/);
  for (const [from, to] of [["1.234567", "91"], ["1.234567", "NaN"], ["1.234567", ""], ["-3.141592", "1e9"]]) assert.match(refused(good.replace(from, to)), /nowhere/, to);
  assert.match(refused(good.replace(/<point[^>]*>/, "")), /nowhere/);
  assert.match(refused(good.replace("a-f-G-U-C", "")), /uid or type/);
  assert.match(refused(good.replace("a-f-G-U-C", "a-f-G ../..")), /uid or type/);
  for (const text of ["", "x", "<event/>", "<event></event>", "<a><b></a>", "<event><point lat='1' lon='1'/></event>"]) assert.notEqual(refused(text), "", text);
});

test("damaged events are refused or read, and nothing else happens", () => {
  let seed = 1;
  const random = (n) => (seed = (seed * 48271) % 2147483647) % n;
  let read = 0;
  for (let round = 0; round < 3000; ++round) {
    let text = jenny("2026-03-01T11:59:59Z", "2026-03-01T12:06:14Z");
    for (let i = random(4); i >= 0; --i) {
      const at = random(text.length);
      text = random(2) ? text.slice(0, at) + text.slice(at + 1 + random(40)) : text.slice(0, at) + String.fromCharCode(random(256)) + text.slice(at);
    }
    try {
      readEvent(text, NOW);
      ++read;
    } catch (error) {
      assert.ok(error instanceof NoEvent, `${error.stack}\n${text}`);
    }
  }
  assert.ok(read > 100 && read < 2900, String(read));
});

test("a stream is parted wherever it is cut, also within a letter", () => {
  const events = ["Straße", "🚁", "b"].map((name) => toXml(event({ uid: name, type: "b-m-p-s-m", at: AT, now: NOW, holds: 60000, detail: { remarks: name } })));
  const bytes = Buffer.from(events.join("\n"));
  for (const size of [1, 2, 7, 1000, 1e6]) {
    const splitter = new Splitter();
    const found = [];
    for (let i = 0; i < bytes.length; i += size) found.push(...splitter.take(bytes.subarray(i, i + size)));
    assert.deepEqual(found.map((xml) => readEvent(xml, NOW).remarks), ["Straße", "🚁", "b"], String(size));
  }
});

test("what never ends, and what is no XML, is given up", () => {
  const endless = new Splitter();
  assert.throws(() => { for (let i = 0; i < 200; ++i) endless.take(Buffer.from(`<event a="${"x".repeat(1000)}`)); }, /longer than/);
  assert.throws(() => new Splitter().take(Buffer.from("GET / HTTP/1.1\r\n\r\n")), /no XML/);
  assert.throws(() => new Splitter().take(Buffer.from(`<event a="${"x".repeat(LONGEST)}"></event>`)), /longer than/);
});
