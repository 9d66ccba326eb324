/** "1:23:30" of milliseconds; "1:23" without seconds. */
export function clockText(ms, seconds = true) {
  const s = Math.max(0, Math.floor(ms / 1000));
  const two = (n) => String(n).padStart(2, "0");
  const hm = `${Math.floor(s / 3600)}:${two(Math.floor(s / 60) % 60)}`;
  return seconds ? `${hm}:${two(s % 60)}` : hm;
}

const IN_STEP = 0.02; // share by which a mission at rate 1 may differ from the wall's time
const SAMPLE = 10; // of a process: t_ms, wall_ms, ...

/**
 * The wall's time at t, { utc: "09:31:30 UTC", date }; null where mission time is not the wall's: a simulated mission, one
 * that ran faster or slower, or one that has only begun.
 */
export function wallTime(run, t) {
  if (!(run.epochMs > 0)) return null;
  const samples = [...run.processes.values()].filter((rows) => rows.length > 0).map((rows) => rows.slice(-SAMPLE));
  const [at, wall] = samples.reduce((a, b) => (b[0] > a[0] ? b : a), [0, 0]);
  if (at === 0 || Math.abs((wall - run.epochMs) / at - 1) > IN_STEP) return null;
  const iso = new Date(run.epochMs + t).toISOString();
  return { utc: `${iso.slice(11, 19)} UTC`, date: iso.slice(0, 10) };
}

/** "10:31:30 here" in this computer's zone. */
export const localTime = (run, t) => `${new Date(run.epochMs + t).toLocaleTimeString("en-GB")} here`;

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
