import { forecastAt } from "./attention.js";
import { figuresAt, numbersOf } from "./compare.js";
import { oncePerFrame } from "./canvas.js";
import { byId, duration, element, number, percent } from "./dom.js";
import { say } from "./language.js";
import { taskStatusAt } from "./run.js";
import { theme } from "./theme.js";
import { clockText, localTime } from "./time.js";
import { wallFigures } from "./wall.js";
import { OPEN } from "./words.js";

/** A figure; `raw` is the number as report.json has it. */
function tile(key, label, text, raw, note, title) {
  return element("div", { class: "tile", title },
    element("dt", {}, label),
    element("dd", { "data-key": key, "data-raw": raw === undefined ? null : String(raw) }, text),
    note ? element("dd", { class: "note" }, note) : null);
}

/** Which run this is, and how it goes at the clock's time. The header has what a commander needs, the engine room the rest. */
export class Header {
  constructor(state, clock, attention) {
    this.state = state;
    this.clock = clock;
    this.attention = attention;
    this.drawFigures = oncePerFrame(() => this.#drawFigures());
    state.on("run data theme", () => this.draw());
    state.on("attention", () => this.#drawMission());
    clock.subscribe(this.drawFigures);
  }

  draw() {
    const { run, runs } = this.state;
    if (!run) return;
    const n = numbersOf(run);
    byId("run-name").textContent = byId("run-name").title = run.name;
    byId("run-name").dataset.key = "name";
    const s = run.scenario;
    const [uavs, workers, vehicles] = run.crew;
    byId("identity").replaceChildren(
      fact(say("Scenario"), s.name, "scenario"),
      fact(say("Policy"), n.policy, "policy"),
      fact(say("Seed"), n.seed, "seed"),
      ...clockFacts(run, this.clock.t),
      fact(say("Interval"), `${s.interval_ms / 60000} min`, "interval"),
      fact(say("Agents"), `${uavs} + ${workers} + ${vehicles}`, "agents",
        say("{uavs} UAVs, {workers} workers, {vehicles} vehicles", { uavs, workers, vehicles })),
      fact(say("Digest"), n.digest ? n.digest.slice(0, 12) : "–", "digest", n.digest));
    byId("tabs").replaceChildren(...(runs.length < 2 ? [] : runs.map((other, i) =>
      element("button", {
        role: "tab", type: "button", "aria-selected": String(i === this.state.current), onclick: () => this.state.open(i),
      }, element("i", { class: "swatch", style: `background:${theme.runs[i % theme.runs.length]}` }), other.name))));
    this.drawFigures();
  }

  #drawFigures() {
    const { run } = this.state;
    if (!run) return;
    const n = figuresAt(run, this.clock.t);
    const local = byId("identity").querySelector('[data-key="local"]');
    if (local) local.textContent = clockWords(run, this.clock.t);
    this.figures = n;
    this.#drawMission();
    byId("machine").replaceChildren(
      tile("charges", say("Charges"), number(n.charges), n.charges, this.#inTheEnd(n, n.end.charges)),
      tile("flown_m", say("Flown"), `${number(n.flownM / 1000, 1)} km`, n.flownM),
      tile("weight", say("Total weight"), number(n.weight, 1), n.weight, say(n.decisions === 1 ? "{n} decision" : "{n} decisions", { n: number(n.decisions) })),
      tile("solve_s", say("Decision time"), duration(n.solveS), n.solveS, say("at most {time}", { time: duration(n.maxS) }),
        say("median {median}, at most {time}", { median: duration(n.medianS), time: duration(n.maxS) })),
      tile("lost", say("Bus losses"), number(n.lost), n.lost, n.resent > 0 ? say("{n} sent again", { n: number(n.resent) }) : null),
      tile("log", say("Log"), say(n.live ? "recording" : n.complete ? "complete" : "incomplete"),
        n.complete, n.messages === undefined ? null : say("{n} messages", { n: number(n.messages) })));
  }

  /** "6 in the end"; null at the end. */
  #inTheEnd(n, end) {
    return this.clock.t >= this.state.run.nowMs ? null : say(n.live ? "{n} by now" : "{n} in the end", { n: number(end) });
  }

  /** How many tasks nobody is sent to; counted once for each time. */
  #openAt(run, t) {
    const known = this.counted;
    if (known?.run !== run || known.t !== t || known.nowMs !== run.nowMs) {
      this.counted = { run, t, nowMs: run.nowMs, open: run.tasks.filter((task) => taskStatusAt(task, t) === OPEN).length };
    }
    return this.counted.open;
  }

  /** The four figures of the header. */
  #drawMission() {
    const { run } = this.state;
    const n = this.figures;
    if (!run || !n) return;
    const { t } = this.clock;
    const { risk, isOver } = wallFigures(run, t, this.attention.all);
    const open = this.#openAt(run, t);
    const tasks = tile("tasks_done", say("Tasks done"), say("{n} of {total}", { n: number(n.tasksDone), total: number(n.tasksTotal) }), n.tasksDone);
    tasks.classList.add("lead");
    tasks.append(
      element("dd", { class: "note", "data-key": "completion_rate", "data-raw": String(n.completion) }, n.tasksTotal > 0 ? percent(n.completion) : "–"),
      element("dd", { class: "bar", "aria-hidden": "true" }, element("i", { style: `width:${Math.min(100, 100 * n.completion)}%` })));
    const failed = tile("failed", say("Agents failed"), number(n.failed), n.failed, this.#inTheEnd(n, n.end.failed));
    const late = tile("risk", say(isOver ? "Not done" : "At risk"), number(risk), risk, isOver ? null : say("{n} open", { n: number(open) }));
    failed.classList.toggle("loud", n.failed > 0);
    late.classList.toggle("loud", risk > 0);
    byId("figures").replaceChildren(tasks, failed, late, this.#forecast(run, n, t));
  }

  /** How many tasks will be done; when the mission is over, when that was. */
  #forecast(run, n, t) {
    if (t >= run.nowMs && run.ended) return tile("forecast", say("Mission over"), clockText(run.nowMs), run.nowMs);
    if (t < 3 * run.intervalMs) return tile("forecast", say("Forecast"), "–", undefined, this.#inTheEnd(n, n.end.tasksDone), say("There is none before three decisions."));
    const { done, total } = forecastAt(run, t);
    return tile("forecast", say("Forecast"), say("{n} of {total}", { n: number(done), total: number(total) }), done, this.#inTheEnd(n, n.end.tasksDone),
      say("Tasks done by the end, at the rate of the last three decisions"));
  }
}

/** When the mission began, on the scenario's clocks, and what they show; nothing where it has no start. */
function clockFacts(run, t) {
  const at = localTime(run, 0);
  return at ? [fact(say("Start"), `${at.date} ${at.time.replace(/:00$/, "")} ${at.zone}`, "start", at.utc), fact(say("Local"), clockWords(run, t), "local")] : [];
}

function clockWords(run, t) {
  const { time, zone, utc } = localTime(run, t);
  return zone === "UTC" ? `${time} UTC` : `${time}, ${utc}`;
}

function fact(label, value, key, title) {
  return element("span", { class: "fact", title }, element("small", {}, label),
    element("b", { "data-key": key, "data-raw": title && key === "digest" ? title : null }, String(value)));
}
