import { inflate } from "./data.js";
import { byId, element } from "./dom.js";
import { describe } from "./describe.js";
import { freePart } from "./free_part.js";
import { language, say } from "./language.js";

const NO_WEBGL = say("This browser has no WebGL 2, so it cannot draw the scene. The map shows the same mission.");
const NO_SCENE = say("This Muster was built without three.js (Debian: libjs-three), so its pages have no scene. The map shows the same mission.");

const CROWDED = 500; // agents: their edges are not smoothed, which costs more than they do

/** The tabs of the map and of the scene, whose code is unpacked when it is first opened. */
export class SceneTab {
  constructor(state, clock) {
    this.state = state;
    this.clock = clock;
    this.canvas = byId("scene");
    this.tabs = [...byId("view-tabs").querySelectorAll("[role=tab]")];
    for (const tab of this.tabs) {
      tab.addEventListener("click", () => state.look(tab.dataset.look));
      tab.addEventListener("keydown", (event) => this.#arrow(event));
    }
    byId("scene-follow").addEventListener("click", () => this.view?.setFollow(!this.view.follow));
    byId("scene-blocks").addEventListener("change", (event) => this.view?.setScenery(event.target.checked));
    this.canvas.addEventListener("pointermove", (event) => this.#hover(event));
    this.canvas.addEventListener("pointerleave", () => { byId("scene-tip").hidden = true; });
    state.on("look", () => this.#show());
    state.on("selection", () => this.#showFollow());
    state.on("fold wall", () => this.view?.measure());
    matchMedia("print").addEventListener("change", () => this.view?.measure());
    const sizes = new ResizeObserver(() => this.view?.measure());
    for (const id of ["map-tools", "legend-box", "side"]) sizes.observe(byId(id));
  }

  reset() {
    this.view?.reset();
  }

  #arrow(event) {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!by) return;
    event.preventDefault();
    event.stopPropagation();
    const at = this.tabs.findIndex((tab) => tab === event.target);
    const next = this.tabs[(at + by + this.tabs.length) % this.tabs.length];
    next.focus();
    this.state.look(next.dataset.look);
  }

  #show() {
    const { looks } = this.state;
    for (const tab of this.tabs) {
      const chosen = tab.dataset.look === looks;
      tab.setAttribute("aria-selected", String(chosen));
      tab.tabIndex = chosen ? 0 : -1;
    }
    const scene = looks !== "map";
    byId("map-box").hidden = scene;
    byId("map-legend").hidden = scene;
    byId("scene-box").hidden = !scene;
    byId("scene-box").setAttribute("aria-labelledby", looks === "time" ? "tab-time" : "tab-scene");
    byId("scene-legend").hidden = !scene;
    for (const tool of document.querySelectorAll(".scene-tool")) tool.hidden = !scene;
    for (const part of byId("scene-legend").querySelectorAll("[data-look]")) part.hidden = part.dataset.look !== looks;
    byId("scene-blocks").disabled = looks === "time";
    if (!scene) return;
    this.loading ??= this.#load();
    this.view?.setMode(looks);
    this.#showFollow();
  }

  async #load() {
    const context = this.canvas.getContext("webgl2", { antialias: this.state.run.agents.length <= CROWDED, preserveDrawingBuffer: true });
    if (!context) return this.#cannot(NO_WEBGL);
    const packed = document.querySelector('script[type="text/x-muster-scene"]');
    if (!packed) return this.#cannot(NO_SCENE);
    this.#tell(say("The scene is being unpacked."));
    try {
      const code = await new Response(inflate(packed.textContent)).text();
      document.head.append(element("script", {}, code));
      this.view = new window.musterScene.SceneView({
        canvas: this.canvas, context, labels: byId("scene-labels"), state: this.state, clock: this.clock, language: language(),
        freeOf: () => freePart(this.state, byId("scene-box")) });
    } catch (error) {
      this.#cannot(say("The scene cannot be drawn: {why}. The map shows the same mission.", { why: error.message }));
      return;
    }
    this.#tell("");
    this.canvas.addEventListener("webglcontextlost", () => this.#tell(say("The graphics card has dropped the scene; it comes back when it can.")));
    this.canvas.addEventListener("webglcontextrestored", () => {
      this.#tell("");
      this.view.draw();
    });
    this.view.followChanged = () => this.#showFollow();
    this.view.heightsChanged = () => { byId("scene-heights").textContent = this.view.heightWords; };
    this.view.heightsChanged();
    this.view.setMode(this.state.looks);
    if (this.state.run.baseMap) { // no made-up buildings where the place is known
      byId("scene-blocks").checked = false;
      this.view.setScenery(false);
    }
    document.addEventListener("basemap", () => this.view.draw());
    Object.assign(window.muster, { scene: this.view, film: new window.musterScene.Film(this.view) });
    this.#showFollow();
  }

  #cannot(why) {
    this.#tell(why);
    this.canvas.hidden = true;
    for (const tool of document.querySelectorAll(".scene-tool :is(button, input), button.scene-tool")) tool.disabled = true;
  }

  #tell(text) {
    byId("scene-problem").textContent = text;
  }

  #showFollow() {
    const { selected, run } = this.state;
    const button = byId("scene-follow");
    const agent = selected?.type === "agent" ? run.agents[selected.index] : null;
    button.disabled = !agent || !this.view;
    button.textContent = agent ? say("Follow {agent}", { agent: agent.label }) : say("Follow");
    button.setAttribute("aria-pressed", String(Boolean(this.view?.follow && agent)));
  }

  #hover(event) {
    const tip = byId("scene-tip");
    const found = event.buttons ? null : this.view?.find(event.offsetX, event.offsetY);
    tip.hidden = !found;
    this.canvas.style.cursor = found ? "pointer" : "grab";
    if (!found) return;
    tip.textContent = describe(this.state.run, found, this.clock.t);
    const left = Math.min(event.offsetX + 14, this.canvas.clientWidth - tip.offsetWidth - 6);
    tip.style.transform = `translate(${Math.max(4, left)}px, ${Math.max(4, event.offsetY - 34)}px)`;
  }
}
