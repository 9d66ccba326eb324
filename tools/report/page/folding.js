import { byId } from "./dom.js";

const KEPT = "muster.folded"; // in the browser's storage

/** What lies on the map and can be folded, by its id in links. */
export const FOLDS = ["attention", "card", "legend", "tools"];

/** Where the page is that of a phone, as in the style sheet. */
export const PHONE = "(max-width: 860px)";

/** The ids of panels that a text names, like "legend,tools". */
export const foldIds = (text) => (text ?? "").split(",").filter((id) => FOLDS.includes(id));

/** What a link says of folded panels: nothing where they are as they usually are, "none" where none is. */
export function foldText(folded, usual) {
  const text = FOLDS.filter((id) => folded.has(id)).join();
  return text === FOLDS.filter((id) => usual.has(id)).join() ? null : text || "none";
}

/** Folds and unfolds the panels on the map; the browser remembers it. A link that says which are goes first. */
export class Folding {
  constructor(state) {
    this.state = state;
    state.usualFolds = new Set(matchMedia(PHONE).matches ? ["legend", "tools"] : []);
    state.folded = this.#kept() ?? new Set(state.usualFolds);
    this.buttons = [...document.querySelectorAll("[data-fold]")];
    for (const button of this.buttons) button.addEventListener("click", () => this.toggle(button.dataset.fold));
    state.on("fold", () => this.#show());
    byId("tools-more").addEventListener("click", (event) => this.#onTool(event));
    this.#show();
  }

  toggle(id) {
    const folded = new Set(this.state.folded);
    if (!folded.delete(id)) folded.add(id);
    this.#take(folded);
  }

  /** Folds all of them, or unfolds all where all are folded. */
  toggleAll() {
    this.#take(new Set(FOLDS.every((id) => this.state.folded.has(id)) ? [] : FOLDS));
  }

  /** On a phone the tools lie over the map: whoever has chosen one needs the map. */
  #onTool({ target }) {
    if (matchMedia(PHONE).matches && target.closest("[role=tab], #measure, #order-add, #order-road, #order-zone, #order-decide")) this.toggle("tools");
  }

  #take(folded) {
    this.state.setFolded(folded);
    try {
      localStorage.setItem(KEPT, [...folded].join() || "none");
    } catch { /* a browser that keeps nothing */ }
  }

  #show() {
    const { folded } = this.state;
    document.documentElement.dataset.folded = [...folded].join(" ");
    for (const button of this.buttons) button.setAttribute("aria-expanded", String(!folded.has(button.dataset.fold)));
    if (folded.has("tools")) byId("layers").open = false;
  }

  #kept() {
    try {
      const text = localStorage.getItem(KEPT);
      return text === null ? null : new Set(foldIds(text));
    } catch {
      return null; // a browser that keeps nothing
    }
  }
}
