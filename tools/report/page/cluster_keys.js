import { clusterWords } from "./clusters.js";
import { byId, element } from "./dom.js";
import { say } from "./language.js";
import { placeWords } from "./place.js";

const SETTLED_MS = 250; // between two looks at what the map shows, while it moves
const STEPS = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 };

/** The map's clusters for the keyboard and for screen readers: a button each, unseen; the map marks the one with the focus. */
export class ClusterKeys {
  constructor(map) {
    this.map = map;
    this.box = byId("clusters");
    this.key = "";
    this.timer = 0;
    this.box.addEventListener("keydown", (event) => this.#key(event));
    this.box.addEventListener("focusin", (event) => this.#point(event.target.dataset.cluster ?? null));
    this.box.addEventListener("focusout", () => this.#point(null));
  }

  /** The map has been drawn. */
  follow() {
    this.timer ||= setTimeout(() => this.#show(), SETTLED_MS);
  }

  #show() {
    this.timer = 0;
    const { clusters, state: { run } } = this.map;
    const texts = clusters.map((cluster) => say("{what} around {place}: zoom in", { what: clusterWords(cluster), place: placeWords(run, cluster) }));
    const key = texts.join("\n");
    if (key === this.key) return;
    this.key = key;
    const focused = this.box.contains(document.activeElement) ? document.activeElement.dataset.cluster : null;
    this.box.hidden = clusters.length === 0;
    this.box.replaceChildren(...clusters.map((cluster, i) => element("button", { type: "button", tabindex: -1, "data-cluster": cluster.key,
      onclick: () => this.map.enter(cluster) }, texts[i])));
    const first = this.box.querySelector(`[data-cluster="${focused}"]`) ?? this.box.firstElementChild;
    if (first) first.tabIndex = 0;
    if (focused) (first ?? byId("map-reset")).focus({ preventScroll: true });
  }

  #point(key) {
    this.map.pointed = key;
    this.map.draw();
  }

  #key(event) {
    const buttons = [...this.box.children];
    const at = buttons.indexOf(event.target);
    const to = event.key === "Home" ? 0 : event.key === "End" ? buttons.length - 1 : event.key in STEPS ? at + STEPS[event.key] : null;
    if (to === null) return;
    event.preventDefault();
    event.stopPropagation();
    if (!buttons[to]) return;
    buttons[at].tabIndex = -1;
    buttons[to].tabIndex = 0;
    buttons[to].focus({ preventScroll: true });
  }
}
