import { inTheAir, nearestPairs } from "./air.js";
import { Approaches, levelsOf, showingTime, upOn } from "./approaches.js";
import { fit, oncePerFrame } from "./canvas.js";
import { ChartTable } from "./chart_table.js";
import { element, number } from "./dom.js";
import { say, sayParts } from "./language.js";
import { linear } from "./scale.js";
import { cells, table } from "./table.js";
import { theme } from "./theme.js";
import { clockText, timeTicks } from "./time.js";
import { UAV } from "./words.js";

const MOST_PAIRS = 20; // at the clock's time
const MOST_MARKS = 10; // of the mission
const SETTLED_MS = 60_000; // what is older is not told anew on a live page
const LABEL = 64;
const AXIS = 32;
const ROW = 30;
const RIGHT = 8;
const MOST_TALL = 242;
const NEAR_PX = 8;
const NUMBER_PX = 12; // between the numbers of two marks
const TEXT_PX = 38; // of a level that has room for its altitude

/** "No conflict so far", "3 pairs in conflict" */
export function conflictWords(conflicts, ended) {
  if (conflicts === 0) return ended ? say("No conflict") : say("No conflict so far");
  return conflicts === 1 ? say("1 pair in conflict") : say("{n} pairs in conflict", { n: conflicts });
}

const distances = ({ across, up }) => ({ across: number(across), up: number(up) });

/** The tab Air: each UAV's altitude over time, the pairs that came nearest, and who is in the air at the clock's time. */
export class AirView {
  constructor(state, clock) {
    this.state = state;
    this.clock = clock;
    this.approaches = new Approaches(MOST_MARKS);
    this.rows = [];
    this.redraw = oncePerFrame(() => this.#drawChart());
    this.root = this.#frame();
    clock.subscribe(() => this.#moveCursor());
    state.on("view theme selection", this.redraw);
    state.on("selection", () => this.#reveal());
    this.scroller.addEventListener("scroll", this.redraw, { passive: true });
    this.scroller.addEventListener("pointermove", (event) => this.#hover(event));
    this.scroller.addEventListener("pointerleave", () => { this.tip.hidden = true; });
    this.scroller.addEventListener("click", (event) => this.#click(event));
    new ResizeObserver(this.redraw).observe(this.scroller);
  }

  #frame() {
    this.said = element("p", { class: "air-said" });
    this.canvas = element("canvas", { role: "img", "aria-label": say("Altitude of each UAV over time, and where two came nearest") });
    this.cursor = element("div", { class: "time-cursor" });
    this.tip = element("div", { class: "tip", hidden: true });
    this.space = element("div", { class: "air-space" });
    this.scroller = element("div", { class: "air-scroll", tabindex: 0, role: "group", "aria-label": say("One row a UAV") },
      element("div", { class: "air-pin" }, this.canvas, this.cursor, this.tip), this.space);
    this.table = new ChartTable(say("altitude of each UAV over time"), () => this.#levelTable());
    this.nearest = element("div", {});
    this.now = element("div", { class: "air-now" });
    this.chart = element("div", {}, this.said, this.scroller, this.table.node, this.nearest);
    return element("div", {}, this.chart, this.now);
  }

  get visible() {
    return this.root.isConnected;
  }

  draw() {
    const { run } = this.state;
    if (!run || !this.visible) return;
    const minima = run.scenario.air?.separation;
    this.chart.hidden = !minima;
    if (minima) this.#drawMission(run, minima);
    this.#drawNow(run, minima);
    this.redraw();
  }

  /** What is there stays, with the focus that is on it, while time and what is known about it are the same. */
  #drawNow(run, minima) {
    const { t } = this.clock;
    const shown = [run, Math.floor(t / 1000), Math.min(run.nowMs, t + SETTLED_MS)];
    if (this.shown?.every((value, i) => value === shown[i])) return;
    this.shown = shown;
    this.now.replaceChildren(...this.#atTime(run, minima));
  }

  #drawMission(run, minima) {
    const known = this.approaches.of(run);
    if (known === this.known) return;
    this.known = known;
    this.rows = known.flights.map(({ agent, pieces }) => ({ agent, levels: levelsOf(pieces) }));
    this.ceiling = Math.max(minima.vertical_m, ...this.rows.flatMap(({ levels }) => levels.map(({ up, toUp }) => Math.max(up, toUp))));
    const tall = AXIS + this.rows.length * ROW;
    this.scroller.style.setProperty("--tall", `${Math.min(MOST_TALL, tall)}px`);
    this.space.style.height = `${tall}px`;
    this.scroller.hidden = this.rows.length === 0;
    this.said.replaceChildren(...this.#headline(run, minima));
    this.nearest.replaceChildren(...this.#nearestTable(minima));
    this.table.update();
  }

  #seekButton(t) {
    return element("button", { type: "button", class: "name", onclick: () => this.clock.seek(t) }, clockText(t));
  }

  #pairButton(pair) {
    return element("button", { type: "button", class: "name", onclick: () => this.#go(pair) }, clockText(pair.t));
  }

  #headline(run, minima) {
    const { pairs: [pair], conflicts } = this.known;
    const conflict = element("b", {}, conflictWords(conflicts, run.ended));
    const closest = run.report?.separation?.closest;
    const planned = closest ? sayParts("Closest of the mission as planned: {a} and {b}, {across} m across and {up} m up, at {time}.", {
      a: `uav:${closest.uavs[0]}`, b: `uav:${closest.uavs[1]}`, across: number(closest.horizontal_m), up: number(closest.vertical_m),
      time: this.#seekButton(closest.at_s * 1000) }) : [];
    return [
      ...(pair ? sayParts("{conflict}. As flown, {a} and {b} came nearest: {across} m across and {up} m up from each other, at {time}.", {
        conflict, a: pair.a.label, b: pair.b.label, ...distances(pair), time: this.#pairButton(pair) }) :
      sayParts("{conflict}. No two UAVs have been in the air at the same time.", { conflict })),
      " ", say("Two are in conflict while they are closer than both {across} m across and {up} m up.", {
        across: minima.horizontal_m, up: minima.vertical_m }),
      ...(planned.length > 0 ? [" ", ...planned] : []),
    ];
  }

  #nearestTable(minima) {
    const { pairs } = this.known;
    if (pairs.length === 0) return [];
    const head = [say("mark"), say("UAVs"), say("time"), `#${say("across")}`, `#${say("up")}`, say("near by")];
    const rows = pairs.map((pair, i) => element("tr", { class: pair.conflict ? "bad" : null, tabindex: 0, onclick: () => this.#go(pair),
      onkeydown: (event) => event.key === "Enter" && this.#go(pair) },
    ...cells([i + 1, `${pair.a.label}, ${pair.b.label}`, clockText(pair.t), `${number(pair.across)} m`, `${number(pair.up)} m`,
      this.#nearWords(pair, pair.conflict, minima)], head)));
    return [element("h3", { class: "air-title" }, say("Nearest pairs of the mission")), table(head, rows)];
  }

  #nearWords({ across }, conflict, minima) {
    return conflict ? say("too close") : across < minima.horizontal_m ? say("above each other") : "";
  }

  /** The clock goes where two came nearest, and both are selected. */
  #go(pair) {
    this.clock.seek(showingTime(this.state.run, pair));
    this.state.select({ type: "agent", index: pair.b.index });
    this.state.flyTo({ type: "agent", index: pair.a.index }, true);
  }

  /** Who is in the air, how high, and which two are nearest to each other, at the clock's time. */
  #atTime(run, minima) {
    const { t } = this.clock;
    const flying = minima ? inTheAir(run, t) : [];
    if (flying.length === 0) return [element("p", { class: "empty" }, say("No UAV is in the air."))];
    const head = [say("UAVs"), `#${say("across")}`, `#${say("up")}`, say("near by")];
    const go = (index) => this.state.flyTo({ type: "agent", index });
    const rows = nearestPairs(flying, minima, MOST_PAIRS).map((pair) =>
      element("tr", { class: pair.share < 1 ? "bad" : null, tabindex: 0, onclick: () => go(pair.a.index),
        onkeydown: (e) => e.key === "Enter" && go(pair.a.index) },
      ...cells([`${pair.a.label}, ${pair.b.label}`, `${number(pair.across)} m`, `${number(pair.up)} m`, this.#nearWords(pair, pair.share < 1, minima)], head)));
    const heights = flying.map(({ up }) => up);
    return [
      element("p", { class: "lead" }, ...sayParts("{uavs} at {time}, {low} to {high} m above the ground. Kept apart: {across} m across or {up} m up.", {
        uavs: element("b", {}, say("{n} UAVs in the air", { n: flying.length })), time: clockText(t), low: number(Math.min(...heights)),
        high: number(Math.max(...heights)), across: minima.horizontal_m, up: minima.vertical_m })),
      table(head, rows),
    ];
  }

  #levelTable() {
    const rows = this.rows.flatMap(({ agent, levels }) => levels.map(({ t, until, up, toUp }) =>
      [t, agent.label, `${number(up)} m`, `${number(toUp)} m`, clockText(until)]));
    return { head: [say("time"), say("UAV"), say("altitude from"), say("altitude to"), say("until")], rows: rows.sort((a, b) => a[0] - b[0]) };
  }

  /** Scrolls to the row of what is selected. */
  #reveal() {
    const { selected } = this.state;
    const row = this.visible && selected?.type === "agent" ? this.rows.findIndex(({ agent }) => agent.index === selected.index) : -1;
    if (row < 0) return;
    const { scrollTop, clientHeight } = this.scroller;
    const shown = clientHeight - AXIS;
    if (row * ROW < scrollTop || (row + 1) * ROW > scrollTop + shown) this.scroller.scrollTop = (row + 0.5) * ROW - shown / 2;
  }

  #x(width) {
    return linear(this.state.viewRange, [LABEL, width - RIGHT]);
  }

  #moveCursor() {
    if (!this.visible || !this.state.run) return;
    const width = this.scroller.clientWidth;
    const x = this.#x(width)(this.clock.t);
    this.cursor.hidden = x < LABEL || x > width;
    this.cursor.style.transform = `translateX(${x}px)`;
  }

  #drawChart() {
    if (!this.visible || !this.known || this.scroller.hidden) return;
    const { context: c, width, height } = fit(this.canvas);
    if (width === 0) return;
    const x = this.#x(width);
    const top = this.scroller.scrollTop;
    c.save();
    c.beginPath();
    c.rect(0, AXIS, width, height - AXIS);
    c.clip();
    const last = Math.min(this.rows.length, Math.ceil((top + height - AXIS) / ROW));
    for (let i = Math.floor(top / ROW); i < last; ++i) this.#drawRow(c, x, width, this.rows[i], AXIS + i * ROW - top);
    c.restore();
    this.#drawAxis(c, x, width, height);
    this.places = this.#placesOfMarks(x, width, top);
    this.#drawMarks(c, height);
    this.#moveCursor();
  }

  /** Where an altitude is in a row. */
  #y(top, up) {
    return top + ROW - 3 - (up / this.ceiling) * (ROW - 9);
  }

  #drawRow(c, x, width, { agent, levels }, top) {
    if (this.state.isSelected({ type: "agent", index: agent.index })) {
      c.fillStyle = theme.band;
      c.fillRect(0, top, width, ROW);
    }
    c.fillStyle = theme.muted;
    c.font = "11px system-ui, sans-serif";
    c.textAlign = "left";
    c.textBaseline = "middle";
    c.fillText(agent.label, 4, top + ROW / 2);
    c.save();
    c.beginPath();
    c.rect(LABEL, top, width - RIGHT - LABEL, ROW);
    c.clip();
    const ground = this.#y(top, 0);
    c.fillStyle = c.strokeStyle = theme.kinds[UAV];
    c.lineWidth = 1.5;
    for (const { t, until, up, toUp } of levels) {
      const [left, right, from, to] = [x(t), x(until), this.#y(top, up), this.#y(top, toUp)];
      if (right < LABEL || left > width) continue;
      c.beginPath();
      for (const [px, py] of [[left, ground], [left, from], [right, to], [right, ground]]) c.lineTo(px, py);
      c.globalAlpha = 0.3;
      c.fill();
      c.globalAlpha = 1;
      c.beginPath();
      c.moveTo(left, from);
      c.lineTo(right, to);
      c.stroke();
    }
    this.#drawAltitudes(c, x, width, levels, top);
    c.restore();
    c.fillStyle = theme.grid;
    c.fillRect(LABEL, top + ROW - 1, width - RIGHT - LABEL, 1);
  }

  /** How high a level is, where there is room for it. */
  #drawAltitudes(c, x, width, levels, top) {
    c.fillStyle = theme.text;
    c.font = "10px system-ui, sans-serif";
    c.textAlign = "center";
    c.textBaseline = "alphabetic";
    for (const { t, until, up, toUp } of levels) {
      if (up !== toUp) continue;
      const [left, right] = [Math.max(LABEL, x(t)), Math.min(width - RIGHT, x(until))];
      if (right - left < TEXT_PX) continue;
      const y = this.#y(top, up);
      c.fillText(`${number(up)} m`, (left + right) / 2, y - 3 < top + 9 ? y + 11 : y - 3);
    }
  }

  #drawAxis(c, x, width, height) {
    c.fillStyle = theme.muted;
    c.strokeStyle = theme.grid;
    c.font = "11px system-ui, sans-serif";
    c.textAlign = "center";
    c.textBaseline = "alphabetic";
    c.lineWidth = 1;
    c.beginPath();
    for (const t of timeTicks(...this.state.viewRange, (width - LABEL) / 70)) {
      const px = Math.round(x(t)) + 0.5;
      c.fillText(clockText(t, false), Math.min(px, width - 16), 11);
      c.moveTo(px, AXIS);
      c.lineTo(px, height);
    }
    c.globalAlpha = 0.7;
    c.stroke();
    c.globalAlpha = 1;
  }

  /** Pixels of the marks in view: { pair, n, px, dots: [y, y] }, a dot for each of the two rows. */
  #placesOfMarks(x, width, scrolled) {
    return this.known.pairs.flatMap((pair, i) => {
      const px = x(pair.t);
      if (px < LABEL - 0.5 || px > width - RIGHT + 0.5) return [];
      const dots = [pair.a, pair.b].map((agent) => {
        const row = this.rows.findIndex((one) => one.agent === agent);
        return this.#y(AXIS + row * ROW - scrolled, upOn(this.rows[row].levels, pair.t) ?? 0);
      });
      return [{ pair, n: i + 1, px, dots }];
    });
  }

  /** A number and a triangle on the axis, and a dot in each of the two rows; those in conflict are filled, the others are rings. */
  #drawMarks(c, height) {
    const numbered = [];
    c.font = "bold 10px system-ui, sans-serif";
    c.textAlign = "center";
    for (const { pair, n, px, dots } of this.places) {
      c.fillStyle = c.strokeStyle = pair.conflict ? theme.failed : theme.text;
      c.lineWidth = 1.5;
      c.beginPath();
      for (const [dx, y] of [[-4, AXIS - 7], [4, AXIS - 7], [0, AXIS - 1]]) c.lineTo(px + dx, y);
      c.closePath();
      if (pair.conflict) c.fill();
      c.stroke();
      if (numbered.every((other) => Math.abs(other - px) >= NUMBER_PX)) {
        numbered.push(px);
        c.fillText(pair.conflict ? `${n}!` : String(n), px, AXIS - 10);
      }
      c.save();
      c.beginPath();
      c.rect(0, AXIS, this.canvas.clientWidth, height - AXIS);
      c.clip();
      c.globalAlpha = 0.45;
      c.setLineDash([2, 3]);
      c.beginPath();
      c.moveTo(px, AXIS);
      c.lineTo(px, Math.max(...dots));
      c.stroke();
      c.setLineDash([]);
      c.globalAlpha = 1;
      for (const y of dots) {
        c.beginPath();
        c.arc(px, y, 3.5, 0, 2 * Math.PI);
        if (pair.conflict) c.fill();
        c.stroke();
      }
      c.restore();
    }
  }

  /** What is at the pointer: { x, y } of the chart, the time, a mark's pair and a row, or null each. */
  #at(event) {
    const box = this.scroller.getBoundingClientRect();
    const [px, py] = [event.clientX - box.left, event.clientY - box.top];
    const isAt = (mark) => Math.abs(mark.px - px) <= NEAR_PX && (py < AXIS || mark.dots.some((y) => Math.abs(y - py) <= NEAR_PX));
    const [mark] = (this.places ?? []).filter(isAt).sort((a, b) => Math.abs(a.px - px) - Math.abs(b.px - px));
    const row = py < AXIS ? null : this.rows[Math.floor((py - AXIS + this.scroller.scrollTop) / ROW)] ?? null;
    return { px, py, t: px < LABEL ? null : this.#x(this.scroller.clientWidth).invert(px), pair: mark?.pair ?? null, row };
  }

  #click(event) {
    const { t, pair, row } = this.#at(event);
    if (pair) {
      this.#go(pair);
      return;
    }
    if (t !== null) this.clock.seek(t);
    if (row) this.state.select({ type: "agent", index: row.agent.index }, event.shiftKey);
  }

  #hover(event) {
    const { px, py, t, pair, row } = this.#at(event);
    const up = row && t !== null ? upOn(row.levels, t) : null;
    let text = "";
    if (pair) text = say("{a} and {b}: {across} m across and {up} m up, at {time}", { a: pair.a.label, b: pair.b.label, ...distances(pair), time: clockText(pair.t) });
    else if (up !== null) text = `${row.agent.label} ${number(up)} m ${clockText(t)}`;
    this.tip.hidden = !text;
    this.scroller.style.cursor = pair ? "pointer" : "";
    if (!text) return;
    this.tip.textContent = text;
    const left = Math.min(px + 12, this.scroller.clientWidth - this.tip.offsetWidth - 6);
    this.tip.style.transform = `translate(${Math.max(0, left)}px, ${Math.min(py + 14, this.scroller.clientHeight - 26)}px)`;
  }
}
