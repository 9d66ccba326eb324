// Files of map tiles for tests: PMTiles of one zoom, pictures of one colour, vector tiles.
import { deflateSync } from "node:zlib";

function crcOf(bytes) {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let i = 0; i < 8; ++i) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}

/** A PNG of 4 x 4 pixels of one colour. */
export function png([r, g, b]) {
  const chunk = (type, data) => {
    const body = Buffer.concat([Buffer.from(type), data]);
    const [length, crc] = [Buffer.alloc(4), Buffer.alloc(4)];
    length.writeUInt32BE(data.length);
    crc.writeUInt32BE(crcOf(body));
    return Buffer.concat([length, body, crc]);
  };
  const head = Buffer.from([0, 0, 0, 4, 0, 0, 0, 4, 8, 2, 0, 0, 0]);
  const row = [0, ...Array(4).fill([r, g, b]).flat()];
  return Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), chunk("IHDR", head), chunk("IDAT", deflateSync(Buffer.from(Array(4).fill(row).flat()))), chunk("IEND", Buffer.alloc(0))]);
}

function varint(value) {
  const bytes = [];
  for (let rest = value; ; rest = Math.floor(rest / 128)) {
    if (rest < 128) return Buffer.from([...bytes, rest]);
    bytes.push((rest % 128) | 128);
  }
}

const field = (number, data) => Buffer.concat([varint(number * 8 + 2), varint(data.length), data]);
const zigzag = (n) => (n < 0 ? -2 * n - 1 : 2 * n);

/** A layer of a vector tile: features { type: 1 point, 2 line, 3 area, tags: { key: text }, places: [[x, y], ...] } of 4096 units. */
export function layer(name, features) {
  const [keys, values] = [[], []];
  const made = features.map(({ type, tags = {}, places }) => {
    const pairs = Object.entries(tags).flatMap(([key, value]) => [keys.push(key) - 1, values.push(value) - 1]);
    let [x, y] = [0, 0];
    const moves = places.map(([toX, toY]) => {
      const move = [zigzag(toX - x), zigzag(toY - y)];
      [x, y] = [toX, toY];
      return move;
    });
    const geometry = [9, ...moves[0], ...(moves.length > 1 ? [(moves.length - 1) * 8 + 2, ...moves.slice(1).flat(), ...(type === 3 ? [15] : [])] : [])];
    return field(2, Buffer.concat([field(2, Buffer.concat(pairs.map(varint))), varint(3 * 8), varint(type), field(4, Buffer.concat(geometry.map(varint)))]));
  });
  return field(3, Buffer.concat([field(1, Buffer.from(name)), ...made, ...keys.map((key) => field(3, Buffer.from(key))),
    ...values.map((value) => field(4, field(1, Buffer.from(value))))]));
}

/** The number of a tile along Hilbert's curve, by its quarters: how each is turned says in which order they come. */
export function numberOf(zoom, column, row) {
  const quarters = { a: [["0,0", "d"], ["0,1", "a"], ["1,1", "a"], ["1,0", "b"]], b: [["1,1", "c"], ["0,1", "b"], ["0,0", "b"], ["1,0", "a"]],
    c: [["1,1", "b"], ["1,0", "c"], ["0,0", "c"], ["0,1", "d"]], d: [["0,0", "a"], ["1,0", "d"], ["1,1", "d"], ["0,1", "c"]] };
  let turned = "a";
  let number = 0;
  for (let side = zoom - 1; side >= 0; --side) {
    const place = `${(column >> side) & 1},${(row >> side) & 1}`;
    const order = quarters[turned].findIndex(([quarter]) => quarter === place);
    number = 4 * number + order;
    turned = quarters[turned][order][1];
  }
  return (4 ** zoom - 1) / 3 + number;
}

/**
 * A PMTiles file: tile(column, row) for each column and row of a zoom; type 1 for vector tiles, 2 for PNG. `closer`: a tile of the next
 * zoom, [column, row, bytes].
 */
export function pmtiles({ zoom, columns, rows, type, tile, attribution, closer = null }) {
  const tiles = [];
  for (let column = columns[0]; column <= columns[1]; ++column) {
    for (let row = rows[0]; row <= rows[1]; ++row) tiles.push([numberOf(zoom, column, row), tile(column, row)]);
  }
  if (closer) tiles.push([numberOf(zoom + 1, closer[0], closer[1]), closer[2]]);
  tiles.sort(([a], [b]) => a - b);
  const parts = [tiles.map(([number], i) => number - (i ? tiles[i - 1][0] : 0)), tiles.map(() => 1), tiles.map(([, bytes]) => bytes.length), tiles.map((_, i) => (i ? 0 : 1))];
  const root = Buffer.concat([varint(tiles.length), ...parts.flat().map(varint)]);
  const metadata = Buffer.from(JSON.stringify({ attribution }));
  const data = Buffer.concat(tiles.map(([, bytes]) => bytes));
  const head = Buffer.alloc(127);
  head.write("PMTiles");
  head[7] = 3;
  [127, root.length, 127 + root.length, metadata.length, 0, 0, 127 + root.length + metadata.length, data.length].forEach((value, i) => head.writeBigUInt64LE(BigInt(value), 8 + 8 * i));
  [0, 1, 1, type, zoom, closer ? zoom + 1 : zoom].forEach((value, i) => { head[96 + i] = value; });
  [-180, -85, 180, 85].forEach((degrees, i) => head.writeInt32LE(degrees * 1e7, 102 + 4 * i));
  return Buffer.concat([head, root, metadata, data]);
}
