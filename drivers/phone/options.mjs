// The command line.
import { isIP } from "node:net";
import { parseArgs } from "node:util";

const HELP = `node main.mjs [OPTION...]

Takes a worker's or vehicle's part in a mission (docs/guide/drivers.md) with the phone of a person, who opens the link that is printed
(docs/guide/phone.md).

  --port N            of the page; 0: a free one (default: 0)
  --listen ADDRESS    of this machine, that the phone can reach; others in that network can, too (default: 127.0.0.1)
  --url URL           what the phone opens where something stands between, such as a server that speaks https
  --run DIR           the mission's run directory: photos go to DIR/photos, the link to DIR/phones, and stays the same when the
                      driver starts again (default: none, and no photos)
  --tiles URL         of the mission's live page (muster run --live --tiles FILE, muster live), whose base map the phone shows
  --lost-after S      it has failed when the phone was not heard for so many seconds (default: 600)
  --accuracy M        places that are less exact are not told (default: 100)
  --photo-mb MB       of a photo at most (default: 20)
  --auto              presses the buttons itself, to try a mission without a person
`;

export class UsageError extends Error {}

function number(values, name, low, high) {
  const value = Number(values[name]);
  if (!(values[name].trim() && value >= low && value <= high)) throw new UsageError(`--${name}: found '${values[name]}', expected a number from ${low} to ${high}`);
  return value;
}

function origin(text, name) {
  if (!text) return null;
  let url = null;
  try {
    url = new URL(text);
  } catch { /* said below */ }
  const isOne = url && ["http:", "https:"].includes(url.protocol) && url.pathname === "/" && !url.search && !url.hash && !url.username;
  if (!isOne) throw new UsageError(`--${name}: found '${text}', expected http(s)://HOST[:PORT]`);
  return url.origin;
}

/** The options; null: help was asked for, and given. Throws UsageError. */
export function readOptions(argv) {
  const defaults = { port: "0", listen: "127.0.0.1", url: "", tiles: "", run: "", "lost-after": "600", accuracy: "100", "photo-mb": "20" };
  const options = Object.fromEntries(Object.entries(defaults).map(([name, value]) => [name, { type: "string", default: value }]));
  let values;
  try {
    ({ values } = parseArgs({ args: argv, options: { ...options, auto: { type: "boolean" }, help: { type: "boolean", short: "h" } } }));
  } catch (error) {
    throw new UsageError(error.message.split(". ")[0]);
  }
  if (values.help) {
    process.stdout.write(HELP);
    return null;
  }
  const port = number(values, "port", 0, 65535);
  if (!Number.isInteger(port)) throw new UsageError(`--port: found '${values.port}', expected a whole number`);
  if (!isIP(values.listen)) throw new UsageError(`--listen: found '${values.listen}', expected an address such as 192.168.1.5 or 0.0.0.0`);
  return {
    port, listen: values.listen, url: origin(values.url, "url"), tiles: origin(values.tiles, "tiles"), hasTiles: values.tiles !== "", run: values.run || null, lostAfter: number(values, "lost-after", 5, 86400),
    accuracy: number(values, "accuracy", 1, 100000), mostBytes: number(values, "photo-mb", 0.01, 200) * 1e6, isAuto: values.auto === true,
    photos: values.run !== "",
  };
}
