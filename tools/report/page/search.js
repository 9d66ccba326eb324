import { byId, element } from "./dom.js";
import { MOST_NAMES_RANK, namesOf } from "./base_map.js";
import { say } from "./language.js";
import { pointName, taskName } from "./names.js";

const SHOWN = 8;

/** How well a text matches what is looked for: 0 exactly, 1 at its beginning, 2 at a word's, 3 anywhere; -1: not at all. */
function matchOf(text, wanted) {
  const at = text.indexOf(wanted);
  if (at < 0) return -1;
  if (text === wanted) return 0;
  // Of numbers the whole: "uav:7" does not find uav:70.
  const isCut = /\d$/.test(wanted) && /^\d/.test(text.slice(at + wanted.length));
  if (isCut) return -1;
  return at === 0 ? 1 : /\W/.test(text[at - 1]) ? 2 : 3;
}

/**
 * What a text finds in a run, the best first: { words, item } of agents, tasks and charging points, { words, place } of
 * places that the base map names. A number alone finds the task, then agents and charging points of that number.
 */
export function find(run, text, most = SHOWN) {
  const wanted = text.trim().toLowerCase();
  if (!wanted) return [];
  const found = [];
  const look = (names, one) => {
    const best = Math.min(...names.map((name) => matchOf(name.toLowerCase(), wanted)).filter((match) => match >= 0));
    if (best !== Infinity) found.push({ ...one, rank: best });
  };
  const isNumber = /^\d+$/.test(wanted);
  for (const task of run.tasks) {
    if (task.vacant) continue;
    const name = task.name ?? "";
    const own = [`task:${task.id}`, `task ${task.id}`, taskName(task.id), `${task.id}`];
    const words = name ? `${taskName(task.id)}, ${name}` : taskName(task.id);
    look(isNumber ? [`${task.id}`] : name ? [...own, name] : own, { words, item: { type: "task", id: task.id } });
  }
  for (const { vacant, id, label, index } of run.agents) {
    if (!vacant) look(isNumber ? [`${id}`] : [label, label.replace(":", " ")], { words: label, item: { type: "agent", index } });
  }
  for (const point of run.charging) {
    const words = pointName(point.id);
    look(isNumber ? [`${point.id}`] : [`charge:${point.id}`, `charging point ${point.id}`, words], { words, item: { type: "charge", id: point.id } });
  }
  for (const { text: name, rank, x, y } of isNumber ? [] : namesOf(run.baseMap)) {
    look([name], { words: name, place: { x, y }, less: rank / (MOST_NAMES_RANK + 1) });
  }
  // What stands first stays first among equals.
  return found.map((one, i) => ({ one, i })).sort((a, b) => a.one.rank + (a.one.less ?? 0) - b.one.rank - (b.one.less ?? 0) || a.i - b.i)
    .slice(0, most).map(({ one: { words, item, place } }) => (item ? { words, item } : { words, place }));
}

/** The box above the map that finds agents, tasks, charging points and places by their names. */
export class Search {
  constructor(state, map) {
    this.state = state;
    this.map = map;
    this.input = byId("search");
    this.list = byId("search-list");
    this.found = [];
    this.active = 0;
    this.input.addEventListener("input", () => this.#look());
    this.input.addEventListener("focus", () => this.#look());
    this.input.addEventListener("blur", () => this.#close());
    this.input.addEventListener("keydown", (event) => this.#key(event));
    this.list.addEventListener("pointerdown", (event) => {
      event.preventDefault(); // the box keeps the focus
      const at = [...this.list.children].indexOf(event.target.closest("li"));
      if (at >= 0) this.#choose(at);
    });
  }

  focus() {
    this.input.focus();
    this.input.select();
  }

  #look() {
    this.found = find(this.state.run, this.input.value);
    this.active = 0;
    this.#show();
  }

  #show() {
    const text = this.input.value.trim();
    this.list.hidden = !text;
    this.input.setAttribute("aria-expanded", String(this.found.length > 0));
    this.list.replaceChildren(...this.found.map(({ words }, i) => element("li", { id: `found-${i}`, role: "option", "aria-selected": String(i === this.active) }, words)),
      ...(text && this.found.length === 0 ? [element("li", { role: "option", "aria-disabled": "true", "aria-selected": "false" }, say("Nothing of that name"))] : []));
    if (this.found.length > 0) this.input.setAttribute("aria-activedescendant", `found-${this.active}`);
    else this.input.removeAttribute("aria-activedescendant");
  }

  #close() {
    this.list.hidden = true;
    this.input.setAttribute("aria-expanded", "false");
  }

  #key(event) {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step && this.found.length > 0) {
      this.active = (this.active + step + this.found.length) % this.found.length;
      this.#show();
    } else if (event.key === "Enter") this.#choose(this.active, event.shiftKey);
    else if (event.key === "Escape") this.input.blur();
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  #choose(i, more = false) {
    const one = this.found[i];
    if (!one) return;
    this.input.value = "";
    this.input.blur();
    if (one.item) this.state.flyTo(one.item, more);
    else this.map.goTo(one.place);
  }
}
