// The driver as a program, and a phone that does as told.
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { Program } from "../mavlink/programs.mjs";

export const MAIN = join(dirname(fileURLToPath(import.meta.url)), "../../../drivers/phone/main.mjs");

/** Runs `body({start(command, words, options), folder})`; what was started is ended behind it. */
export async function withPrograms(body) {
  const folder = mkdtempSync(join(tmpdir(), "muster-phone-"));
  const programs = [];
  const start = (command, words, options) => {
    programs.push(new Program(command, words, options));
    return programs.at(-1);
  };
  try {
    return await body({ start, folder });
  } finally {
    for (const { child } of programs) child.kill("SIGKILL");
    await Promise.all(programs.map((program) => program.ended));
    rmSync(folder, { recursive: true, force: true });
  }
}

/** The address that the driver prints. */
export async function linkOf(program, from = 0) {
  const line = await program.line((some) => some.startsWith("phone: the link of"), from);
  return line.split(": ").at(-1);
}

/** Asks as the page does. */
export async function sync(link, ...items) {
  const response = await fetch(`${link}sync`, { method: "POST", headers: { Origin: new URL(link).origin }, body: JSON.stringify({ sent_ms: Date.now(), items }) });
  if (response.status !== 200) throw new Error(`${response.status}: ${await response.text()}`);
  return response.json();
}

/** Presses the buttons that the page has, until it is over; returns what was pressed. */
export async function bePhone(link, every_ms = 100) {
  const pressed = [];
  for (let number = 0; ; ++number) {
    let view;
    try {
      view = await sync(link);
      const { order } = view;
      const type = order?.stage === "going" ? "here" : order?.stage === "working" && view.mission_s >= order.ends_s ? "done" : null;
      if (view.over !== null || view.failed) return pressed;
      if (type) {
        await sync(link, { id: `pressed-${number}`, session: view.session, at_ms: Date.now(), type, order: type === "here" ? order.goto : order.id });
        pressed.push(type);
      }
    } catch (error) {
      if (error.cause) return pressed;  // the driver has ended
      throw error;
    }
    await new Promise((resolve) => setTimeout(resolve, every_ms));
  }
}
