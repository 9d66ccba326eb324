// The link that a person opens: its token, its addresses, and the code to scan.
import { randomBytes, timingSafeEqual } from "node:crypto";
import { chmodSync, mkdirSync, readFileSync, renameSync, writeFileSync } from "node:fs";
import { networkInterfaces } from "node:os";
import { join } from "node:path";

const TOKEN = /^[0-9A-Za-z_-]{22}$/;
const LOOPBACK = /^(127\.|::1$)/;

/** 128 bits that nobody guesses. */
export function newToken() {
  return randomBytes(16).toString("base64url");
}

export function isToken(found, token) {
  const [a, b] = [Buffer.from(found), Buffer.from(token)];
  return a.length === b.length && timingSafeEqual(a, b);
}

export const isLoopback = (address) => LOOPBACK.test(address);

function addressesOf(listen) {
  if (!["0.0.0.0", "::"].includes(listen)) return [listen];
  const all = Object.values(networkInterfaces()).flat();
  return [...all.filter(({ internal }) => !internal), ...all.filter(({ internal }) => internal)]
    .filter(({ family, scopeid }) => (family === "IPv4" || listen === "::") && !scopeid)
    .map(({ address }) => address);
}

/** Origins that a browser may name for us; the first goes into the link. */
export function originsOf({ listen, url }, port) {
  const addresses = addressesOf(listen);
  const names = [...addresses, ...(addresses.some(isLoopback) ? ["localhost"] : [])];
  const own = names.map((name) => new URL(`http://${name.includes(":") ? `[${name}]` : name}:${port}`).origin);
  return url ? [url, ...own] : own;
}

/** {token, port} of the agent in the run directory, so that a driver that starts again has the link of before. */
export function keptLink(run, agent) {
  const folder = run && join(run, "phones");
  const path = run && join(folder, `${agent.replace(":", "-")}.json`);
  return {
    load() {
      try {
        const { token, port } = JSON.parse(readFileSync(path, "utf8"));
        return TOKEN.test(token) && Number.isInteger(port) ? { token, port } : null;
      } catch {
        return null;  // there is none, or no whole one
      }
    },
    save(link) {
      if (!run) return;
      mkdirSync(folder, { recursive: true, mode: 0o700 });
      writeFileSync(`${path}.new`, `${JSON.stringify(link)}\n`, { mode: 0o600 });
      chmodSync(`${path}.new`, 0o600);
      renameSync(`${path}.new`, path);
    },
  };
}

const BLOCKS = [" ", "▄", "▀", "█"];  // of an upper and a lower half that are light

/** The code as lines of text, two rows in one; light on dark where there are no colours. null: no package for it. */
export async function codeOf(text, hasColours) {
  let make;
  try {
    ({ default: make } = await import("qrcode-generator"));
  } catch {
    return null;
  }
  const code = make(0, "M");
  code.addData(text);
  code.make();
  const size = code.getModuleCount(), quiet = 3;
  const isLight = (row, column) => !(row >= 0 && column >= 0 && row < size && column < size && code.isDark(row, column));
  const lines = [];
  for (let row = -quiet; row < size + quiet; row += 2) {
    let line = "";
    for (let column = -quiet; column < size + quiet; ++column) line += BLOCKS[2 * isLight(row, column) + isLight(row + 1, column)];
    lines.push(hasColours ? `\x1b[97;40m${line}\x1b[0m` : line);
  }
  return lines;
}
