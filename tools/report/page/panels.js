import { AirView } from "./air_view.js";
import { firstDifference, numbersOf, responseMs } from "./compare.js";
import { byId, bytes, duration, element, number, percent } from "./dom.js";
import { say, sayParts } from "./language.js";
import { pointName, taskName } from "./names.js";
import { KIND_NAMES, actionsOf, decidingMs, decisionAt, doneAt, statusAt, who } from "./run.js";
import { flownAt, waitedMs } from "./story.js";
import { cells, table } from "./table.js";
import { TaskTable } from "./tasks.js";
import { clockText, rowAt } from "./time.js";
import { theme } from "./theme.js";
import { OFFLINE } from "./words.js";

const MOST_ROWS = 150;
const countId = (status) => `count-${status.replace(" ", "-")}`;
const MOST_EVENTS = 3000;

/** Rows of the events' table: what every process says of one fault is one row, which tells the fault's kind. */
export function eventRows(run) {
  const rows = [];
  const faults = new Map();
  for (const e of run.events) {
    if (["agent_online", "agent_offline", "sensing_started", "charging_started"].includes(e.kind)) continue;
    const isFault = e.kind === "fault_applied" || e.kind === "fault_ended";
    const same = isFault ? faults.get(`${e.kind} ${e.fault}`) : null;
    if (same) {
      ++same.processes;
      continue;
    }
    const row = { ...e, processes: 1, what: say(e.kind.replaceAll("_", " ")) };
    if (isFault) {
      const fault = run.faults.find((other) => other.id === e.fault);
      const what = fault && { fault: say(fault.kind.replaceAll("_", " ")) };
      if (fault) Object.assign(row, { what: say(e.kind === "fault_ended" ? "{fault} ended" : "{fault} applied", what), target: fault.target });
      faults.set(`${e.kind} ${e.fault}`, row);
    }
    rows.push(row);
  }
  return rows;
}

/** What the tabs beside the timeline show: tasks, decision, events, processes, orders; and the comparison. */
export class Panels {
  constructor(state, clock, control) {
    this.state = state;
    this.clock = clock;
    this.control = control;
    this.body = byId("panel-body");
    this.tab = "tasks";
    this.tasks = new TaskTable(state, clock);
    this.air = new AirView(state, clock);
    for (const button of document.querySelectorAll("#panel-tabs button")) {
      button.addEventListener("click", () => this.open(button.dataset.tab));
    }
    clock.subscribe(() => this.#onTime());
    state.on("run data selection orders", () => this.draw());
    state.on("run data", () => this.#drawComparison());
  }

  open(tab) {
    this.tab = tab;
    for (const button of document.querySelectorAll("#panel-tabs button")) {
      button.setAttribute("aria-selected", String(button.dataset.tab === tab));
    }
    byId("engine").hidden = tab !== "engine";
    this.body.hidden = tab === "engine";
    this.draw();
  }

  /** The same, in view. */
  show(tab) {
    this.open(tab);
    byId("detail-panel").scrollIntoView({ block: "nearest" });
  }

  /** Events that are still to come at the clock's time are pale; the newest one is in view. */
  #markPast() {
    if (this.tab !== "events" || !this.eventRows) return;
    const { rows, times } = this.eventRows;
    const past = rowAt(times, 1, this.clock.t) + 1;
    if (past === this.eventRows.past) return;
    this.eventRows.past = past;
    rows.forEach((row, i) => row.classList.toggle("later", i >= past));
    const newest = rows[Math.max(0, past - 1)];
    const top = newest.getBoundingClientRect().top - this.body.getBoundingClientRect().top + this.body.scrollTop;
    if (top < this.body.scrollTop || top > this.body.scrollTop + this.body.clientHeight - 40) {
      this.body.scrollTop = top - this.body.clientHeight / 2;
    }
  }

  #onTime() {
    const decision = this.state.run && decisionAt(this.state.run, this.clock.t);
    if (this.tab === "decision" && decision !== this.shownDecision) this.draw();
    if (this.tab === "air") this.draw();
    this.#markPast();
  }

  /** The task table with one of its filters. */
  showTasks(filter) {
    this.open("tasks");
    this.tasks.show(filter);
    byId("detail-panel").scrollIntoView({ block: "nearest" });
    byId("task-filter").focus({ preventScroll: true });
  }

  draw() {
    const { run } = this.state;
    if (!run) return;
    const now = decisionAt(run, this.clock.t);
    byId("tab-air").hidden = !run.scenario.air?.separation;
    // A live page learns something four times a second: what would look the same stays as it is.
    const shown = { run, tab: this.tab, now: this.tab === "decision" && now, events: this.tab === "events" && run.events.length,
      orders: this.tab === "orders" && JSON.stringify(this.control.orders.list),
      air: this.tab === "air" && `${Math.floor(this.clock.t / 1000)} ${run.nowMs} ${run.ended}`,
      news: this.tab === "processes" && `${run.nowMs} ${run.ended}` };
    if (this.shown && Object.keys(shown).every((key) => shown[key] === this.shown[key])) return;
    this.shown = shown;
    const draw = { tasks: () => [this.tasks.root], decision: () => this.#decision(run), events: () => this.#events(run),
      processes: () => this.#processes(run), air: () => [this.air.root], orders: () => this.control.table(),
      engine: () => [] };
    const lasting = { tasks: this.tasks, air: this.air }[this.tab];
    if (!lasting?.visible) this.body.replaceChildren(...draw[this.tab]());
    lasting?.draw();
  }

  #decision(run) {
    const decision = decisionAt(run, this.clock.t);
    this.shownDecision = decision;
    if (!decision) return [element("p", { class: "empty" }, say("Before the first decision."))];
    const below = 1 - decision.weight / decision.bound;
    const gap = !(decision.bound > 0) ? "" : below < 1e-9 ? ` ${say("(reached: optimal)")}` : ` ${say("({n} % below it)", { n: number(100 * below, 2) })}`;
    const head = [say("what"), say("who"), say("where"), `#${say("weight")}`];
    const actions = actionsOf(run, decision).filter((a) => a.kind > 2).sort((a, b) => b.weight - a.weight);
    const staying = decision.actions.length / 9 - actions.length;
    const rows = actions.slice(0, MOST_ROWS).map((a) =>
      element("tr", { tabindex: 0, onclick: () => this.#selectAction(run, a), onkeydown: (e) => e.key === "Enter" && this.#selectAction(run, a) },
        ...cells([element("span", { title: a.symbol }, a.name), who(a), a.task >= 0 ? taskName(a.task) : a.charge >= 0 ? pointName(a.charge) : `${number(a.x / 1000, 1)}, ${number(a.y / 1000, 1)} km`, number(a.weight, 3)], head)));
    return [
      element("p", { class: "lead" }, ...sayParts("{decision} at {time}, {policy}", {
        decision: element("b", {}, say("Decision {index}", { index: decision.index })), time: clockText(decision.t), policy: decision.policy })),
      element("dl", { class: "pairs" },
        element("dt", {}, say("weight")), element("dd", { "data-key": "decision_weight", "data-raw": String(decision.weight) }, number(decision.weight, 3)),
        element("dt", {}, say("bound")), element("dd", {}, decision.bound === null ? say("none proven") : `${number(decision.bound, 3)}${gap}`),
        element("dt", {}, say("candidates")), element("dd", {}, number(decision.candidates)),
        element("dt", {}, say("solved in")), element("dd", {}, duration(decision.solveUs / 1e6)),
        element("dt", {}, say("sent")), element("dd", {}, say("{n} actions, {staying} stay", { n: number(actions.length), staying: number(staying) }))),
      table(head, rows),
      ...(actions.length > MOST_ROWS ? [element("p", { class: "empty" }, say("{n} more of lower weight", { n: actions.length - MOST_ROWS }))] : []),
    ];
  }

  #selectAction(run, action) {
    const kind = action.uav >= 0 ? 0 : action.worker >= 0 ? 1 : 2;
    const id = [action.uav, action.worker, action.vehicle][kind];
    if (id >= 0) this.state.flyTo({ type: "agent", index: run.agentIndex(kind, id) });
  }

  #events(run) {
    const notable = eventRows(run);
    if (notable.length === 0) return [element("p", { class: "empty" }, say("Nothing happened yet."))];
    const head = [say("time"), say("what"), say("who"), say("where, which")];
    const worst = (e) => e.kind.includes("fail") || e.kind.includes("lost") || e.kind.includes("fault") || e.kind.includes("aborted");
    const shown = notable.slice(0, MOST_EVENTS);
    const rows = shown.map((e) =>
      element("tr", { class: worst(e) ? "bad" : null, tabindex: 0, onclick: () => this.clock.seek(e.t), onkeydown: (k) => k.key === "Enter" && this.clock.seek(e.t) },
        ...cells([clockText(e.t), e.what, who(e),
          [e.target, e.processes > 1 ? say("at {n} processes", { n: e.processes }) : "", e.task >= 0 ? taskName(e.task) : "", e.charge >= 0 ? pointName(e.charge) : "", e.fault, e.detail].filter(Boolean).join(" ")], head)));
    this.eventRows = { rows, times: shown.map((e) => e.t), past: -1 };
    requestAnimationFrame(() => this.#markPast());
    return [table(head, rows), ...(notable.length > shown.length ? [element("p", { class: "empty" }, say("{n} later ones", { n: notable.length - shown.length }))] : [])];
  }

  #processes(run) {
    const head = [say("process"), say("state"), `#${say("received")}`, `#${say("lost")}`,
      `#${say("rejected")}`, `#${say("sent again")}`, `#${say("restarts")}`, `#${say("CPU")}`, `#${say("memory")}`];
    const list = run.report && (run.ended || !this.state.live) ? run.report.processes : latestProcesses(run);
    return [table(head, list.map((p) => element("tr", {}, ...cells([p.name, say(p.state ?? (p.ended ? "ended" : "–")), number(p.received), number(p.lost), number(p.rejected),
      number(p.resent), p.restarts, p.cpu_s > 0 ? duration(p.cpu_s) : "–", p.rss_bytes > 0 ? bytes(p.rss_bytes) : "–"], head))))];
  }

  #drawComparison() {
    const { runs } = this.state;
    byId("comparison").hidden = runs.length < 2;
    if (runs.length < 2) return;
    const head = [say("run"), say("policy"), `#${say("completion")}`, `#${say("tasks done")}`, `#${say("mean response")}`,
      `#${say("waiting")}`, `#${say("charges")}`, `#${say("flown")}`, `#${say("decision time")}`, say("first difference"), say("digest")];
    const rows = runs.map((run, r) => {
      const n = numbersOf(run);
      return element("tr", {}, ...cells([
        element("span", {}, element("i", { class: "swatch", style: `background:${theme.runs[r % 6]}` }), run.name),
        n.policy, percent(n.completion), number(n.tasksDone), clockText(responseMs(run)), `${number(waitedMs(run, run.nowMs) / 3600000, 1)} h`, number(n.charges),
        `${number(n.flownM / 1000, 1)} km`, duration(n.medianS),
        r === 0 ? "–" : firstDifference(runs[0], run), n.digest?.slice(0, 12) ?? "–"], head));
    });
    const each = [`#${say("decision")}`, `#${say("time")}`, ...runs.flatMap(({ name: run }) =>
      [`#${say("done {run}", { run })}`, `#${say("waited {run}", { run })}`, `#${say("flown {run}", { run })}`])];
    const most = Math.max(...runs.map((run) => run.decisions.length));
    const perDecision = [];
    for (let i = 0; i < most; ++i) {
      const t = runs.find((run) => run.decisions[i])?.decisions[i].t;
      const go = () => this.clock.seek(t);
      perDecision.push(element("tr", { tabindex: 0, onclick: go, onkeydown: (e) => e.key === "Enter" && go() },
        ...cells([i, clockText(t), ...runs.flatMap((run) => {
          const d = run.decisions[i];
          return d ? [number(doneAt(run, d.t)), `${number(waitedMs(run, d.t) / 3600000, 1)} h`, `${number(flownAt(run, d.t) / 1000)} km`] : ["–", "–", "–"];
        })], each)));
    }
    byId("comparison-body").replaceChildren(
      element("div", { class: "wide", tabindex: 0 }, table(head, rows)),
      element("details", {}, element("summary", {}, say("Decision by decision")), element("div", { class: "wide tall", tabindex: 0 }, table(each, perDecision))));
  }
}

/** The newest counters of each process of a live run. */
function latestProcesses(run) {
  return [...run.processes].map(([name, rows]) => {
    const [, , start, received, lost, rejected, resent, cpu, rss, state] = rows.slice(-10);
    const ms = decidingMs(rows);
    const word = say(run.words.processes[state]);
    return { name, state: ms > 0 ? say("{state} for {n} s", { state: word, n: number(ms / 1000, 1) }) : word, received, lost, rejected, resent, restarts: start, cpu_s: cpu, rss_bytes: rss };
  });
}

/** Class filters with counts by status; the legend of map and timeline at once. */
export class Legend {
  constructor(state, clock) {
    this.state = state;
    this.clock = clock;
    this.buttons = KIND_NAMES.map((name, kind) => {
      const count = element("b", {});
      const button = element("button", { type: "button", class: `kind k${kind}`, "aria-pressed": "true", title: say("Show or hide {kind} (key {key})", { kind: name, key: kind + 1 }),
        onclick: () => state.toggleClass(kind) }, element("i", { class: `shape s${kind}` }), name, count);
      return { button, count };
    });
    byId("classes").append(...this.buttons.map((b) => b.button));
    clock.subscribe(() => this.draw());
    state.on("run data classes filter", () => this.draw());
  }

  draw() {
    const { run, classes } = this.state;
    if (!run) return;
    const shown = [0, 0, 0];
    const { statuses } = run.words;
    if (!byId("statuses").hasChildNodes()) {
      byId("statuses").append(...statuses.slice(1).map((name, i) => element("span", { class: "status" }, element("i", { class: `st${i + 1}` }), say(name), " ", element("b", { id: countId(name) }))));
    }
    const byStatus = new Array(statuses.length).fill(0);
    for (const agent of run.agents) {
      if (!classes[agent.kind]) continue;
      const status = statusAt(agent, this.clock.t);
      if (status === OFFLINE) continue;
      ++shown[agent.kind];
      if (this.state.finds(agent)) ++byStatus[status];
    }
    const total = run.crew;
    this.buttons.forEach(({ button, count }, kind) => {
      button.setAttribute("aria-pressed", String(classes[kind]));
      count.textContent = ` ${classes[kind] ? `${shown[kind]}/${total[kind]}` : say("hidden")}`;
    });
    statuses.forEach((name, i) => {
      if (i > 0) byId(countId(name)).textContent = byStatus[i];
    });
  }
}
