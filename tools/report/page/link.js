import { foldText } from "./folding.js";
import { linkLanguage } from "./language.js";

const KINDS = ["uav", "worker", "vehicle"];

/** "uav:2", "task:17", "charge:3" of what is selected; null of nothing. */
export function nameOf(run, selected) {
  if (!selected) return null;
  if (selected.type !== "agent") return `${selected.type}:${selected.id}`;
  return run.agents[selected.index].label;
}

/** "uav:2,task:17" of all that is selected, what was selected last first; null of nothing. */
export function namesOf({ run, allSelected }) {
  return allSelected.map((one) => nameOf(run, one)).join() || null;
}

/** What a name selects in a run; null: it has no such thing. */
export function itemOf(run, name) {
  const [, type, digits] = /^([a-z]+):(\d+)$/.exec(name ?? "") ?? [];
  const id = Number(digits);
  const kind = KINDS.indexOf(type);
  const counts = [run.scenario.uavs, run.scenario.workers, run.scenario.vehicles];
  if (kind >= 0) return id < counts[kind] && !run.agents[run.agentIndex(kind, id)].vacant ? { type: "agent", index: run.agentIndex(kind, id) } : null;
  if (type === "task") return id < run.tasks.length && !run.tasks[id].vacant ? { type, id } : null;
  if (type === "charge") return id < run.charging.length ? { type, id } : null;
  return null;
}

/** "#t=4800&sel=uav:2,task:17&look=scene&off=roads,tasks&on=coverage&against=2" as { tMs, sel, ... }; what it does not say is null. */
export function readLink(hash) {
  const values = new URLSearchParams(hash.replace(/^#/, ""));
  const number = (key) => (/^\d+(\.\d+)?$/.test(values.get(key) ?? "") ? Number(values.get(key)) : null);
  const t = number("t");
  const look = ["scene", "time"].find((name) => name === values.get("look")) ?? null;
  return { tMs: t === null ? null : t * 1000, sel: values.get("sel"), run: number("run"), look, off: values.get("off"), on: values.get("on"),
    against: number("against"), wall: values.get("wall") === "1", fold: values.get("fold") };
}

export function writeLink({ tMs, sel, run, look, off, on, against, wall, fold, lang }) {
  const parts = [];
  if (tMs !== null) parts.push(`t=${Math.round(tMs / 1000)}`);
  if (sel) parts.push(`sel=${sel}`);
  if (run) parts.push(`run=${run}`);
  if (look && look !== "map") parts.push(`look=${look}`);
  if (off) parts.push(`off=${off}`);
  if (on) parts.push(`on=${on}`);
  if (against !== null && against !== undefined) parts.push(`against=${against}`);
  if (wall) parts.push("wall=1");
  if (fold) parts.push(`fold=${fold}`);
  if (lang) parts.push(`lang=${lang}`);
  return `#${parts.join("&")}`;
}

const SETTLED_MS = 250;

/**
 * Keeps the address at what is shown: a selection is a step of the browser's history, time is not, nor what a wall shows by itself. `start(link)` shows
 * what a link says, also when the user goes back.
 */
export class Link {
  constructor(state, clock, show) {
    this.state = state;
    this.clock = clock;
    this.show = show;
    this.ready = false;
    this.timer = 0;
    this.shown = "";
    clock.subscribe(() => this.#later());
    state.on("selection run", () => this.#step());
    state.on("wall", () => this.#turn());
    state.on("look layers rival fold", () => this.#later());
    window.addEventListener("popstate", () => this.#apply());
  }

  /** From now on the address follows. */
  start() {
    this.#apply();
    this.ready = true;
  }

  #apply() {
    clearTimeout(this.timer);
    this.ready = false;
    this.show(readLink(location.hash));
    this.shown = namesOf(this.state);
    this.shownRun = this.state.current;
    this.ready = true;
  }

  #address() {
    const { current, looks, off, extra, rival, usualRival, wall, folded, usualFolds } = this.state;
    return writeLink({ tMs: this.clock.follow ? null : this.clock.t, sel: wall ? null : namesOf(this.state), run: current, look: looks,
      off: [...off].join(), on: [...extra].join(), against: rival === usualRival ? null : rival, wall,
      fold: foldText(folded, usualFolds), lang: linkLanguage() });
  }

  #later() {
    if (!this.ready) return;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => history.replaceState(null, "", this.#address()), SETTLED_MS);
  }

  /** A wall begins or ends. */
  #turn() {
    if (!this.ready) return;
    this.shown = namesOf(this.state);
    clearTimeout(this.timer);
    history.pushState(null, "", this.#address());
  }

  #step() {
    if (!this.ready) return;
    if (this.state.wall) {
      this.#later();
      return;
    }
    const name = namesOf(this.state);
    if (name === this.shown && this.state.current === this.shownRun) return;
    this.shown = name;
    this.shownRun = this.state.current;
    clearTimeout(this.timer);
    history.pushState(null, "", this.#address());
  }
}
