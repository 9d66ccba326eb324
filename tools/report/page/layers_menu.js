import { byId, element } from "./dom.js";
import { LAYERS } from "./layers/index.js";

const KEPT = { off: "muster.layers", extra: "muster.extra-layers" }; // in the browser's storage

export const MENU = LAYERS.filter(({ title }) => title);

/** The ids of layers that a text names, like "roads,tasks"; of those that are shown only when asked for, or of the others. */
export const layerIds = (text, extra = false) =>
  (text ?? "").split(",").filter((id) => MENU.some((layer) => layer.id === id && (layer.extra ?? false) === extra));

/** Switches the map's layers off and on; the browser remembers it. A link that says which are goes first. */
export class LayersMenu {
  constructor(state) {
    this.state = state;
    this.box = byId("layers-list");
    this.#restore();
    state.on("run data layers rival", () => this.#show());
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
    const { run } = this.state;
    const there = MENU.filter(({ legend, extra, offered }) => (offered ? offered(this.state)
      : extra || !legend || legend.some(({ shows }) => !shows || shows(run))));
    const key = there.map(({ id }) => id).join();
    if (key !== this.shown) { // else what has the focus keeps it
      this.shown = key;
      this.box.replaceChildren(...there.map((layer) => element("label", {},
        element("input", { type: "checkbox", "data-layer": layer.id, onchange: () => this.state.toggleLayer(layer) }), ` ${layer.title}`)));
    }
    this.box.querySelectorAll("input").forEach((input, i) => { input.checked = this.state.showsLayer(there[i]); });
  }

  #keep() {
    try {
      for (const [ids, key] of Object.entries(KEPT)) localStorage.setItem(key, [...this.state[ids]].join());
    } catch { /* a browser that keeps nothing */ }
  }

  #restore() {
    try {
      for (const [ids, key] of Object.entries(KEPT)) this.state[ids] = new Set(layerIds(localStorage.getItem(key), ids === "extra"));
    } catch { /* the same */ }
  }
}
