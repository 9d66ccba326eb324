import uPlot from "uplot";
import { byId, duration, element, number, percent } from "./dom.js";
import { busOverTime, decisionAt, doneAt, faultBands } from "./run.js";
import { clockText, rowAt, timeTicks } from "./time.js";
import { RUN_DASHES, theme } from "./theme.js";

const SYNC = "muster";
const HEIGHT = 124;

/** Curves of one run: time in ms against numbers. */
function completion(run) {
  const t = [];
  const y = [];
  const total = Math.max(1, run.tasks.length);
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

const CHARTS = [
  {
    id: "completion", title: "Completion", unit: "%",
    curves: completion,
    now: (run, t) => `${doneAt(run, t)} of ${run.tasks.length} (${percent(doneAt(run, t) / Math.max(1, run.tasks.length))})`,
    range: (max) => [0, Math.min(100, max * 1.08 + 1)],
  },
  {
    id: "weight", title: "Weight of each decision and its bound", unit: "",
    curves: (run) => [
      ofDecisions(run, (d) => d.weight),
      { ...ofDecisions(run, (d) => d.bound), points: false, thin: true },
    ],
    now: (run, t) => {
      const d = decisionAt(run, t);
      if (!d) return "–";
      return d.bound === null ? `${number(d.weight, 1)}, no bound proven`
        : `${number(d.weight, 1)} of at most ${number(d.bound, 1)}`;
    },
  },
  {
    id: "solve", title: "Decision time", unit: "ms",
    curves: (run) => [ofDecisions(run, (d) => d.solveUs / 1000)],
    now: (run, t) => {
      const d = decisionAt(run, t);
      return d ? `${duration(d.solveUs / 1e6)}, ${number(d.candidates)} candidates` : "–";
    },
  },
  {
    id: "bus", title: "Bus: messages lost and sent again", unit: "",
    curves: (run) => {
      const bus = busOverTime(run);
      return [{ t: bus.t, y: bus.lost, stepped: true }, { t: bus.t, y: bus.resent, stepped: true, thin: true }];
    },
    now: (run, t) => {
      const bus = busOverTime(run);
      const i = rowAt(bus.t, 1, t);
      if (bus.t.length === 0) return "nothing reported";
      return i < 0 ? "–" : `${number(bus.lost[i])} lost, ${number(bus.resent[i])} sent again`;
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
    let width = 0;
    new ResizeObserver(() => {
      if (this.box.clientWidth === width) return;
      width = this.box.clientWidth;
      for (const chart of this.charts) chart.plot?.setSize({ width: chart.host.clientWidth, height: HEIGHT });
      this.#moveCursor();
    }).observe(this.box);
  }

  #frame(chart) {
    const value = element("output", { class: "now", id: `now-${chart.id}` });
    const host = element("div", { class: "plot", id: `plot-${chart.id}` });
    const cursor = element("div", { class: "time-cursor" });
    this.box.append(element("section", { class: "chart" },
      element("h3", {}, chart.title, chart.unit ? element("small", {}, ` ${chart.unit}`) : null, value), host));
    return { ...chart, value, host, cursor, plot: null };
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
    const { runs } = this.state;
    const series = [{}];
    const tables = [];
    let max = 0;
    runs.forEach((run, r) => {
      chart.curves(run).forEach((curve) => {
        tables.push([curve.t.map((t) => this.#axis(run, t)), curve.y]);
        for (const y of curve.y) if (y > max) max = y;
        series.push({
          label: run.name,
          stroke: theme.runs[r % theme.runs.length],
          width: r === this.state.current ? 2 : 1.3,
          dash: curve.thin ? [4, 4] : RUN_DASHES[r % RUN_DASHES.length],
          spanGaps: true,
          paths: curve.stepped ? uPlot.paths.stepped({ align: 1 }) : undefined,
          points: { show: Boolean(curve.points) && curve.t.length < 80, size: 5 },
        });
      });
    });
    const data = uPlot.join(tables);
    const range = chart.range ? chart.range(max) : [0, max > 0 ? max * 1.1 : 1];
    const shape = `${series.length} ${this.state.byDecision} ${this.state.current} ${theme.text}`;
    if (chart.plot && chart.shape === shape) {
      chart.limits = range;
      chart.plot.setData(data);
      return;
    }
    chart.plot?.destroy();
    chart.shape = shape;
    chart.limits = range;
    chart.plot = new uPlot(this.#options(chart, series), data, chart.host);
    chart.plot.over.append(chart.cursor);
    this.#listen(chart.plot);
  }

  #options(chart, series) {
    const axis = { stroke: theme.muted, font: "11px system-ui, sans-serif", grid: { stroke: theme.grid, width: 1 }, ticks: { show: false } };
    return {
      width: chart.host.clientWidth,
      height: HEIGHT,
      series,
      legend: { show: false },
      scales: { x: { time: false, range: () => this.#xRange() }, y: { range: () => chart.limits } },
      axes: [
        {
          ...axis, size: 26, gap: 7,
          splits: (u) => {
            const [from, to] = this.#xRange();
            const most = u.width / 70;
            if (!this.state.byDecision) return timeTicks(from * 1000, to * 1000, most).map((t) => t / 1000);
            const step = Math.max(1, Math.ceil((to - from) / most));
            const splits = [];
            for (let d = Math.ceil(from); d <= to; d += step) splits.push(d);
            return splits;
          },
          values: (u, splits) => splits.map((v) => (this.state.byDecision ? String(v) : clockText(v * 1000, false))),
        },
        { ...axis, size: 52, gap: 4, space: 26, values: (u, splits) => splits.map((v) => (v >= 10000 ? `${v / 1000}k` : String(v))) },
      ],
      cursor: {
        sync: { key: SYNC, setSeries: false },
        y: false,
        points: { size: 6 },
        drag: { x: true, y: false, setScale: false },
      },
      hooks: {
        drawClear: [(u) => this.#drawBands(u)],
        setSelect: [(u) => this.#zoomTo(u)],
      },
    };
  }

  #listen(plot) {
    plot.over.addEventListener("click", () => {
      if (this.zoomed) this.zoomed = false;
      else if (plot.cursor.left >= 0) this.clock.seek(this.#time(plot.posToVal(plot.cursor.left, "x")));
    });
    plot.over.addEventListener("dblclick", () => this.state.setView(null));
  }

  #zoomTo(plot) {
    const { left, width } = plot.select;
    if (width < 12) return;
    const from = this.#time(plot.posToVal(left, "x"));
    const to = this.#time(plot.posToVal(left + width, "x"));
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.zoomed = true;
    this.state.setView([Math.max(0, from), Math.min(this.clock.max, to)]);
  }

  #drawBands(u) {
    const { run } = this.state;
    const c = u.ctx;
    const { left, top, width, height } = u.bbox;
    c.save();
    c.beginPath();
    c.rect(left, top, width, height);
    c.clip();
    for (const band of faultBands(run)) {
      const from = u.valToPos(this.#axis(run, band.from), "x", true);
      const to = u.valToPos(this.#axis(run, band.to), "x", true);
      c.fillStyle = theme.failed;
      c.globalAlpha = band.kind === "agent" ? 0.7 : 0.16;
      const tall = band.kind === "agent" ? 3 * devicePixelRatio : height;
      c.fillRect(from, top, Math.max(2 * devicePixelRatio, to - from), tall);
    }
    c.restore();
  }

  #applyView() {
    for (const { plot } of this.charts) {
      const [min, max] = this.#xRange();
      plot?.setScale("x", { min, max });
    }
    this.#moveCursor();
  }

  #moveCursor() {
    const { run } = this.state;
    if (!run) return;
    for (const chart of this.charts) {
      chart.value.textContent = chart.now(run, this.clock.t);
      if (!chart.plot) continue;
      const x = chart.plot.valToPos(this.#axis(run, this.clock.t), "x");
      chart.cursor.hidden = !(x >= 0 && x <= chart.plot.over.clientWidth);
      chart.cursor.style.transform = `translateX(${x}px)`;
    }
  }
}
