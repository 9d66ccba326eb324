import { Color, DirectionalLight, HemisphereLight, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "three";
import { fit, oncePerFrame } from "../canvas.js";
import { say, speak } from "../language.js";
import { drawLabels } from "../map_labels.js";
import { labelOf } from "../names.js";
import { taskStatusAt } from "../run.js";
import { readTheme, theme } from "../theme.js";
import { clockText, timeTicks } from "../time.js";
import { DONE, readWords } from "../words.js";
import { Actors } from "./actors.js";
import { City } from "./city.js";
import { Ground } from "./ground.js";
import { heightWords, timesAsHigh } from "./heights.js";
import { FIELD_DEG, Orbit } from "./orbit.js";
import { Plane } from "./plane.js";
import { SpaceTime, TALL } from "./spacetime.js";

const NEAR_PX = 14;
const LABEL_PX = 7000; // of the scene for each name
const CLOSE = 26; // how near the camera comes to what is chosen elsewhere
const MOST_PIXELS = 2;

/** The mission in three dimensions, at the clock's time: draws on `canvas`, names on `labels`. `freeOf()` is what floats on it leaves free. */
export class SceneView {
  constructor({ canvas, context, labels, state, clock, language, freeOf }) {
    Object.assign(this, { canvas, labels, state, clock, freeOf });
    speak(language);
    readTheme();
    readWords(state.run.words);
    this.mode = "scene"; // or "time"
    this.scenery = true;
    this.follow = false;
    this.renderer = new WebGLRenderer({ canvas, context });
    this.renderer.autoClear = false;
    this.renderer.localClippingEnabled = true;
    this.below = new Scene(); // ground and blocks: whatever acts is seen in front of them
    this.scene = new Scene();
    for (const scene of [this.below, this.scene]) {
      const sun = new DirectionalLight(0xffffff, 0.55);
      sun.position.set(-0.5, 1, 0.35);
      scene.add(sun, new HemisphereLight(0xffffff, 0x9aa4b0, 0.6));
    }
    this.camera = new PerspectiveCamera(FIELD_DEG, 1, 0.5, 2000);
    this.ground = new Ground(this.below, this.scene);
    this.city = new City(this.below);
    this.actors = new Actors(this.scene);
    this.spaceTime = new SpaceTime(this.scene);
    this.draw = oncePerFrame(() => this.drawNow());
    this.orbit = new Orbit(canvas, this.draw);
    this.orbit.followed = () => this.setFollow(false);
    this.#listen();
    this.#rebuild();
  }

  #listen() {
    const { state, canvas, clock } = this;
    clock.subscribe(this.draw);
    state.on("run theme", () => this.#rebuild());
    state.on("data", () => this.#news());
    state.on("classes selection", () => this.#ways());
    state.on("trails", this.draw);
    state.on("fly", () => this.#fly());
    new ResizeObserver(() => this.measure()).observe(canvas);
    canvas.addEventListener("click", (event) => state.select(this.find(event.offsetX, event.offsetY)));
    canvas.addEventListener("dblclick", () => this.reset());
  }

  /** Looks how much of the canvas is covered. */
  measure() {
    this.orbit.free = this.freeOf() ?? this.orbit.free;
    if (!this.orbit.moved) this.orbit.fit();
    this.draw();
  }

  setMode(mode) {
    if (mode === this.mode) return;
    this.mode = mode;
    this.reset();
    this.#ways();
  }

  setScenery(shown) {
    this.scenery = shown;
    this.city.build(this.state.run, this.plane, shown);
    this.draw();
  }

  /** Whether the camera goes where the selected agent goes. */
  setFollow(follow) {
    if (follow && !this.follow) this.orbit.lookAt(this.orbit.target, CLOSE);
    this.follow = follow;
    this.followChanged?.();
    this.draw();
  }

  /** Looks at all of it. */
  reset() {
    this.setFollow(false);
    this.orbit.reset(this.plane.width, this.plane.height, this.mode === "time" ? TALL : 0);
    this.draw();
  }

  #rebuild() {
    readTheme();
    const { run } = this.state;
    const first = run !== this.run;
    this.run = run;
    this.plane = new Plane(run.scenario);
    this.crowding = Math.min(1, Math.max(0.35, 13 / Math.sqrt(run.agents.length + run.tasks.length)));
    this.actors.readTheme();
    this.ground.build(run, this.plane, this.clock.t);
    this.city.build(run, this.plane, this.scenery);
    if (first) this.reset();
    this.#ways();
    this.heightsChanged?.();
  }

  /** How many times as high as they fly UAVs are drawn; null: the mission has no altitudes. */
  get times() {
    return timesAsHigh(this.run, this.plane.unit, this.crowding);
  }

  /** What its heights mean, in words. */
  get heightWords() {
    return heightWords(this.times);
  }

  /** A live mission went on. */
  #news() {
    this.heightsChanged?.();
    if (this.mode === "time") this.#ways();
    else this.draw();
  }

  #ways() {
    const { run, classes, selected } = this.state;
    this.spaceTime.build(this.mode === "time" ? run : null, this.plane, classes, selected);
    this.draw();
  }

  /** Takes what was chosen elsewhere to the middle. */
  #fly() {
    this.drawNow();
    const { selected } = this.state;
    const at = selected && this.#placeOf(selected);
    if (at) this.orbit.lookAt([at.x, at.y, at.z], CLOSE);
  }

  #placeOf(selected) {
    const { plane, state } = this;
    if (selected.type === "agent") return this.actors.places?.find((place) => place.agent.index === selected.index) ?? null;
    const site = (selected.type === "task" ? state.run.tasks : state.run.charging)[selected.id];
    return site ? { x: plane.x(site.x), y: this.floor, z: plane.z(site.y) } : null;
  }

  /** How large bodies are: so that they can be seen from where the camera is, and smaller in a crowd. */
  get size() {
    return this.crowding * Math.min(1.25, Math.max(0.16, this.orbit.distance * 0.0072));
  }

  drawNow() {
    const { canvas, renderer, camera, run, clock, state } = this;
    const { clientWidth: width, clientHeight: height } = canvas;
    if (width === 0 || height === 0) return;
    const ratio = Math.min(MOST_PIXELS, window.devicePixelRatio || 1);
    if (renderer.getPixelRatio() !== ratio) renderer.setPixelRatio(ratio);
    if (canvas.width !== Math.floor(width * ratio) || canvas.height !== Math.floor(height * ratio)) renderer.setSize(width, height, false);
    const t = clock.t;
    const inTime = this.mode === "time";
    this.floor = inTime ? this.spaceTime.heightOf(run, t) : 0;
    this.actors.show({ run, plane: this.plane, t, size: this.size, lift: this.crowding, times: this.times, floor: this.floor, flat: inTime,
      trailMs: state.trailMs, classes: state.classes, selected: state.selected });
    this.ground.show(run, this.plane, t);
    this.spaceTime.cut(run, t);
    this.city.mesh.visible = !inTime && this.city.n > 0;
    this.ground.glass.visible = inTime;
    this.ground.glass.position.y = this.floor;
    if (this.follow && state.selected) {
      const at = this.#placeOf(state.selected);
      if (at) this.orbit.target = [at.x, at.y, at.z];
    }
    this.orbit.aim(camera);
    camera.updateMatrixWorld();
    renderer.setClearColor(new Color(theme.page));
    renderer.clear();
    renderer.render(this.below, camera);
    renderer.clearDepth();
    renderer.render(this.scene, camera);
    this.#drawLabels(width, height);
    canvas.dataset.drawn = String(Math.round(t));
  }

  /** Pixels of a place in the scene; null behind the camera. */
  #project({ x, y, z }, width, height) {
    const v = new Vector3(x, y, z).project(this.camera);
    return v.z > 1 ? null : { px: ((v.x + 1) / 2) * width, py: ((1 - v.y) / 2) * height };
  }

  #drawLabels(width, height) {
    const { context: c } = fit(this.labels);
    const { run, state } = this;
    const labels = [];
    const put = (text, place, colour, gap = 9) => {
      const at = place && this.#project(place, width, height);
      if (at && at.px > 0 && at.py > 0 && at.px < width && at.py < height) labels.push({ text, ...at, gap, colour });
    };
    const chosen = state.selected;
    if (chosen) put(labelOf(run, chosen), this.#placeOf(chosen), theme.text);
    if (this.mode === "time") {
      const corner = { x: -this.plane.width / 2, z: this.plane.height / 2 };
      for (const t of timeTicks(0, run.limitMs, 6)) put(clockText(t, false), { ...corner, y: this.spaceTime.heightOf(run, t) }, theme.muted, 2);
      put(say("now {time}", { time: clockText(this.clock.t) }), { ...corner, y: this.floor }, theme.text, 2);
    }
    const room = (width * height) / LABEL_PX;
    const inView = this.actors.places.filter((place) => place.agent.index !== chosen?.index || chosen?.type !== "agent");
    if (inView.length <= room) for (const place of inView) put(place.agent.label, place, theme.kinds[place.agent.kind]);
    drawLabels(c, labels, { width, height }, theme.page);
  }

  /** What is nearest to a place of the canvas, agents first; null when nothing is near. */
  find(px, py) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    let best = null;
    let nearest = NEAR_PX ** 2;
    const look = (place, item) => {
      const at = this.#project(place, width, height);
      const d = at ? (at.px - px) ** 2 + (at.py - py) ** 2 : Infinity;
      if (d >= nearest) return;
      nearest = d;
      best = item;
    };
    for (const place of this.actors.places ?? []) look(place, { type: "agent", index: place.agent.index });
    if (best) return best;
    const { run, plane } = this;
    for (const type of ["task", "charge"]) {
      for (const site of type === "task" ? run.tasks.filter((task) => !task.vacant) : run.charging) look({ x: plane.x(site.x), y: this.floor, z: plane.z(site.y) }, { type, id: site.id });
    }
    return best;
  }

  /** Pixels of an agent; for tests and films. */
  whereIs(index) {
    const place = this.actors.places.find((other) => other.agent.index === index);
    return place && this.#project(place, this.canvas.clientWidth, this.canvas.clientHeight);
  }

  get counts() {
    const open = this.run.tasks.filter((task) => taskStatusAt(task, this.clock.t) !== DONE).length;
    return { ...this.actors.counts, open, blocks: this.city.n, meetings: this.spaceTime.meetings ?? 0 };
  }
}
