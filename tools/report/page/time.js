import { say } from "./language.js";

/** "1:23:30" of milliseconds; "1:23" without seconds. */
export function clockText(ms, seconds = true) {
  const s = Math.max(0, Math.floor(ms / 1000));
  const two = (n) => String(n).padStart(2, "0");
  const hm = `${Math.floor(s / 3600)}:${two(Math.floor(s / 60) % 60)}`;
  return seconds ? `${hm}:${two(s % 60)}` : hm;
}

const IN_STEP = 0.02; // share by which a mission at rate 1 may differ from the wall's time
const SAMPLE = 10; // of a process: t_ms, wall_ms, ...

const iso = (ms) => new Date(ms).toISOString();

/** "UTC-05:00" */
function zoneName(offsetMin) {
  if (offsetMin === 0) return "UTC";
  const minutes = Math.abs(offsetMin);
  const two = (n) => String(n).padStart(2, "0");
  return `UTC${offsetMin < 0 ? "-" : "+"}${two(Math.floor(minutes / 60))}:${two(minutes % 60)}`;
}

/**
 * What clocks show in the scenario's place at t, { time: "10:31:30", zone: "UTC-05:00", date: "2010-01-16", utc: "15:31:30 UTC" };
 * "10:31:30 +1 d" on the day after the start's. Null where the scenario has no start.
 */
export function localTime(run, t) {
  const start = run.scenario?.start;
  if (!start || !Number.isFinite(t)) return null;
  const [startMs, offsetMin] = start;
  const at = (ms) => iso(startMs + ms + offsetMin * 60000);
  const days = Math.round((Date.parse(at(t).slice(0, 10)) - Date.parse(at(0).slice(0, 10))) / 86400000);
  return { time: `${at(t).slice(11, 19)}${days > 0 ? ` +${days} d` : ""}`, zone: zoneName(offsetMin), date: at(t).slice(0, 10),
    utc: `${iso(startMs + t).slice(11, 19)} UTC` };
}

/** "1:23:30 (10:23:30 local)"; mission time alone where the scenario has no start. */
export function timeText(run, t) {
  const local = localTime(run, t);
  return local ? say("{time} ({local} local)", { time: clockText(t), local: local.time }) : clockText(t);
}

/** "10:31:30 UTC-05:00, 15:31:30 UTC"; "" where the scenario has no start. */
export function localWords(run, t) {
  const local = localTime(run, t);
  if (!local) return "";
  return local.zone === "UTC" ? `${local.time} UTC` : `${local.time} ${local.zone}, ${local.utc}`;
}

/** What stands beside mission time, { text, date }: the scenario's own clocks, else the wall's where mission time is theirs. */
export function wallTime(run, t) {
  const local = localTime(run, t);
  if (local) return { text: localWords(run, t), date: local.date };
  const at = stepTime(run, t);
  return at === null ? null : { text: say("{utc} UTC, {local} here", { utc: iso(at).slice(11, 19), local: new Date(at).toLocaleTimeString("en-GB") }), date: iso(at).slice(0, 10) };
}

/** The wall's time in a mission that kept step with it; null in one simulated, faster or slower, or one that has only begun. */
function stepTime(run, t) {
  if (!(run.epochMs > 0)) return null;
  const samples = [...run.processes.values()].filter((rows) => rows.length > 0).map((rows) => rows.slice(-SAMPLE));
  const [at, wall] = samples.reduce((a, b) => (b[0] > a[0] ? b : a), [0, 0]);
  if (at === 0 || Math.abs((wall - run.epochMs) / at - 1) > IN_STEP) return null;
  return run.epochMs + t;
}

const STEPS_MIN = [1, 2, 5, 10, 15, 20, 30, 60, 120, 240, 360, 720, 1440];

/** Round times, in milliseconds, for an axis from `from` to `to` with at most `most` marks. */
export function timeTicks(from, to, most) {
  const span = (to - from) / 60000;
  const step = (STEPS_MIN.find((m) => span / m <= most) ?? Math.ceil(span / most / 1440) * 1440) * 60000;
  const ticks = [];
  for (let t = Math.ceil(from / step) * step; t <= to; t += step) ticks.push(t);
  return ticks;
}

/** Index of the last row at or before `t` in rows of `stride` numbers that begin with a time; -1. */
export function rowAt(rows, stride, t) {
  let low = 0;
  let high = rows.length / stride;
  while (low < high) {
    const mid = (low + high) >> 1;
    if (rows[mid * stride] <= t) low = mid + 1;
    else high = mid;
  }
  return low - 1;
}
