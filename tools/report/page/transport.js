import { SPEEDS } from "./clock.js";
import { fit, oncePerFrame } from "./canvas.js";
import { byId, element } from "./dom.js";
import { say } from "./language.js";
import { decisionAt, faultBands } from "./run.js";
import { clockText, timeText, wallTime } from "./time.js";
import { theme } from "./theme.js";

/** "+12 min", "+40 s": how much later it is now than the time that is shown. */
export const aheadText = (ms) => (ms < 60000 ? `+${Math.round(ms / 1000)} s` : `+${Math.round(ms / 60000)} min`);

/** The bar below: play, step, scrub, speed; decisions and faults marked along the time. */
export class Transport {
  constructor(state, clock) {
    this.state = state;
    this.clock = clock;
    this.scrub = byId("scrub");
    this.marks = byId("marks");
    this.drawMarks = oncePerFrame(() => this.#drawMarks());
    byId("play").addEventListener("click", () => clock.toggle());
    byId("previous").addEventListener("click", () => this.step(-1));
    byId("next").addEventListener("click", () => this.step(1));
    byId("live").addEventListener("click", () => clock.seek(clock.max, true));
    this.scrub.addEventListener("input", () => clock.seek(Number(this.scrub.value)));
    const speed = byId("speed");
    speed.append(...SPEEDS.map((s) => element("option", { value: s }, s < 60 ? `${s} s/s` : `${s / 60} min/s`)));
    speed.addEventListener("change", () => {
      clock.speed = Number(speed.value);
      speed.blur();
    });
    clock.subscribe(() => this.#show());
    state.on("run data", () => this.update());
    state.on("theme", this.drawMarks);
    new ResizeObserver(this.drawMarks).observe(this.marks);
  }

  /** Takes the run's length; a live clock that follows goes to its end. */
  update() {
    const { run, live } = this.state;
    if (!run) return;
    this.clock.max = live && !run.ended ? Math.max(1, run.nowMs) : run.limitMs;
    this.scrub.max = run.limitMs;
    this.scrub.step = 1000;
    byId("live").hidden = !live;
    byId("time-end").textContent = clockText(run.limitMs);
    this.clock.seek(this.clock.follow ? this.clock.max : this.clock.t, this.clock.follow);
    this.drawMarks();
  }

  /** To the next or previous decision. */
  step(direction) {
    const times = this.state.run.decisions.map((d) => d.t);
    const t = direction > 0 ? times.find((d) => d > this.clock.t + 1) ?? this.clock.max
      : times.findLast((d) => d < this.clock.t - 1) ?? 0;
    this.clock.pause();
    this.clock.seek(t);
  }

  #show() {
    const { run } = this.state;
    if (!run) return;
    const { t, playing, speed, follow } = this.clock;
    this.scrub.value = t;
    this.scrub.setAttribute("aria-valuetext", timeText(run, t));
    byId("time-now").textContent = clockText(t);
    byId("print-time").textContent = say("at {time}", { time: timeText(run, t) });
    const wall = wallTime(run, t);
    byId("time-wall").textContent = wall?.text ?? "";
    byId("time-wall").title = wall?.date ?? "";
    const decision = decisionAt(run, t);
    byId("decision-now").textContent = decision ? say("decision {index}", { index: decision.index }) : say("before the first decision");
    byId("play").setAttribute("aria-label", say(playing ? "Pause" : "Play"));
    byId("play").classList.toggle("playing", playing);
    byId("speed").value = speed;
    byId("live").setAttribute("aria-pressed", String(follow));
    byId("live").textContent = follow ? say("Live") : say("Back to live, {time}", { time: aheadText(this.clock.max - t) });
  }

  #drawMarks() {
    const { run } = this.state;
    const { context: c, width, height } = fit(this.marks);
    if (!run || width === 0) return;
    const x = (t) => 8 + (t / run.limitMs) * (width - 16);
    c.fillStyle = theme.muted;
    for (const decision of run.decisions) c.fillRect(x(decision.t) - 0.5, 0, 1, 5);
    c.fillStyle = theme.failed;
    for (const band of faultBands(run)) {
      const tall = band.kind === "agent" ? 6 : 5;
      c.globalAlpha = band.kind === "agent" ? 0.9 : 0.45;
      c.fillRect(x(band.from), height - tall, band.kind === "agent" ? 1.5 : Math.max(1.5, x(band.to) - x(band.from)), tall);
    }
    c.globalAlpha = 1;
  }
}
