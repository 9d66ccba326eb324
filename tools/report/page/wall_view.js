import { oncePerFrame } from "./canvas.js";
import { byId, element, number } from "./dom.js";
import { say } from "./language.js";
import { clockText, localWords } from "./time.js";
import { Round, wallFigures, wallItems } from "./wall.js";

/** The page for a screen across the room: the map, a few figures, and what needs attention, one after the other. */
export class WallView {
  constructor(state, clock, map, attention) {
    this.state = state;
    this.clock = clock;
    this.map = map;
    this.attention = attention;
    this.round = new Round(() => wallItems(attention.found), (...what) => this.#show(...what), {
      now: () => performance.now(), set: (act, ms) => setTimeout(act, ms), clear: (timer) => clearTimeout(timer) });
    this.figures = Object.fromEntries(["done", "risk", "failed", "time"].map((id) => [id, this.#figure()]));
    this.figures.done.label.textContent = say("Tasks done");
    this.figures.failed.label.textContent = say("Agents failed");
    this.figures.time.label.textContent = say("Time");
    this.draw = oncePerFrame(() => this.#drawFigures());
    clock.subscribe(this.draw);
    state.on("wall", () => (state.wall ? this.#enter() : this.#leave()));
    state.on("attention", () => this.#look());
    state.on("run", () => this.#again());
    state.on("run data", this.draw);
  }

  #figure() {
    const parts = { label: element("dt", {}), value: element("dd", {}), note: element("dd", { class: "note" }) };
    byId("wall-figures").append(element("div", {}, ...Object.values(parts)));
    return parts;
  }

  #enter() {
    const { state, clock } = this;
    this.back = { focus: document.activeElement, look: state.looks };
    state.look("map");
    document.documentElement.dataset.wall = "";
    byId("wall").hidden = false;
    if (state.live) {
      clock.seek(clock.max, true);
      this.ticking = setInterval(() => this.attention.draw(), 1000); // that nothing is heard any more is not heard, either
    }
    this.map.home();
    this.#again();
    this.#drawFigures();
  }

  #leave() {
    this.round.stop();
    clearInterval(this.ticking);
    delete document.documentElement.dataset.wall;
    byId("wall").hidden = true;
    this.state.look(this.back.look);
    this.back.focus?.focus?.({ preventScroll: true });
  }

  /** From the first one on. */
  #again() {
    if (!this.state.wall) return;
    this.round.begin();
    this.attention.draw();
  }

  /** What needs attention has been looked for again. */
  #look() {
    if (!this.state.wall) return;
    this.draw();
    this.round.look();
  }

  #show(item, at, total) {
    byId("wall-item").className = item ? `a-${item.kind}` : "";
    if (item) {
      this.#say(item.mark, `${item.title} ${number(item.count)}`, item.text, item.note, say("{n} of {total}", { n: number(at + 1), total: number(total) }));
    } else this.#say("", "", say("Nothing needs attention now."), "", "");
    this.#goTo(item?.item ?? null);
  }

  /** Selects it, and takes the map there, unless the user wants nothing to move; what has no place is of the whole map. */
  #goTo(item) {
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (item && !still) return this.state.flyTo(item);
    this.state.select(item);
    if (!item && !still) this.map.home();
  }

  #say(...texts) {
    ["wall-mark", "wall-kind", "wall-what", "wall-note", "wall-place"].forEach((id, i) => {
      if (byId(id).textContent !== texts[i]) byId(id).textContent = texts[i]; // else it would be read out again
    });
  }

  #drawFigures() {
    const { run, wall } = this.state;
    if (!run || !wall) return;
    const { t } = this.clock;
    const { done, total, failed, isOver, risk } = wallFigures(run, t, this.attention.all);
    const figures = this.figures;
    byId("wall-name").textContent = run.name;
    figures.done.value.textContent = say("{n} of {total}", { n: number(done), total: number(total) });
    figures.risk.label.textContent = isOver ? say("Not done") : say("At risk");
    figures.risk.value.textContent = number(risk);
    figures.failed.value.textContent = number(failed);
    figures.time.value.textContent = clockText(t);
    figures.time.note.textContent = localWords(run, t);
  }
}
