// The page's server, over real HTTP on a free port of 127.0.0.1.
import assert from "node:assert/strict";
import { once } from "node:events";
import { mkdtempSync, readdirSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { createServer, request } from "node:http";
import { connect } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { codeOf, keptLink, newToken, originsOf } from "../../../drivers/phone/link.mjs";
import { kindOf, Photos } from "../../../drivers/phone/photos.mjs";
import { PageServer } from "../../../drivers/phone/server.mjs";
import { Box } from "./box.mjs";

const JPEG = Buffer.concat([Buffer.from([0xff, 0xd8, 0xff, 0xe0]), Buffer.alloc(2000, 7)]);

/** Runs `body({box, ask, folder, server, token})` with a server; `ask(method, path, {body, headers})`. */
async function withServer(body, { mostBytes = 10_000, tiles = null } = {}) {
  const folder = mkdtempSync(join(tmpdir(), "muster-phone-"));
  const box = new Box();
  const token = newToken();
  const server = new PageServer({ token, origins: () => [], phone: box.phone, photos: new Photos(folder), mostBytes, tiles, note: () => {} });
  server.http.listen(0, "127.0.0.1");
  await once(server.http, "listening");
  const { port } = server.http.address();
  const origins = originsOf({ listen: "127.0.0.1", url: null }, port);
  server.origins = () => origins;
  const ask = async (method, path, { content, headers = {} } = {}) => {
    const asked = request({ host: "127.0.0.1", port, method, path, headers: { ...(method === "POST" ? { Origin: origins[0] } : {}), ...headers } });
    asked.on("error", () => {});  // it may have answered before all was sent
    asked.end(content);
    const [answer] = await once(asked, "response");
    let text = "";
    for await (const part of answer) text += part;
    return { status: answer.statusCode, headers: answer.headers, text };
  };
  try {
    await body({ box, ask, folder, server, token, port, origins });
  } finally {
    server.http.close();
    server.http.closeAllConnections();
    rmSync(folder, { recursive: true });
  }
}

test("tiles come from the mission's live page, and nothing else does", async () => {
  const asked = [];
  const live = createServer((question, answer) => {
    asked.push(question.url);
    const answers = { "/tiles.json": [200, "application/json", "{}"], "/tiles/9/266/180": [200, "image/png", "picture"], "/tiles/9/1/1": [200, "text/html", "<script>"],
      "/tiles/9/2/2": [302, "image/png", ""], "/tiles/9/3/3": [200, "image/png", Buffer.alloc(5e6)] };
    const [status, type, content] = answers[question.url] ?? [404, "text/plain", ""];
    answer.writeHead(status, { "Content-Type": type, Location: "/tiles.json" }).end(content);
  }).listen(0, "127.0.0.1");
  await once(live, "listening");
  const tiles = `http://127.0.0.1:${live.address().port}`;
  try {
    await withServer(async ({ ask, token }) => {
      const get = async (name) => (await ask("GET", `/${token}/${name}`)).status;
      const tile = await ask("GET", `/${token}/tile-9-266-180`);
      assert.deepEqual([tile.status, tile.headers["content-type"], tile.text], [200, "image/png", "picture"]);
      assert.equal(await get("tiles.json"), 200);
      assert.equal((await ask("GET", "/tiles.json")).status, 404, "without the token");
      for (const name of ["tile-9-1-1", "tile-9-3-3", "tile-9-5-5"]) assert.equal(await get(name), 404, name);
      assert.equal(await get("tile-9-2-2"), 502, "it sends nobody elsewhere");
      const before = asked.length;
      for (const name of ["tile-9-2", "tile-9-2-2-2", "tile-x-1-1", "tile-9--1-2", "tile-999-1-1", "tile-9-1-1?x", "tile-9-1-1%2f..%2fevents"]) {
        if (!name.includes("?")) assert.equal(await get(name), 404, name);
      }
      assert.equal(asked.length, before);
    }, { tiles });
    live.close();
    live.closeAllConnections();
    await withServer(async ({ ask, token }) => assert.equal((await ask("GET", `/${token}/tiles.json`)).status, 502), { tiles });
  } finally {
    live.close();
  }
  await withServer(async ({ ask, token }) => assert.equal((await ask("GET", `/${token}/tiles.json`)).status, 404));
});

test("who has the token has the page, and nobody else", () => withServer(async ({ ask, token, port }) => {
  const page = await ask("GET", `/${token}/`);
  assert.equal(page.status, 200);
  assert.match(page.text, /<title>Muster<\/title>/);
  assert.match(page.headers["content-security-policy"], /default-src 'none'.*frame-ancestors 'none'/);
  assert.equal(page.headers["referrer-policy"], "no-referrer");
  assert.equal(page.headers["x-content-type-options"], "nosniff");
  for (const [, name] of (await ask("GET", `/${token}/worker.js`)).text.matchAll(/"([^"]+\.[a-z]+)"/g)) assert.equal((await ask("GET", `/${token}/${name}`)).status, 200, name);
  const other = newToken();
  for (const path of ["/", "/page.mjs", `/${other}/`, `/${token}`, `/${token}x/`, `/${token}/../main.mjs`, `/${token}/main.mjs`, `/${token}/toString`,
    `/${token}/page.mjs/`, `/${token}/%2e%2e/main.mjs`, "*", `/?${token}`]) {
    assert.equal((await ask("GET", path)).status, 404, path);
  }
  for (const path of [`/${other}/sync`, "/sync", "/photo"]) assert.equal((await ask("POST", path, { content: "{}" })).status, 404, path);
  assert.equal((await ask("PUT", `/${token}/`)).status, 405);
  for (const host of ["evil.example", `evil.example:${port}`, "127.0.0.1", `127.0.0.1:${port + 1}`]) {
    assert.equal((await ask("GET", `/${token}/`, { headers: { Host: host } })).status, 403, host);
  }
  assert.equal((await ask("GET", `/${token}/`, { headers: { Host: `localhost:${port}` } })).status, 200);
}));

test("only its own page may say anything, in bounded lines", () => withServer(async ({ box, ask, token }) => {
  const say = (content, headers) => ask("POST", `/${token}/sync`, { content, headers });
  const good = JSON.stringify({ sent_ms: 0, items: [] });
  const { status, text } = await say(good);
  assert.equal(status, 200);
  assert.equal(JSON.parse(text).agent, "worker:4");
  for (const Origin of ["null", "http://evil.example", ""]) assert.equal((await say(good, { Origin })).status, 403, Origin);
  for (const bad of ["", "{", "null", "[]", '{"sent_ms":1}', '{"sent_ms":1,"items":[{}]}']) assert.equal((await say(bad)).status, 400, bad);
  assert.equal((await say(`${good}${" ".repeat(70_000)}`)).status, 413);
  assert.equal((await say(`${good}${" ".repeat(70_000)}`, { "Transfer-Encoding": "chunked" })).status, 413);
  assert.equal((await say(good)).status, 200, "it goes on");
  assert.equal(box.last("failed"), undefined);
}));

test("bytes that are no HTTP, and headers without end", () => withServer(async ({ ask, token, port }) => {
  for (const bytes of [Buffer.alloc(3000, 0xfe), Buffer.from(`GET /${token}/ HTTP/1.1\r\nHost: 127.0.0.1:${port}\r\nX: ${"x".repeat(20_000)}`)]) {
    const socket = connect(port, "127.0.0.1");
    socket.on("error", () => {});
    socket.write(bytes);
    socket.resume();
    await once(socket, "close");
  }
  assert.equal((await ask("GET", `/${token}/`)).status, 200);
}));

test("a photo lands with task, place and time, once, and overwrites none", () => withServer(async ({ box, ask, folder, token }) => {
  const id = box.goTo({ x_m: 4300, y_m: 4000 });
  box.pass(2, () => box.sync(box.place({ x_m: 4100, y_m: 4000 })));
  const send = (name, content = JPEG, more = "") => ask("POST", `/${token}/photo?id=${name}&ago_ms=10000&session=${box.phone.session}&order=${id}${more}`, { content });
  const first = await send("photo-0001");
  assert.deepEqual([first.status, first.text], [200, '{"photo":"worker-4_task-12_4100m-4000m_50s_1.jpg"}']);
  assert.equal((await send("photo-0001")).text, first.text, "once more it is the same photo");
  assert.match((await send("photo-0002")).text, /_50s_2\.jpg/);
  const words = JSON.parse(readFileSync(join(folder, "photos", "worker-4_task-12_4100m-4000m_50s_1.json"), "utf8"));
  assert.deepEqual([words.agent, words.task, Math.round(words.mission_s), Math.round(words.at.x_m), words.at.accuracy_m, words.bytes], ["worker:4", 12, 50, 4100, 8, JPEG.length]);
  assert.match(words.sha256, /^[0-9a-f]{64}$/);
  assert.equal((await ask("POST", `/${token}/photo?id=photo-0003&ago_ms=0&session=of-before&order=${id}`, { content: JPEG })).text.includes("no-task"), true);
  assert.deepEqual(readFileSync(join(folder, "photos", "worker-4_task-12_4100m-4000m_50s_2.jpg")), JPEG);
  // The next driver of that run knows nothing of these.
  const others = new Photos(folder).keep("photo-0001", JPEG, { agent: "worker:4", task: 12, mission_s: 50, at: { x_m: 4100, y_m: 4000 } });
  assert.match(others, /_50s_3\.jpg/);
  const strange = join(folder, "photos", "worker-4_task-12_4100m-4000m_50s_4.jpg");
  writeFileSync(strange, "somebody else's");
  assert.match((await send("photo-0005")).text, /_50s_5\.jpg/);
  assert.equal(readFileSync(strange, "utf8"), "somebody else's");
  assert.equal(readdirSync(join(folder, "photos")).length, 11, "five photos, no parts");
}));

test("what is no photo, too large or of a name of its own is refused", () => withServer(async ({ ask, folder, token }) => {
  const send = (query, content) => ask("POST", `/${token}/photo?${query}`, { content });
  assert.equal((await send("id=photo-0001&ago_ms=0", Buffer.from("<svg onload=alert(1)>"))).status, 415);
  assert.equal((await send("id=photo-0001&ago_ms=0", Buffer.concat([JPEG, Buffer.alloc(10_000)]))).status, 413);
  for (const query of ["", "id=../../x&ago_ms=0", "id=photo-0001&ago_ms=-1", "id=photo-0001&ago_ms=x", "id=photo%00001&ago_ms=0"]) {
    assert.equal((await send(query, JPEG)).status, 400, query);
  }
  assert.deepEqual(readdirSync(folder), []);
}));

test("pictures are known by their first bytes", () => {
  const kinds = [[JPEG, "jpg"], [Buffer.from("\x89PNG\r\n\x1a\n....", "latin1"), "png"], [Buffer.from("RIFF0000WEBP"), "webp"], [Buffer.from("0000ftypheic"), "heic"],
    [Buffer.from("GIF89a......"), null], [Buffer.alloc(0), null], [Buffer.from("0000ftypisom"), null]];
  for (const [bytes, kind] of kinds) assert.equal(kindOf(bytes), kind);
});

test("the link of before is kept for a driver that starts again, for its owner alone", () => {
  const folder = mkdtempSync(join(tmpdir(), "muster-phone-"));
  try {
    const kept = keptLink(folder, "worker:4");
    assert.equal(kept.load(), null);
    const link = { agent: "worker:4", url: "http://x/", token: newToken(), port: 5000 };
    kept.save(link);
    assert.deepEqual(kept.load(), { token: link.token, port: 5000 });
    const path = join(folder, "phones", "worker-4.json");
    assert.equal(statSync(path).mode & 0o777, 0o600);
    for (const broken of ["", "{", '{"token":"short","port":1}']) {
      writeFileSync(path, broken);
      assert.equal(kept.load(), null);
    }
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test("origins are those that the phone can name", () => {
  assert.deepEqual(originsOf({ listen: "127.0.0.1", url: null }, 81), ["http://127.0.0.1:81", "http://localhost:81"]);
  assert.deepEqual(originsOf({ listen: "192.168.7.5", url: null }, 81), ["http://192.168.7.5:81"]);
  assert.deepEqual(originsOf({ listen: "127.0.0.1", url: "https://phone.example" }, 81)[0], "https://phone.example");
  assert.ok(originsOf({ listen: "0.0.0.0", url: null }, 81).includes("http://127.0.0.1:81"));
});

test("the code to scan is square, light around, and has no colours where none are wanted", async () => {
  const lines = await codeOf(`http://192.168.7.5:40000/${newToken()}/`, false);
  assert.ok(lines.every((line) => line.length === lines[0].length && /^[ ▄▀█]+$/.test(line)));
  assert.equal(Math.ceil(lines[0].length / 2), lines.length);
  assert.match(lines[0], /^█+$/);
  assert.ok((await codeOf("x", true))[0].startsWith("\x1b[97;40m"));
});
