// A WebM file of one track. Source: RFC 8794 (EBML) and RFC 9559 (Matroska), of which WebM is a part.

const VIDEO = 1;

const bytesOf = (value) => {
  if (typeof value === "string") return new TextEncoder().encode(value);
  if (value instanceof Uint8Array) return value;
  const bytes = [];
  let rest = BigInt(value);
  do {
    bytes.unshift(Number(rest & 0xffn));
    rest >>= 8n;
  } while (rest > 0n);
  return Uint8Array.from(bytes);
};

const float = (value) => {
  const bytes = new Uint8Array(8);
  new DataView(bytes.buffer).setFloat64(0, value);
  return bytes;
};

/** An element: its id, its size in eight bytes, and a number, a text, bytes or elements. */
function element(id, content) {
  const parts = Array.isArray(content) ? content : [bytesOf(content)];
  const length = parts.reduce((sum, part) => sum + part.length, 0);
  const name = bytesOf(id);
  const out = new Uint8Array(name.length + 8 + length);
  out.set(name);
  new DataView(out.buffer).setBigUint64(name.length, 0x0100000000000000n | BigInt(length));
  let at = name.length + 8;
  for (const part of parts) {
    out.set(part, at);
    at += part.length;
  }
  return out;
}

function block({ ms, key, data }, clusterMs) {
  const out = new Uint8Array(4 + data.length);
  out[0] = 0x80 | VIDEO;
  new DataView(out.buffer).setInt16(1, ms - clusterMs);
  out[3] = key ? 0x80 : 0;
  out.set(data, 4);
  return element(0xa3, out);
}

/** The file, of frames { ms, key, data } in their order, the first of them a key frame; each key frame begins a cluster. */
export function webm({ width, height, codec, frames, durationMs }) {
  const clusters = [];
  for (const frame of frames) {
    if (frame.key) clusters.push({ ms: frame.ms, blocks: [] });
    clusters.at(-1).blocks.push(block(frame, clusters.at(-1).ms));
  }
  const head = element(0x1a45dfa3, [element(0x4286, 1), element(0x42f7, 1), element(0x42f2, 4), element(0x42f3, 8),
    element(0x4282, "webm"), element(0x4287, 4), element(0x4285, 2)]);
  const info = element(0x1549a966, [element(0x2ad7b1, 1000000), element(0x4489, float(durationMs)), element(0x4d80, "Muster"), element(0x5741, "Muster")]);
  const track = element(0xae, [element(0xd7, VIDEO), element(0x73c5, VIDEO), element(0x83, VIDEO), element(0x86, codec),
    element(0xe0, [element(0xb0, width), element(0xba, height)])]);
  const before = [info, element(0x1654ae6b, [track])];
  const body = clusters.map(({ ms, blocks }) => element(0x1f43b675, [element(0xe7, ms), ...blocks]));
  // Where each cluster is, so that players can seek.
  let at = before.reduce((sum, part) => sum + part.length, 0);
  const cues = body.map((cluster, i) => {
    const cue = element(0xbb, [element(0xb3, clusters[i].ms), element(0xb7, [element(0xf7, VIDEO), element(0xf1, at)])]);
    at += cluster.length;
    return cue;
  });
  return new Blob([head, element(0x18538067, [...before, ...body, element(0x1c53bb6b, cues)])], { type: "video/webm" });
}
