/** Whether two selections are of the same thing. */
export function isSame(a, b) {
  return a.type === b.type && a.index === b.index && a.id === b.id;
}

/** What the user has chosen, and who wants to know. */
export class State {
  constructor() {
    this.runs = [];
    this.current = 0;
    this.selected = null; // { type: "agent", index } or { type: "task" | "charge", id }
    this.others = []; // what is selected besides
    this.classes = [true, true, true];
    this.filter = ""; // part of an agent's name
    this.view = null; // [from, to] in ms of the current run; null: all of it
    this.byDecision = false; // curves over decisions rather than time
    this.live = false;
    this.other = null; // the run whose decisions the map shows as well
    this.rival = null; // the run that the open one is compared with
    this.usualRival = null; // the same as long as the user does not choose
    this.trailMs = 20 * 60000;
    this.off = new Set(); // ids of the map's layers that are not shown
    this.extra = new Set(); // ids of those that are shown only when asked for
    this.looks = "map"; // "scene": in 3D; "time": space and time
    this.folded = new Set(); // ids of panels on the map that are folded
    this.usualFolds = new Set(); // those that are as long as the user folds and unfolds nothing
    this.wall = false; // whether the page is a display for a wall
    this.listeners = new Map();
  }

  get run() {
    return this.runs[this.current];
  }

  /** The run that the open one is compared with; null: there is none. */
  get rivalRun() {
    return this.runs[this.rival] ?? null;
  }

  /** what: "run", "data", "selection", "fly", "classes", "filter", "view", "axis", "trails", "layers", "look", "differ", "rival", "theme", "orders",
   *  "attention", "wall", "fold" (also: the sheet of a phone is drawn) */
  on(what, listener) {
    for (const name of what.split(" ")) {
      if (!this.listeners.has(name)) this.listeners.set(name, []);
      this.listeners.get(name).push(listener);
    }
  }

  emit(what) {
    for (const listener of this.listeners.get(what) ?? []) listener();
  }

  /** `more`: besides what is selected so far; what is selected already is then no longer. */
  select(selected, more = false) {
    if (!more || !this.selected) {
      this.selected = selected;
      this.others = [];
    } else if (selected) {
      const kept = this.allSelected.filter((one) => !isSame(one, selected));
      if (kept.length === this.allSelected.length) kept.unshift(selected);
      [this.selected = null, ...this.others] = kept;
    }
    this.emit("selection");
  }

  /** The one that was selected last comes first. */
  get allSelected() {
    return this.selected ? [this.selected, ...this.others] : [];
  }

  /** Of all that is selected, that one comes first from now on. */
  lead(item) {
    this.others = this.allSelected.filter((one) => !isSame(one, item));
    this.selected = item;
    this.emit("selection");
  }

  isSelected(item) {
    return this.allSelected.some((one) => isSame(one, item));
  }

  /** Shows run `i`. */
  open(i) {
    this.current = i;
    this.selected = null;
    this.others = [];
    this.emit("run");
    this.emit("selection");
  }

  setFilter(text) {
    this.filter = text.trim().toLowerCase();
    this.emit("filter");
  }

  finds(agent) {
    return agent.label.includes(this.filter);
  }

  /** Selects, and takes the map there. `more`: see select(). */
  flyTo(selected, more = false) {
    this.select(selected, more);
    this.emit("fly");
  }

  toggleClass(kind) {
    this.classes[kind] = !this.classes[kind];
    this.emit("classes");
  }

  setView(view) {
    this.view = view;
    this.emit("view");
  }

  setTrails(ms) {
    this.trailMs = ms;
    this.emit("trails");
  }

  /** What is not shown, and what is shown because it was asked for; null leaves either as it is. */
  setLayers({ off, extra }) {
    if (off) this.off = new Set(off);
    if (extra) this.extra = new Set(extra);
    this.emit("layers");
  }

  toggleLayer({ id, extra }) {
    const ids = extra ? this.extra : this.off;
    if (!ids.delete(id)) ids.add(id);
    this.emit("layers");
  }

  showsLayer({ id, extra }) {
    return extra ? this.extra.has(id) : !this.off.has(id);
  }

  /** Shows what run `i` decided otherwise; null: nothing. */
  differFrom(i) {
    this.other = i;
    this.emit("differ");
  }

  /** Compares with run `i`; null: there is no other. */
  setRival(i) {
    if (this.rival === i) return;
    this.rival = i;
    this.emit("rival");
  }

  setFolded(ids) {
    this.folded = new Set(ids);
    this.emit("fold");
  }

  /** Turns the page into a display for a wall, or back. */
  setWall(on) {
    if (this.wall === on || !this.run) return;
    this.wall = on;
    this.emit("wall");
  }

  /** Shows the map, the scene, or space and time. */
  look(looks) {
    if (this.looks === looks) return;
    this.looks = looks;
    this.emit("look");
  }

  get viewRange() {
    return this.view ?? [0, this.run.limitMs];
  }
}
