import { byId, element } from "./dom.js";
import { LAYERS } from "./layers/index.js";

const KEPT = "muster.layers"; // in the browser's storage

export const MENU = LAYERS.filter(({ title }) => title);

/** The ids of layers that a text names, like "roads,tasks". */
export const layerIds = (text) => (text ?? "").split(",").filter((id) => MENU.some((layer) => layer.id === id));

/** Switches the map's layers off and on; the browser remembers it. A link that says which are off goes first. */
export class LayersMenu {
  constructor(state) {
    this.state = state;
    this.box = byId("layers-list");
    this.#restore();
    state.on("run data layers", () => this.#show());
    state.on("layers", () => this.#keep());
    document.addEventListener("click", (event) => {
      if (!event.target.closest("#layers")) byId("layers").open = false;
    });
    byId("layers").addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || !byId("layers").open) return;
      byId("layers").open = false;
      byId("layers").querySelector("summary").focus();
      event.stopPropagation();
    });
  }

  #show() {
    const { run, off } = this.state;
    const there = MENU.filter(({ legend }) => !legend || legend.some(({ shows }) => !shows || shows(run)));
    const key = there.map(({ id }) => id).join();
    if (key !== this.shown) { // else what has the focus keeps it
      this.shown = key;
      this.box.replaceChildren(...there.map(({ id, title }) =>
        element("label", {}, element("input", { type: "checkbox", "data-layer": id, onchange: () => this.state.toggleLayer(id) }), ` ${title}`)));
    }
    for (const input of this.box.querySelectorAll("input")) input.checked = !off.has(input.dataset.layer);
  }

  #keep() {
    try {
      localStorage.setItem(KEPT, [...this.state.off].join());
    } catch { /* a browser that keeps nothing */ }
  }

  #restore() {
    try {
      this.state.off = new Set(layerIds(localStorage.getItem(KEPT)));
    } catch { /* the same */ }
  }
}
