import { taskText } from "./attention.js";
import { ChartTable } from "./chart_table.js";
import { isSameScenario } from "./compare.js";
import { byId, element, isolated, number } from "./dom.js";
import { fill, say, sayParts } from "./language.js";
import { Plot } from "./plot.js";
import { PARTS, rivalry } from "./rivalry.js";
import { theme } from "./theme.js";
import { clockText, rowAt, timeTicks } from "./time.js";
import { MOST as NEAREST } from "./zoom.js";

const MOST_PARTS = 4;
const MOST_TASKS = 12; // that only one run did, of each
const MOST_CHANGES = 6;
const SEEN = 0.8; // how much of the map a part takes that is flown to

/** Of several runs: the name of each, with its place where another one has the same name. */
function nameOfRun(runs, i) {
  const { name } = runs[i];
  return isolated(runs.filter((run) => run.name === name).length > 1 ? `${name} (${i + 1})` : name);
}

/** In the comparison: the story of the open run against another one, and the lead over time. */
export class RivalryView {
  constructor(state, clock, map) {
    this.state = state;
    this.clock = clock;
    this.map = map;
    this.choice = byId("rival");
    this.choice.addEventListener("change", () => state.setRival(Number(this.choice.value)));
    this.#makeChart();
    clock.subscribe(() => this.#moveCursor());
    state.on("run", () => this.#offer());
    state.on("differ", () => { if (state.other !== null) state.setRival(state.other); });
    state.on("run data rival", () => this.#show());
    state.on("view", () => this.#drawChart());
    state.on("theme", () => this.#drawChart());
    new ResizeObserver(() => {
      this.plot.redraw();
      this.#moveCursor();
    }).observe(byId("rivalry-chart"));
  }

  /** The other runs; the first one of the same scenario is chosen. */
  #offer() {
    const { run, runs, current } = this.state;
    const others = runs.map((_, i) => i).filter((i) => i !== current);
    byId("rivalry").hidden = others.length === 0;
    this.choice.replaceChildren(...others.map((i) => element("option", { value: i }, nameOfRun(runs, i))));
    this.state.usualRival = others.find((i) => isSameScenario(run, runs[i])) ?? others[0] ?? null;
    this.state.setRival(this.state.usualRival);
  }

  #show() {
    const { run, runs, current, rival, rivalRun } = this.state;
    if (!run || !rivalRun) return;
    this.choice.value = String(rival);
    const found = rivalry(run, rivalRun);
    if (found === this.found && found !== null) return;
    this.found = found;
    this.names = [nameOfRun(runs, current), nameOfRun(runs, rival)];
    byId("rivalry-chart").hidden = found === null || found.isAlike;
    byId("rivalry-body").replaceChildren(...(found ? this.#story(found) : [
      element("p", { class: "empty" }, say("{run} is of another scenario or has another time limit: there is nothing to compare step by step.", { run: this.names[1] }))]));
    this.#drawChart();
  }

  /** A time that takes the clock there, and the map to what it is about. */
  #time(t, item = null) {
    return element("button", { type: "button", class: "name", onclick: () => this.#go(t, item) }, clockText(t));
  }

  #go(t, item = null) {
    this.clock.pause();
    this.clock.seek(t);
    if (item) this.#fly(item);
  }

  /** Takes the map there, and brings the map into view: the comparison is far below it. */
  #fly(item) {
    this.state.flyTo(item);
    byId("map-panel").scrollIntoView({ block: "nearest" });
  }

  #story(found) {
    if (found.isAlike) return [element("p", {}, say("Both runs commanded the same and did the same tasks at the same times."))];
    const lines = [...this.#verdict(found), ...this.#decision(found), ...this.#lead(found), ...this.#parts(found), ...this.#by(found)];
    return [element("ol", { class: "story" }, ...lines.map((parts) => element("li", {}, ...parts))), ...this.#only(found)];
  }

  /** Who won, by how much. */
  #verdict({ until, ended, done, total, byDone, ends, worth, byWorth, isOpen, took }) {
    const [run, other] = this.names;
    const time = this.#time(until);
    const lines = [];
    if (byDone === null) {
      const text = say(!ended ? "So far, until {time}, it is undecided: tasks done in each: {n}." : byWorth === null
        ? "Undecided: at the end, {time}, both have done {n} tasks." : "At the end, {time}, both have done {n} tasks.");
      lines.push(sayParts(text, { time, n: number(done[0]) }));
    } else {
      const values = { time, run: this.names[byDone], other: this.names[1 - byDone], a: number(done[byDone]), b: number(done[1 - byDone]),
        total: number(total[byDone]), others: number(total[1 - byDone]), n: number(Math.abs(done[0] - done[1])) };
      lines.push(!ended ? sayParts("So far, until {time}, {run} is ahead by {n}: it has done {a} of {total} tasks, {other} {b} of {others}.", values)
        : isOpen ? sayParts("{run} did more tasks, by {n}: at the end, {time}, it has done {a} of {total}, {other} {b} of {others}.", values)
        : sayParts("{run} won by {n}: at the end, {time}, it has done {a} of {total} tasks, {other} {b} of {others}.", values));
    }
    if (ends) lines.push(sayParts("{run} ended at {a}, {other} at {b}.", { run, other, a: this.#time(ends[0]), b: this.#time(ends[1]) }));
    if (worth && byWorth === null) lines.push([say("Counted by priority and time, what both did is worth the same: {a}.", { a: number(worth[0], 1) })]);
    else if (worth) {
      const text = say(isOpen ? "Counted by priority and time, {run} did more: worth {a} against {b}. So it is open which one did better."
        : "Counted by priority and time, {run} did more: worth {a} against {b}.");
      lines.push([fill(text, {
        run: this.names[byWorth], a: number(worth[byWorth], 1), b: number(worth[1 - byWorth], 1) })]);
    }
    const texts = took.map((ms) => clockText(ms));
    if (took.every(Number.isFinite) && texts[0] !== texts[1]) {
      const quick = took[0] < took[1] ? 0 : 1;
      const text = say(this.state.run.timed ? "{run} was quicker: on average a task was done {a} after its report, in {other} {b}."
        : "{run} was quicker: on average a task was done {a} after the mission's start, in {other} {b}.");
      lines.push([fill(text, {
        run: this.names[quick], other: this.names[1 - quick], a: texts[quick], b: texts[1 - quick] })]);
    }
    return lines;
  }

  #decision({ decision }) {
    if (!decision) return [[say("No decision commanded anybody otherwise.")]];
    const { index, t, agents } = decision;
    const time = element("button", { type: "button", class: "name", onclick: () => {
      this.#go(t, agents.length === 1 ? { type: "agent", index: agents[0].index } : null);
      this.state.differFrom(this.state.rival);
    } }, clockText(t));
    return [sayParts("The first decision that differs is decision {index} at {time}. Agents commanded otherwise: {n}.", { index, time, n: number(agents.length) })];
  }

  #lead({ changes, most, since, byDone }) {
    const lines = [];
    if (byDone !== null && since !== null) {
      lines.push(sayParts("{run} is ahead for good from {time}.", { run: this.names[byDone], time: this.#time(since) }));
    }
    for (const of of byDone === 1 ? [1, 0] : [0, 1]) {
      if (!most[of]) continue;
      lines.push(sayParts("The largest lead of {run}, in tasks done: {n}, at {time}.", {
        run: this.names[of], n: number(most[of].n), time: this.#time(most[of].t) }));
    }
    if (changes.length > 0) {
      const shown = changes.slice(-MOST_CHANGES).flatMap(({ t, of }, i) => [i > 0 ? ", " : "",
        ...sayParts("{time} to {run}", { time: this.#time(t), run: this.names[of] })]);
      const list = element("span", {}, ...shown);
      lines.push(sayParts(changes.length > MOST_CHANGES ? "The lead changed {n} times, last: {list}." : "The lead changed: {list}.", {
        n: number(changes.length), list }));
    }
    return lines;
  }

  #parts({ parts }) {
    return parts.slice(0, MOST_PARTS).map(({ part, done, more, since, box }) => {
      const of = more > 0 ? 0 : 1;
      const { width_m: w, height_m: h } = this.state.run.scenario;
      const zoom = Math.min(NEAREST, Math.max(1, SEEN * Math.min(w / Math.max(box.wide, 1), h / Math.max(box.high, 1))));
      const go = (t) => {
        this.#go(t);
        this.state.look("map");
        this.map.goTo(box, zoom);
        byId("map-panel").scrollIntoView({ block: "nearest" });
      };
      return sayParts("{part} {run} is ahead by {n}, for good from {time}. Tasks done: {a} against {b}.", {
        part: PARTS[part], run: this.names[of], time: element("button", { type: "button", class: "name", onclick: () => go(since) }, clockText(since)),
        n: number(Math.abs(more)), a: number(done[of]), b: number(done[1 - of]) });
    });
  }

  /** What else differs, as far as it shows in the numbers told. */
  #by({ by, failures }) {
    const lines = [];
    const tell = (pair, words, text, time = () => null) => {
      const texts = pair.map(words);
      if (!pair.every(Number.isFinite) || texts[0] === texts[1]) return;
      const of = pair[0] > pair[1] ? 0 : 1;
      lines.push(sayParts(text, { run: this.names[of], a: texts[of], b: texts[1 - of], time: time(of) }));
    };
    tell(by.flownM, (m) => number(m / 1000, 1), say("{run} flew further: {a} km against {b} km."));
    tell(by.charges, (n) => number(n), say("{run} charged more often. Charges: {a} against {b}."));
    tell(by.failed, (n) => number(n), say("In {run} more agents failed: {a} against {b}, the first at {time}."), (of) => this.#failure(failures[of]));
    tell(by.waitedMs, (ms) => number(ms / 3600000, 1), say("In {run} agents waited longer for each other: {a} h in all against {b} h."));
    return lines;
  }

  #failure(event) {
    if (!event) return "–";
    const { run } = this.state;
    const kind = [event.uav, event.worker, event.vehicle].findIndex((id) => id >= 0);
    const index = kind < 0 ? -1 : run.agentIndex(kind, [event.uav, event.worker, event.vehicle][kind]);
    return this.#time(event.t, run.agents[index] ? { type: "agent", index } : null);
  }

  /** Tasks that only one of them did, and why the other one did not. */
  #only({ only, better }) {
    return (better === 1 ? [1, 0] : [0, 1]).map((of) => [only[of], of]).flatMap(([tasks, of]) => (tasks.length === 0 ? [] : [
      element("h4", {}, say("Done only in {run}: {n}", { run: this.names[of], n: number(tasks.length) })),
      element("ul", { class: "story" }, ...tasks.slice(0, MOST_TASKS).map(({ task, t, why }) => element("li", {}, ...sayParts("{task} at {time}; {other}: {why}", {
        task: this.#task(task), time: this.#time(t, this.#itemOf(task.id)), other: this.names[1 - of], why })))),
      tasks.length > MOST_TASKS ? element("p", { class: "hint" }, say("and {n} more", { n: number(tasks.length - MOST_TASKS) })) : "",
    ]));
  }

  /** A task as the open run has it; null: it has none of that number. */
  #itemOf(id) {
    const task = this.state.run.tasks[id];
    return task && !task.vacant ? { type: "task", id } : null;
  }

  #task(task) {
    const item = this.#itemOf(task.id);
    return item ? element("button", { type: "button", class: "name", onclick: () => this.#fly(item) }, taskText(task)) : taskText(task);
  }

  #makeChart() {
    this.now = element("output", { class: "now" });
    this.title = element("h3", {});
    const host = element("div", { class: "plot", id: "plot-lead" });
    this.cursor = element("div", { class: "time-cursor" });
    this.table = new ChartTable(say("lead in tasks done"), () => this.#rows());
    byId("rivalry-chart").append(this.title, host, this.table.node);
    const { state, clock } = this;
    this.plot = new Plot(host, {
      xTicks: ([from, to], pixels) => timeTicks(from * 1000, to * 1000, pixels / 70).map((t) => [t / 1000, clockText(t, false)]),
      behind: (c, { y, width }) => {
        c.strokeStyle = theme.muted;
        c.lineWidth = 1.5;
        c.strokeRect(-1, y(0), width + 2, 0);
      },
      onHover: (x) => this.plot.hover(x),
      onDrag: (left, right) => this.plot.mark(left, right),
      onClick: (x) => clock.seek(x * 1000),
      onSelect: (from, to) => state.setView([Math.max(0, from * 1000), Math.min(clock.max, to * 1000)]),
      onReset: () => state.setView(null),
    });
    this.plot.over.append(this.cursor);
  }

  #rows() {
    const { t, n } = this.found.lead;
    return { head: [say("time"), say("lead of {run}", { run: this.names[0] })], rows: t.map((at, i) => [at, number(n[i])]) };
  }

  /** Tasks done here less those done there: above the line the open run is ahead. */
  #drawChart() {
    if (!this.found || this.found.isAlike) return;
    const { t, n } = this.found.lead;
    const most = 1.1 * Math.max(1, ...n.map(Math.abs));
    this.title.replaceChildren(say("Lead in tasks done"), " ",
      element("small", {}, say("above the line {run} is ahead, below it {other}", { run: this.names[0], other: this.names[1] })), this.now);
    this.plot.xRange = this.state.viewRange.map((at) => at / 1000);
    const stroke = theme.runs[this.state.current % theme.runs.length];
    this.plot.show([{ x: t.map((at) => at / 1000), y: n, stroke, width: 2, dash: [], stepped: true }], [-most, most]);
    this.table.update();
    this.#moveCursor();
  }

  #moveCursor() {
    if (!this.found || this.found.isAlike) return;
    const { t, n } = this.found.lead;
    const lead = n[Math.max(0, rowAt(t, 1, this.clock.t))];
    this.now.textContent = lead === 0 ? say("nobody is ahead") : say("{run} is ahead by {n}", { run: this.names[lead > 0 ? 0 : 1], n: number(Math.abs(lead)) });
    const x = this.plot.x(this.clock.t / 1000);
    this.cursor.hidden = !(x >= 0 && x <= this.plot.width);
    this.cursor.style.transform = `translateX(${x}px)`;
  }
}
