// The bridge's connections, without a mission.
import assert from "node:assert/strict";
import { test } from "node:test";
import { event } from "../../../drivers/tak/cot.mjs";
import { Links } from "../../../drivers/tak/links.mjs";

const nothing = () => {};
const OPTIONS = { connect: null, listen: 0, bind: "127.0.0.1", multicast: { host: "239.2.3.2", port: 0 }, ttl: 0 };
const EVENT = { uid: "a", type: "a-f-G", at: { latitude: 1, longitude: 2 }, now: 0, holds: 1000 };

test("closing twice is closing once; what is sent afterwards harms nobody", async () => {
  const links = new Links(OPTIONS, { heard: nothing, joined: nothing, note: nothing });
  await links.open();
  assert.equal(links.isHeard, true);
  links.close();
  links.close();
  assert.equal(links.isHeard, false);
  links.send(event(EVENT));
});
