// The command line.
import { readFileSync } from "node:fs";
import { isIPv4 } from "node:net";
import { parseArgs } from "node:util";

const LINK_HELP = `To whom (one or more of them):
  --connect HOST:PORT    a TAK server over TCP; connected again whenever the connection is lost
  --tls                  to that server over TLS
  --cert FILE --key FILE --ca FILE   certificate and key of this client, and whom it trusts (PEM)
  --listen PORT          clients that connect to this port
  --bind ADDRESS         of this machine, for --listen (default: 127.0.0.1)
  --multicast GROUP:PORT clients of the local network, as 239.2.3.1:6969
  --ttl N                networks that multicast may cross (default: 1; 0: this machine alone)
`;

const HELP = `node main.mjs MISSION [OPTION...]

Shows a mission to TAK clients and servers as Cursor on Target (docs/guide/tak.md), and takes reports and commands from those whom
--allow names. MISSION is the address that muster run --live prints, with its token if orders are to be given:
http://127.0.0.1:8087/#token=...

${LINK_HELP}
What:
  --allow CALLSIGN,...   who may report and command; all others only watch (default: nobody)
  --every S              seconds between two looks at the mission (default: 2)
  --most N               events a second to each client at most; what does not fit comes later (default: 500)
  --room NAME            chat room that is told who is sent where; "": none (default: Muster)
  --ways                 the way ahead of everybody who moves, too, as a route
`;

const DRIVER_HELP = `node drive.mjs --callsign NAME [OPTION...]

A driver (docs/guide/drivers.md) with which a TAK user takes the part of a worker or a vehicle (docs/guide/tak.md):
muster run SCENARIO --rate 1 --driver worker:4='node drivers/tak/drive.mjs --callsign Jenny --connect HOST:PORT'

  --callsign NAME        who takes the part: this user's place is the agent's, and this user's words are heard
  --accuracy M           places that are known less exactly than that are not told (default: 100)
  --lost-after S         seconds without a word of the user, after which the agent has failed (default: 600)

${LINK_HELP}`;

export class UsageError extends Error {}

function number(values, name, low, high) {
  const value = Number(values[name]);
  if (!(values[name].trim() && value >= low && value <= high)) throw new UsageError(`--${name}: found '${values[name]}', expected a number from ${low} to ${high}`);
  return value;
}

function endpoint(values, name) {
  if (!values[name]) return null;
  const [, host, port] = /^(.+):(\d{1,5})$/.exec(values[name]) ?? [];
  if (!host || Number(port) < 1 || Number(port) > 65535) throw new UsageError(`--${name}: found '${values[name]}', expected HOST:PORT`);
  return { host, port: Number(port) };
}

function mission(text) {
  let url = null;
  try {
    url = new URL(text);
  } catch { /* said below */ }
  if (url?.protocol !== "http:") throw new UsageError(`MISSION: found '${text ?? ""}', expected the address that muster run --live prints, http://127.0.0.1:PORT/`);
  return { url: url.origin, token: new URLSearchParams(url.hash.slice(1)).get("token") };
}

function pem(values, name) {
  if (!values[name]) return undefined;
  try {
    return readFileSync(values[name]);
  } catch (error) {
    throw new UsageError(`--${name}: ${error.message}`);
  }
}

const LINK_DEFAULTS = { connect: "", cert: "", key: "", ca: "", listen: "", bind: "127.0.0.1", multicast: "", ttl: "1" };

/** The words of a command line, all but `flags` with a value: {values, positionals}; null: help was asked for, and given. */
function parsed(argv, defaults, flags, help) {
  const options = Object.fromEntries(Object.entries({ ...LINK_DEFAULTS, ...defaults }).map(([name, value]) => [name, { type: "string", default: value }]));
  for (const name of ["tls", ...flags]) options[name] = { type: "boolean", default: false };
  try {
    const found = parseArgs({ args: argv, allowPositionals: true, options: { ...options, help: { type: "boolean", short: "h" } } });
    if (!found.values.help) return found;
  } catch (error) {
    throw new UsageError(error.message.split(". ")[0]);
  }
  process.stdout.write(help);
  return null;
}

/** Whom to speak to, for Links. */
function linksOf(values) {
  const multicast = endpoint(values, "multicast");
  if (multicast && !(isIPv4(multicast.host) && /^2(2[4-9]|3\d)\./.test(multicast.host))) throw new UsageError(`--multicast: found '${multicast.host}', expected a multicast group, 224.0.0.0 to 239.255.255.255`);
  const tls = values.tls ? { cert: pem(values, "cert"), key: pem(values, "key"), ca: pem(values, "ca") } : null;
  if (!tls && (values.cert || values.key || values.ca)) throw new UsageError("--cert, --key, --ca: found without --tls, expected it too");
  const listen = values.listen === "" ? null : number(values, "listen", 0, 65535);
  const connect = endpoint(values, "connect");
  if (!connect && listen === null && !multicast) throw new UsageError("--connect, --listen, --multicast: found none, expected one of them");
  return { connect, tls, listen, bind: values.bind, multicast, ttl: number(values, "ttl", 0, 255) };
}

/** The bridge's options; null: help was asked for, and given. Throws UsageError. */
export function readOptions(argv) {
  const found = parsed(argv, { allow: "", every: "2", most: "500", room: "Muster" }, ["ways"], HELP);
  if (!found) return null;
  const { values, positionals } = found;
  if (positionals.length !== 1) throw new UsageError(`MISSION: found ${positionals.length} addresses, expected one`);
  const links = linksOf(values);
  return { mission: mission(positionals[0]), ...links, allow: new Set(values.allow.split(",").map((name) => name.trim()).filter(Boolean)),
    every: number(values, "every", 0.05, 60), most: number(values, "most", 1, 1e5), room: values.room, ways: values.ways };
}

/** The driver's options; null: help was asked for, and given. Throws UsageError. */
export function readDriverOptions(argv) {
  const found = parsed(argv, { callsign: "", accuracy: "100", "lost-after": "600" }, [], DRIVER_HELP);
  if (!found) return null;
  const { values, positionals } = found;
  if (positionals.length > 0) throw new UsageError(`found '${positionals[0]}', expected options alone`);
  if (!values.callsign.trim()) throw new UsageError("--callsign: found none, expected who takes this part");
  return { ...linksOf(values), callsign: values.callsign.trim(), accuracy: number(values, "accuracy", 1, 1e5), lostAfter: number(values, "lost-after", 1, 1e6) };
}
