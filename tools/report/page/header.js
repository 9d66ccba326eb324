import { numbersOf } from "./compare.js";
import { byId, duration, element, number, percent } from "./dom.js";
import { theme } from "./theme.js";

/** A figure of the header; `raw` is the number as report.json has it. */
function tile(key, label, text, raw, note) {
  return element("div", { class: "tile" },
    element("dt", {}, label),
    element("dd", { "data-key": key, "data-raw": raw === undefined ? null : String(raw) }, text),
    note ? element("dd", { class: "note" }, note) : null);
}

/** Which run this is and how it went. */
export class Header {
  constructor(state) {
    this.state = state;
    state.on("run data", () => this.draw());
    state.on("theme", () => this.draw());
  }

  draw() {
    const { run, runs } = this.state;
    if (!run) return;
    const n = numbersOf(run);
    byId("run-name").textContent = run.name;
    byId("run-name").dataset.key = "name";
    const s = run.scenario;
    byId("identity").replaceChildren(
      fact("Scenario", s.name, "scenario"),
      fact("Policy", n.policy, "policy"),
      fact("Seed", n.seed, "seed"),
      fact("Interval", `${s.interval_ms / 60000} min`, "interval"),
      fact("Agents", `${s.uavs} + ${s.workers} + ${s.vehicles}`, "agents",
        `${s.uavs} UAVs, ${s.workers} workers, ${s.vehicles} vehicles`),
      fact("Digest", n.digest ? n.digest.slice(0, 12) : "–", "digest", n.digest));
    byId("tabs").replaceChildren(...(runs.length < 2 ? [] : runs.map((other, i) =>
      element("button", {
        role: "tab", type: "button", "aria-selected": String(i === this.state.current),
        onclick: () => {
          this.state.current = i;
          this.state.select(null);
          this.state.emit("run");
        },
      }, element("i", { class: "swatch", style: `background:${theme.runs[i % theme.runs.length]}` }), other.name))));
    this.#drawFigures(n);
  }

  #drawFigures(n) {
    byId("figures").replaceChildren(
      element("div", { class: "tile lead" },
        element("dt", {}, n.live ? "Completion so far" : "Completion"),
        element("dd", { "data-key": "completion_rate", "data-raw": String(n.completion) }, percent(n.completion)),
        element("dd", { class: "bar", "aria-hidden": "true" },
          element("i", { style: `width:${Math.min(100, 100 * n.completion)}%` }))),
      tile("tasks_done", "Tasks done", `${number(n.tasksDone)} of ${number(n.tasksTotal)}`, n.tasksDone),
      tile("weight", "Total weight", number(n.weight, 1), n.weight, `${number(n.decisions)} decisions`),
      tile("charges", "Charges", number(n.charges), n.charges),
      tile("flown_m", "Flown", n.flownM === null ? "–" : `${number(n.flownM / 1000, 1)} km`, n.flownM ?? undefined),
      tile("median_s", "Decision time", duration(n.medianS), n.medianS, `at most ${duration(n.maxS)}`),
      tile("lost", "Bus losses", number(n.lost), n.lost, `${number(n.resent)} sent again`),
      tile("failed", "Agents failed", number(n.failed), n.failed),
      tile("log", "Log", n.live ? "recording" : n.complete ? "complete" : "incomplete",
        n.complete, n.messages === undefined ? null : `${number(n.messages)} messages`));
  }
}

function fact(label, value, key, title) {
  return element("span", { class: "fact", title }, element("small", {}, label),
    element("b", { "data-key": key, "data-raw": title && key === "digest" ? title : null }, String(value)));
}
