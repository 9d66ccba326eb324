// The command line.
import { readFileSync } from "node:fs";
import { isIPv4 } from "node:net";
import { parseArgs } from "node:util";

const HELP = `node main.mjs MISSION [OPTION...]

Shows a mission to TAK clients and servers as Cursor on Target (docs/guide/tak.md), and takes reports and commands from those whom
--allow names. MISSION is the address that muster run --live prints, with its token if orders are to be given:
http://127.0.0.1:8087/#token=...

To whom (one or more of them):
  --connect HOST:PORT    a TAK server over TCP; connected again whenever the connection is lost
  --tls                  to that server over TLS
  --cert FILE --key FILE --ca FILE   certificate and key of this client, and whom it trusts (PEM)
  --listen PORT          clients that connect to this port
  --bind ADDRESS         of this machine, for --listen (default: 127.0.0.1)
  --multicast GROUP:PORT clients of the local network, as 239.2.3.1:6969
  --ttl N                networks that multicast may cross (default: 1; 0: this machine alone)

What:
  --allow CALLSIGN,...   who may report and command; all others only watch (default: nobody)
  --every S              seconds between two looks at the mission (default: 2)
  --most N               events a second to each client at most; what does not fit comes later (default: 500)
  --room NAME            chat room that is told who is sent where; "": none (default: Muster)
`;

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

/** The options; null: help was asked for, and given. Throws UsageError. */
export function readOptions(argv) {
  const defaults = { connect: "", cert: "", key: "", ca: "", listen: "", bind: "127.0.0.1", multicast: "", ttl: "1", allow: "", every: "2", most: "500", room: "Muster" };
  const options = Object.fromEntries(Object.entries(defaults).map(([name, value]) => [name, { type: "string", default: value }]));
  let values;
  let positionals;
  try {
    ({ values, positionals } = parseArgs({ args: argv, allowPositionals: true, options: { ...options, tls: { type: "boolean" }, help: { type: "boolean", short: "h" } } }));
  } catch (error) {
    throw new UsageError(error.message.split(". ")[0]);
  }
  if (values.help) {
    process.stdout.write(HELP);
    return null;
  }
  if (positionals.length !== 1) throw new UsageError(`MISSION: found ${positionals.length} addresses, expected one`);
  const multicast = endpoint(values, "multicast");
  if (multicast && !(isIPv4(multicast.host) && /^2(2[4-9]|3\d)\./.test(multicast.host))) throw new UsageError(`--multicast: found '${multicast.host}', expected a multicast group, 224.0.0.0 to 239.255.255.255`);
  const tls = values.tls ? { cert: pem(values, "cert"), key: pem(values, "key"), ca: pem(values, "ca") } : null;
  if (!tls && (values.cert || values.key || values.ca)) throw new UsageError("--cert, --key, --ca: found without --tls, expected it too");
  const listen = values.listen === "" ? null : number(values, "listen", 0, 65535);
  const connect = endpoint(values, "connect");
  if (!connect && listen === null && !multicast) throw new UsageError("--connect, --listen, --multicast: found none, expected one of them");
  return { mission: mission(positionals[0]), connect, tls, listen, bind: values.bind, multicast, ttl: number(values, "ttl", 0, 255),
    allow: new Set(values.allow.split(",").map((name) => name.trim()).filter(Boolean)), every: number(values, "every", 0.05, 60), most: number(values, "most", 1, 1e5), room: values.room };
}
