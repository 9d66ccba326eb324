import { ChartTable } from "./chart_table.js";
import { numbersOf } from "./compare.js";
import { byId, duration, element, number, percent } from "./dom.js";
import { say } from "./language.js";
import { Plot } from "./plot.js";
import { busOverTime, decisionAt, doneAt, faultBands } from "./run.js";
import { clockText, rowAt, timeTicks } from "./time.js";
import { RUN_DASHES, theme } from "./theme.js";

/** Curves of one run: time in ms against numbers. */
function completion(run) {
  const t = [];
  const y = [];
  const total = Math.max(1, run.tasksTotal);
  for (let i = 0; i < run.done.length; i += 2) {
    t.push(run.done[i]);
    y.push((100 * run.done[i + 1]) / total);
  }
  if (t.length && run.nowMs > t[t.length - 1]) {
    t.push(run.nowMs);
    y.push(y[y.length - 1]);
  }
  return [{ t, y, stepped: true }];
}

function ofDecisions(run, get) {
  return { t: run.decisions.map((d) => d.t), y: run.decisions.map(get), points: true };
}

const policyOf = (run) => numbersOf(run).policy;

const CHARTS = [
  {
    id: "completion", title: say("Completion"), unit: "%", names: [say("% done")], digits: 1,
    curves: completion,
    now: (run, t) => `${say("{n} of {total}", { n: doneAt(run, t), total: run.tasksKnownAt(t) })}`
      + ` (${percent(doneAt(run, t) / Math.max(1, run.tasksKnownAt(t)))})`,
    range: () => [0, 100],
  },
  {
    id: "weight", title: say("Weight of each decision and its bound"), unit: "", own: true, names: [say("weight"), say("bound")], digits: 1,
    curves: (run) => [
      ofDecisions(run, (d) => d.weight),
      { ...ofDecisions(run, (d) => d.bound), points: false, thin: true },
    ],
    now: (run, t) => {
      const d = decisionAt(run, t);
      if (!d) return "–";
      return say(d.bound === null ? "{weight}, no bound proven" : "{weight} of at most {bound}", { weight: number(d.weight, 1), bound: number(d.bound, 1) });
    },
  },
  {
    id: "solve", title: say("Decision time"), unit: "ms", names: ["ms"], digits: 1,
    curves: (run) => [ofDecisions(run, (d) => d.solveUs / 1000)],
    now: (run, t) => {
      const d = decisionAt(run, t);
      return d ? say("{time}, {n} candidates", { time: duration(d.solveUs / 1e6), n: number(d.candidates) }) : "–";
    },
  },
  {
    id: "bus", title: say("Bus: messages lost and sent again"), unit: "", names: [say("lost"), say("sent again")], digits: 0,
    curves: (run) => {
      const bus = busOverTime(run);
      return [{ t: bus.t, y: bus.lost, stepped: true }, { t: bus.t, y: bus.resent, stepped: true, thin: true }];
    },
    now: (run, t) => {
      const bus = busOverTime(run);
      const i = rowAt(bus.t, 1, t);
      if (bus.t.length === 0) return say("nothing reported");
      return i < 0 ? "–" : say("{lost} lost, {resent} sent again", { lost: number(bus.lost[i]), resent: number(bus.resent[i]) });
    },
  },
];

/** The four curves over one time axis; click or drag sets the clock, dragging wide zooms. */
export class Charts {
  constructor(state, clock) {
    this.state = state;
    this.clock = clock;
    this.box = byId("charts");
    this.charts = CHARTS.map((chart) => this.#frame(chart));
    clock.subscribe(() => this.#moveCursor());
    state.on("run data axis theme", () => this.rebuild());
    state.on("view", () => this.#applyView());
    new ResizeObserver(() => {
      for (const { plot } of this.charts) plot.redraw();
      this.#moveCursor();
    }).observe(this.box);
  }

  #frame(chart) {
    const value = element("output", { class: "now", id: `now-${chart.id}` });
    const host = element("div", { class: "plot", id: `plot-${chart.id}` });
    const cursor = element("div", { class: "time-cursor" });
    const note = element("small", {}, chart.unit);
    const table = new ChartTable(chart.title[0].toLowerCase() + chart.title.slice(1), () => this.#table(chart));
    this.box.append(element("section", { class: "chart" }, element("h3", {}, chart.title, " ", note, value), host, table.node));
    const plot = new Plot(host, {
      xTicks: (range, pixels) => this.#ticks(range, pixels / 70),
      behind: (c, shown) => this.#drawBands(c, shown),
      onHover: (x) => this.charts.forEach((other) => other.plot.hover(x)),
      onDrag: (left, right) => this.charts.forEach((other) => other.plot.mark(left, right)),
      onClick: (x) => this.clock.seek(this.#time(x)),
      onSelect: (from, to) => this.state.setView([Math.max(0, this.#time(from)), Math.min(this.clock.max, this.#time(to))]),
      onReset: () => this.state.setView(null),
    });
    plot.over.append(cursor);
    return { ...chart, note, value, cursor, plot, table };
  }

  /** Time to the axis' unit: seconds, or decisions of that run. */
  #axis(run, t) {
    return this.state.byDecision ? t / run.intervalMs : t / 1000;
  }

  #time(value) {
    return this.state.byDecision ? value * this.state.run.intervalMs : value * 1000;
  }

  #xRange() {
    if (this.state.view) return this.state.view.map((t) => this.#axis(this.state.run, t));
    return [0, Math.max(...this.state.runs.map((run) => this.#axis(run, run.limitMs)))];
  }

  rebuild() {
    if (!this.state.run) return;
    for (const chart of this.charts) this.#build(chart);
    this.#moveCursor();
  }

  #build(chart) {
    const curves = [];
    let max = 0;
    const { run: current, runs } = this.state;
    runs.forEach((run, r) => {
      // What policies weigh differs: only runs of one policy share an axis.
      if (chart.own && policyOf(run) !== policyOf(current)) return;
      for (const curve of chart.curves(run)) {
        for (const y of curve.y) if (y > max) max = y;
        curves.push({
          x: curve.t.map((t) => this.#axis(run, t)),
          y: curve.y,
          stroke: theme.runs[r % theme.runs.length],
          width: r === this.state.current ? 2 : 1.3,
          dash: curve.thin ? [4, 4] : RUN_DASHES[r % RUN_DASHES.length],
          stepped: Boolean(curve.stepped),
          points: Boolean(curve.points) && curve.t.length < 80,
        });
      }
    });
    if (chart.own) chart.note.textContent = runs.some((run) => policyOf(run) !== policyOf(current)) ? ` ${say("{policy} only", { policy: policyOf(current) })}` : "";
    chart.plot.xRange = this.#xRange();
    chart.plot.show(curves, chart.range ? chart.range(max) : [0, max > 0 ? max * 1.1 : 1]);
    chart.table.update();
  }

  /** What the curves are at each time that one of them changes. */
  #table(chart) {
    const { run: current, runs } = this.state;
    const columns = runs.filter((run) => !chart.own || policyOf(run) === policyOf(current)).flatMap((run) => chart.curves(run)
      .map((curve, i) => ({ ...curve, name: runs.length > 1 ? `${run.name}: ${chart.names[i]}` : chart.names[i] })));
    const times = [...new Set(columns.flatMap(({ t }) => t))].sort((a, b) => a - b);
    const cell = ({ t, y, stepped }, at) => {
      const i = rowAt(t, 1, at);
      return i < 0 || (!stepped && t[i] !== at) ? "–" : number(y[i], chart.digits);
    };
    return { head: [say("time"), ...columns.map(({ name }) => name)], rows: times.map((at) => [at, ...columns.map((column) => cell(column, at))]) };
  }

  /** At most `most` round times or decisions, with their texts. */
  #ticks([from, to], most) {
    if (!this.state.byDecision) {
      return timeTicks(from * 1000, to * 1000, most).map((t) => [t / 1000, clockText(t, false)]);
    }
    const step = Math.max(1, Math.ceil((to - from) / most));
    const ticks = [];
    for (let d = Math.ceil(from); d <= to; d += step) ticks.push([d, String(d)]);
    return ticks;
  }

  #drawBands(c, { x, height }) {
    const { run } = this.state;
    if (!run) return;
    c.fillStyle = theme.failed;
    for (const band of faultBands(run)) {
      const from = x(this.#axis(run, band.from));
      const to = x(this.#axis(run, band.to));
      const one = band.kind === "agent"; // a tick when it happened
      c.globalAlpha = one ? 0.9 : 0.16;
      c.fillRect(one ? from - 0.75 : from, 0, one ? 1.5 : Math.max(2, to - from), one ? 6 : height);
    }
  }

  #applyView() {
    for (const { plot } of this.charts) {
      plot.xRange = this.#xRange();
      plot.hover(plot.hoverX);
      plot.redraw();
    }
    this.#moveCursor();
  }

  #moveCursor() {
    const { run } = this.state;
    if (!run) return;
    for (const chart of this.charts) {
      chart.value.textContent = chart.now(run, this.clock.t);
      const x = chart.plot.x(this.#axis(run, this.clock.t));
      chart.cursor.hidden = !(x >= 0 && x <= chart.plot.width);
      chart.cursor.style.transform = `translateX(${x}px)`;
    }
  }
}
