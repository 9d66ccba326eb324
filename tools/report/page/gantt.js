import { fit, oncePerFrame } from "./canvas.js";
import { ChartTable } from "./chart_table.js";
import { byId, number } from "./dom.js";
import { say } from "./language.js";
import { busyMs, faultBands, statusAt } from "./run.js";
import { linear } from "./scale.js";
import { clockText, rowAt, timeTicks } from "./time.js";
import { theme } from "./theme.js";
import { CHARGING, FAILED, IDLE, MOVING, NOT_READY, OFFLINE, SENSING, WAITING } from "./words.js";

const LABEL = 84;
const AXIS = 22;
const COUNT_EVERY_MS = 600_000;
const HEIGHTS = { rows: 18, dense: 7 };
/** Share of the row's height by status, so that statuses differ by more than colour. */
const THICK = [0, 0.12, 0.4, 0.62, 0.86, 0.86, 0.86, 0.4];

/** One row an agent: what it did when. Only the rows in view are drawn. */
export class Gantt {
  constructor(state, clock) {
    this.state = state;
    this.clock = clock;
    this.canvas = byId("gantt");
    this.overview = byId("overview");
    this.scroller = byId("gantt-scroll");
    this.spacer = byId("gantt-space");
    this.tip = byId("gantt-tip");
    this.mode = "auto";
    this.sort = "id";
    this.draw = oncePerFrame(() => this.#draw());
    this.drawOverview = oncePerFrame(() => this.#drawOverview());
    this.scroller.addEventListener("scroll", this.draw, { passive: true });
    clock.subscribe(() => this.#moveCursor());
    state.on("run data classes filter", () => this.layout());
    state.on("view theme selection", () => {
      this.draw();
      this.drawOverview();
    });
    new ResizeObserver(() => {
      this.draw();
      this.drawOverview();
    }).observe(this.scroller);
    this.scroller.addEventListener("pointermove", (event) => this.#hover(event));
    this.scroller.addEventListener("pointerleave", () => { this.tip.hidden = true; });
    this.scroller.addEventListener("click", (event) => this.#click(event));
    this.overview.addEventListener("click", (event) => clock.seek(this.#x(this.overview.clientWidth).invert(event.offsetX)));
    this.tables = [new ChartTable(say("agents with each status over time"), () => this.#countTable()),
      new ChartTable(say("minutes of each agent with each status"), () => this.#agentTable())];
    byId("gantt-tables").append(...this.tables.map(({ node }) => node));
    this.layout();
  }

  get #statuses() {
    return this.state.run.words.statuses.map((name, i) => [say(name), i]).slice(1);
  }

  /** Of the agents in the rows, at every tenth minute. */
  #countTable() {
    const { run } = this.state;
    const rows = [];
    for (let t = 0; t <= run.nowMs; t += COUNT_EVERY_MS) {
      const now = this.rows.map((agent) => statusAt(agent, t));
      rows.push([t, ...this.#statuses.map(([, i]) => String(now.filter((status) => status === i).length))]);
    }
    return { head: [say("time"), ...this.#statuses.map(([name]) => name)], rows };
  }

  #agentTable() {
    const { run } = this.state;
    const rows = this.rows.map(({ label, spans }) => {
      const sums = new Map();
      for (let i = 0; i < spans.length; i += 2) sums.set(spans[i + 1], (sums.get(spans[i + 1]) ?? 0) + (spans[i + 2] ?? run.nowMs) - spans[i]);
      return [label, ...this.#statuses.map(([, i]) => number((sums.get(i) ?? 0) / 60000, 1))];
    });
    return { head: [say("agent"), ...this.#statuses.map(([name]) => name)], rows };
  }

  get rowHeight() {
    const mode = this.mode === "auto" ? (this.rows.length > 250 ? "dense" : "rows") : this.mode;
    return HEIGHTS[mode];
  }

  /** Chooses and orders the rows. */
  layout() {
    const { run, classes } = this.state;
    if (!run) return;
    this.rows = run.agents.filter((agent) => !agent.vacant && classes[agent.kind] && this.state.finds(agent));
    if (this.sort === "busy") {
      const busy = new Map(this.rows.map((agent) => [agent, busyMs(agent, run.nowMs)]));
      this.rows.sort((a, b) => busy.get(b) - busy.get(a) || a.index - b.index);
    }
    this.bands = faultBands(run);
    this.spacer.style.height = `${Math.max(1, this.rows.length * this.rowHeight)}px`;
    byId("gantt-count").textContent = say("{n} of {total} agents", { n: this.rows.length, total: run.crew.reduce((sum, n) => sum + n) });
    this.draw();
    this.drawOverview();
    for (const table of this.tables) table.update();
  }

  reveal(agent) {
    const i = this.rows.indexOf(agent);
    if (i < 0) return;
    const top = i * this.rowHeight;
    const shown = this.scroller.clientHeight - AXIS;
    if (top < this.scroller.scrollTop || top > this.scroller.scrollTop + shown - this.rowHeight) {
      this.scroller.scrollTop = top - shown / 2;
    }
  }

  #x(width) {
    return linear(this.state.viewRange, [LABEL, width - 8]);
  }

  #moveCursor() {
    const x = this.#x(this.scroller.clientWidth)(this.clock.t);
    for (const id of ["gantt-cursor", "overview-cursor"]) {
      const line = byId(id);
      line.hidden = x < LABEL;
      line.style.transform = `translateX(${x}px)`;
    }
  }

  #draw() {
    const { run } = this.state;
    const { context: c, width, height } = fit(this.canvas);
    if (!run || width === 0) return;
    const x = this.#x(width);
    const h = this.rowHeight;
    const top = this.scroller.scrollTop;
    this.#drawBands(c, x, width, height);
    c.save();
    c.beginPath();
    c.rect(0, AXIS, width, height - AXIS);
    c.clip();
    const first = Math.floor(top / h);
    const last = Math.min(this.rows.length, Math.ceil((top + height - AXIS) / h));
    c.font = `${h > 12 ? 11 : 9}px system-ui, sans-serif`;
    c.textBaseline = "middle";
    for (let i = first; i < last; ++i) this.#drawRow(c, x, width, this.rows[i], AXIS + i * h - top, h, i);
    c.restore();
    this.#drawAxis(c, x, width, height);
    this.#moveCursor();
  }

  #drawRow(c, x, width, agent, top, h, i) {
    const { run } = this.state;
    if (this.state.isSelected({ type: "agent", index: agent.index })) {
      c.fillStyle = theme.band;
      c.fillRect(0, top, width, h);
    }
    if (h > 12 || i % Math.ceil(12 / h) === 0) {
      c.fillStyle = theme.kinds[agent.kind];
      c.fillRect(4, top + h / 2 - 3, 4, 6);
      c.fillStyle = theme.muted;
      c.textAlign = "left";
      c.fillText(agent.label, 13, top + h / 2 + 0.5);
    }
    const [from, to] = this.state.viewRange;
    const { spans } = agent;
    for (let s = Math.max(0, rowAt(spans, 2, from)) * 2; s < spans.length && spans[s] < to; s += 2) {
      const status = spans[s + 1];
      if (status === OFFLINE) continue;
      const end = s + 2 < spans.length ? spans[s + 2] : Math.max(run.nowMs, spans[s]);
      const left = Math.max(LABEL, x(Math.max(from, spans[s])));
      const right = Math.min(width - 8, x(Math.min(to, end)));
      const thick = Math.max(1.2, THICK[status] * (h - 1));
      const y = top + (h - thick) / 2;
      c.fillStyle = theme.status[status];
      c.fillRect(left, y, Math.max(0.8, right - left), thick);
      if (h > 12 && right - left > 3) this.#pattern(c, status, left, right, y, thick);
    }
  }

  /** Waiting is striped, also for a driver; charging has a bright core, failed is crossed: no need to tell colours apart. */
  #pattern(c, status, left, right, y, thick) {
    if (status === CHARGING) {
      c.fillStyle = theme.panel;
      c.fillRect(left + 1.5, y + thick / 2 - 1, Math.max(0, right - left - 3), 2);
    }
    if (![WAITING, NOT_READY, FAILED].includes(status)) return;
    c.strokeStyle = theme.panel;
    c.lineWidth = 1;
    c.beginPath();
    for (let px = left + 3; px < right; px += status === FAILED ? 8 : 4) {
      c.moveTo(px, y + thick);
      c.lineTo(Math.min(right, px + 3), y);
    }
    c.stroke();
  }

  #drawBands(c, x, width, height) {
    for (const band of this.bands) {
      const left = Math.max(LABEL, x(band.from));
      const right = Math.min(width - 8, x(band.to));
      if (right < LABEL || left > width) continue;
      if (band.kind === "agent") {
        c.fillStyle = theme.failed;
        c.fillRect(left - 0.75, AXIS - 5, 1.5, 5); // when it happened: its row shows the rest
        continue;
      }
      c.fillStyle = theme.failed;
      c.globalAlpha = 0.16;
      c.fillRect(left, AXIS, Math.max(2, right - left), height - AXIS);
      c.globalAlpha = 1;
      c.fillRect(left, AXIS - 4, Math.max(2, right - left), 4);
    }
  }

  #drawAxis(c, x, width, height) {
    c.fillStyle = theme.muted;
    c.strokeStyle = theme.grid;
    c.font = "11px system-ui, sans-serif";
    c.textBaseline = "alphabetic";
    c.textAlign = "center";
    c.lineWidth = 1;
    c.beginPath();
    for (const t of timeTicks(...this.state.viewRange, (width - LABEL) / 70)) {
      const px = Math.round(x(t)) + 0.5;
      c.fillText(clockText(t, false), Math.min(px, width - 16), 13);
      c.moveTo(px, 18);
      c.lineTo(px, height);
    }
    c.globalAlpha = 0.7;
    c.stroke();
    c.globalAlpha = 1;
  }

  /** How many agents of the chosen classes had which status when: readable with any number of agents. */
  #drawOverview() {
    const { run } = this.state;
    const { context: c, width, height } = fit(this.overview);
    if (!run || width === 0) return;
    const x = this.#x(width);
    const columns = Math.max(1, Math.min(240, Math.floor((width - LABEL) / 3)));
    const [from, to] = this.state.viewRange;
    const until = Math.min(to, run.nowMs);
    const order = [SENSING, CHARGING, WAITING, MOVING, NOT_READY, IDLE, FAILED];
    const step = (to - from) / columns;
    const statuses = run.words.statuses.length;
    const counts = new Uint16Array(columns * statuses);
    for (const agent of this.rows) {
      const { spans } = agent;
      let s = 0;
      for (let i = 0; i < columns; ++i) {
        const t = from + (i + 0.5) * step;
        if (t > until || spans.length === 0 || spans[0] > t) continue;
        while (s + 2 < spans.length && spans[s + 2] <= t) s += 2;
        ++counts[i * statuses + spans[s + 1]];
      }
    }
    let most = 1;
    for (let i = 0; i < columns; ++i) {
      let sum = 0;
      for (const status of order) sum += counts[i * statuses + status];
      most = Math.max(most, sum);
    }
    const scale = (height - 4) / most;
    for (let i = 0; i < columns; ++i) {
      let y = height - 2;
      for (const status of order) {
        const tall = counts[i * statuses + status] * scale;
        c.fillStyle = theme.status[status];
        c.fillRect(x(from + i * step), y - tall, x(from + step) - x(from) + 0.3, tall);
        y -= tall;
      }
    }
    c.fillStyle = theme.muted;
    c.font = "11px system-ui, sans-serif";
    c.textAlign = "left";
    c.fillText(say("together"), 4, height - 4);
    c.fillText(say("{n} online", { n: most }), 4, 10);
  }

  #agentAt(event) {
    const box = this.scroller.getBoundingClientRect();
    const y = event.clientY - box.top;
    if (y < AXIS) return null;
    return this.rows[Math.floor((y - AXIS + this.scroller.scrollTop) / this.rowHeight)] ?? null;
  }

  #timeAt(event) {
    return this.#x(this.scroller.clientWidth).invert(event.clientX - this.scroller.getBoundingClientRect().left);
  }

  #hover(event) {
    const box = this.scroller.getBoundingClientRect();
    const t = this.#timeAt(event);
    const agent = this.#agentAt(event);
    let text = "";
    if (event.clientX - box.left >= LABEL && t <= this.state.run.nowMs) {
      const band = this.bands.find((b) => t >= b.from - 15000 && t <= b.to + 15000 && event.clientY - box.top < AXIS);
      if (band) text = `${clockText(band.from)} ${band.label}`;
      else if (agent) {
        const i = rowAt(agent.spans, 2, t);
        if (i >= 0) {
          const end = 2 * i + 2 < agent.spans.length ? agent.spans[2 * i + 2] : this.state.run.nowMs;
          text = `${agent.label} ${say(this.state.run.words.statuses[agent.spans[2 * i + 1]])} ${clockText(agent.spans[2 * i])} – ${clockText(end)}`;
        }
      }
    }
    this.tip.hidden = !text;
    if (!text) return;
    this.tip.textContent = text;
    const left = Math.min(event.clientX - box.left + 12, box.width - this.tip.offsetWidth - 6);
    this.tip.style.transform = `translate(${left}px, ${event.clientY - box.top + 14}px)`;
  }

  #click(event) {
    const agent = this.#agentAt(event);
    const t = this.#timeAt(event);
    if (event.clientX - this.scroller.getBoundingClientRect().left >= LABEL) this.clock.seek(t);
    if (agent) this.state.select({ type: "agent", index: agent.index });
  }
}
