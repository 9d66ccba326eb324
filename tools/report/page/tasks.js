import { oncePerFrame } from "./canvas.js";
import { element, number } from "./dom.js";
import { say } from "./language.js";
import { taskName } from "./names.js";
import { taskStatusAt } from "./run.js";
import { PRIORITIES, doneTime, taskNow } from "./story.js";
import { clockText } from "./time.js";
import { BEING_SENSED, CANCELLED, DONE, HELD, OPEN, RESERVED, UNREPORTED } from "./words.js";

const MOST_ROWS = 250;
const PLAYING_MS = 300; // between two drawings while it plays

/** The columns: what they sort by. `timed`: only where tasks have times and priorities, or only where they have none. */
const COLUMNS = [
  { id: "task", title: say("task"), key: (row) => row.id },
  { id: "priority", title: say("priority"), timed: true, key: (row) => -row.priority },
  { id: "due", title: say("due"), timed: true, key: (row) => row.due ?? Infinity },
  { id: "now", title: say("now"), key: (row) => row.status },
  { id: "who", title: say("who"), key: (row) => row.who },
  { id: "when", title: say("until, since"), key: (row) => row.when ?? Infinity },
  { id: "end", title: say("in the end"), key: (row) => row.doneAt ?? Infinity },
  { id: "cost", title: say("takes"), number: true, timed: false, key: (row) => row.cost },
];

const FILTERS = [
  ["all", say("all"), () => true],
  ["todo", say("to do"), (row) => [OPEN, RESERVED, BEING_SENSED, HELD].includes(row.status)],
  ["open", say("nobody sent"), (row) => row.status === OPEN],
  ["under", say("under way"), (row) => row.status === RESERVED || row.status === BEING_SENSED],
  ["held", say("held or cancelled"), (row) => row.status === HELD || row.status === CANCELLED],
  ["done", say("done"), (row) => row.status === DONE],
  ["never", say("never done"), (row) => row.never],
];

/**
 * Which rows a text finds: a number is a task's, other text stands anywhere in task, agents and name, in any case. A number
 * at its end is whole: "uav:7" does not find uav:70.
 */
export function matcherOf(text) {
  if (!text) return () => true;
  if (/^\d+$/.test(text)) return (row) => row.id === Number(text);
  const escaped = text.toLowerCase().replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
  const wanted = new RegExp(/\d$/.test(text) ? `${escaped}(?!\\d)` : escaped);
  return (row) => wanted.test(`task:${row.id} task ${row.id} ${taskName(row.id).toLowerCase()} ${row.who} ${row.name.toLowerCase()}`);
}

/** A task as it stands at t. Who is at it is found when it is asked for: of a city's tasks few are shown. */
class Row {
  #of;

  constructor(run, task, t) {
    this.#of = { run, task, t, found: null };
    this.id = task.id;
    this.cost = task.cost;
    this.name = task.name ?? "";
    this.priority = task.priority ?? 1;
    this.due = task.due ?? null;
    this.status = taskStatusAt(task, t);
    this.doneAt = doneTime(run, task);
    this.never = run.ended && this.doneAt === null && this.status !== CANCELLED;
  }

  get #activity() {
    const { run, task, t } = this.#of;
    this.#of.found ??= { activity: this.status === OPEN ? null : taskNow(run, task, t).activity };
    return this.#of.found.activity;
  }

  get who() {
    const activity = this.#activity;
    return activity ? `uav:${activity.uav}, worker:${activity.partner}` : "";
  }

  get when() {
    return this.status === DONE ? this.doneAt : this.#activity?.end ?? null;
  }
}

/** All tasks at the clock's time: sorted, filtered, chosen with mouse or keyboard. */
export class TaskTable {
  constructor(state, clock) {
    this.state = state;
    this.clock = clock;
    this.sort = "task";
    this.down = false;
    this.filter = "all";
    this.text = "";
    this.drawn = 0;
    this.draw = oncePerFrame(() => this.#draw());
    this.root = this.#frame();
    clock.subscribe(() => this.#onTime());
    state.on("run data", this.draw);
    state.on("selection", () => this.#mark(true));
  }

  get visible() {
    return this.root.isConnected;
  }

  show(filter) {
    this.filter = filter;
    this.choice.value = filter;
    this.draw();
  }

  #frame() {
    this.choice = element("select", { id: "task-filter", onchange: (e) => this.show(e.target.value) },
      ...FILTERS.map(([id, title]) => element("option", { value: id }, title)));
    this.find = element("input", { type: "search", id: "task-find", size: 8, placeholder: "17, uav:3", autocomplete: "off",
      oninput: (e) => {
        this.text = e.target.value.trim().toLowerCase();
        this.draw();
      } });
    this.count = element("output", { id: "task-count", class: "muted" });
    this.heads = COLUMNS.map((column) => element("th", { scope: "col", class: column.number ? "n" : null },
      element("button", { type: "button", class: "sorter", onclick: () => this.#sortBy(column.id) }, column.title)));
    this.body = element("tbody", { onkeydown: (e) => this.#key(e), onclick: (e) => this.#choose(e.target.closest("tr"), e.shiftKey) });
    this.rest = element("p", { class: "empty", hidden: true });
    return element("div", { id: "task-table" },
      element("div", { class: "table-tools" }, element("label", { class: "choice" }, `${say("Show")} `, this.choice),
        element("label", { class: "choice" }, `${say("Find")} `, this.find), this.count),
      element("table", {}, element("thead", {}, element("tr", {}, ...this.heads)), this.body), this.rest);
  }

  #sortBy(id) {
    this.down = this.sort === id && !this.down;
    this.sort = id;
    this.draw();
  }

  #onTime() {
    if (this.clock.playing && performance.now() - this.drawn < PLAYING_MS) return;
    this.draw();
  }

  #rows() {
    const { run } = this.state;
    const wanted = FILTERS.find(([id]) => id === this.filter)[2];
    const { text } = this;
    const matches = matcherOf(text);
    const rows = run.tasks.map((task) => new Row(run, task, this.clock.t))
      .filter((row) => row.status !== UNREPORTED && wanted(row) && matches(row));
    const { key } = COLUMNS.find((column) => column.id === this.sort);
    const sign = this.down ? -1 : 1;
    const order = (a, b) => (a < b ? -1 : a > b ? 1 : 0);
    if (this.sort === "task") return this.down ? rows.reverse() : rows; // as they come
    return rows.sort((a, b) => sign * order(key(a), key(b)) || a.id - b.id);
  }

  #draw() {
    const { run } = this.state;
    if (!run || !this.visible) return;
    this.drawn = performance.now();
    const rows = this.#rows();
    COLUMNS.forEach((column, i) => {
      this.heads[i].setAttribute("aria-sort", column.id !== this.sort ? "none" : this.down ? "descending" : "ascending");
      this.heads[i].hidden = (column.timed ?? run.timed) !== run.timed;
    });
    this.count.textContent = say("{n} of {total} tasks", { n: number(rows.length), total: number(run.tasks.filter((task) => !task.vacant).length) });
    const shown = rows.slice(0, MOST_ROWS);
    const key = JSON.stringify([shown.map((row) => [row.id, row.status, row.who, row.when, row.doneAt, row.never, row.name, row.priority, row.due]),
      rows.length, run.name]);
    if (key !== this.key) {
      this.key = key;
      const focused = document.activeElement?.closest?.("#task-table tr")?.dataset.task;
      this.body.replaceChildren(...shown.map((row) => this.#tr(run, row)));
      if (focused) this.#row(focused)?.focus({ preventScroll: true });
      this.rest.hidden = rows.length <= MOST_ROWS;
      this.rest.textContent = say("{n} more: sort or filter to see them", { n: number(rows.length - MOST_ROWS) });
    }
    this.#mark(false);
  }

  #tr(run, row) {
    const when = row.when === null ? "" : clockText(row.when);
    const end = row.doneAt !== null ? clockText(row.doneAt) : row.never ? say("never done") : "";
    return element("tr", { tabindex: -1, "data-task": row.id, class: row.never ? "never" : null },
      element("td", { class: "task-name", title: row.name || null }, String(row.id), row.name ? element("span", {}, element("bdi", {}, row.name)) : null),
      ...(run.timed ? [element("td", {}, PRIORITIES[row.priority]), element("td", {}, row.due === null ? "" : clockText(row.due))] : []),
      element("td", {}, element("i", { class: `task-mark t${row.status}`, "aria-hidden": "true" }), say(run.words.tasks[row.status])),
      element("td", {}, row.who), element("td", {}, when), element("td", { class: "end" }, end),
      run.timed ? null : element("td", { class: "n" }, `${number(row.cost / 1000, 1)} km`));
  }

  #row(id) {
    return this.body.querySelector(`tr[data-task="${id}"]`);
  }

  /** The rows of selected tasks are marked, and the last of them is in view when asked for; one row takes the focus. */
  #mark(reveal) {
    if (!this.visible) return;
    const { selected, others } = this.state;
    const chosen = selected?.type === "task" ? this.#row(selected.id) : null;
    for (const row of this.body.querySelectorAll('[aria-selected="true"], [tabindex="0"]')) {
      row.removeAttribute("aria-selected");
      row.tabIndex = -1;
    }
    (chosen ?? this.body.firstElementChild)?.setAttribute("tabindex", "0");
    chosen?.setAttribute("aria-selected", "true");
    for (const { type, id } of others) if (type === "task") this.#row(id)?.setAttribute("aria-selected", "true");
    if (!chosen || !reveal) return;
    const scroller = this.root.parentElement;
    const [row, box] = [chosen.getBoundingClientRect(), scroller.getBoundingClientRect()];
    if (row.top < box.top + 60 || row.bottom > box.bottom) scroller.scrollTop += row.top - box.top - box.height / 2;
  }

  #choose(row, more) {
    if (row) this.state.flyTo({ type: "task", id: Number(row.dataset.task) }, more);
  }

  #key(event) {
    const row = event.target.closest("tr");
    const to = { ArrowDown: row.nextElementSibling, ArrowUp: row.previousElementSibling,
      Home: this.body.firstElementChild, End: this.body.lastElementChild }[event.key];
    if (event.key === "Enter" || event.key === " ") this.#choose(row, event.shiftKey);
    else if (!["ArrowDown", "ArrowUp", "Home", "End"].includes(event.key)) return;
    event.preventDefault();
    event.stopPropagation();
    if (!to) return;
    row.tabIndex = -1;
    to.tabIndex = 0;
    to.focus();
  }
}
