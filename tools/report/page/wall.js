import { KINDS } from "./attention.js";
import { figuresAt } from "./compare.js";

const EACH_MS = 8000;
const LEAST_MS = 2000; // what is over by then is shown for that long
const MOST_OF_KIND = 4; // of the same trouble: those that the panel of the page shows, too

/**
 * What a wall shows one after the other, of all that needs attention: each with `key`, which stays while seconds pass, its kind's title
 * and mark, and how many there are of the kind.
 */
export function wallItems(found) {
  return KINDS.flatMap(({ id, title, mark }) => {
    const group = found.filter(({ kind }) => kind === id);
    return group.slice(0, MOST_OF_KIND).map((one) => ({ ...one, key: id === "log" ? id : `${id} ${one.text}`, title, mark, count: group.length }));
  });
}

/** Which of the items comes after the `shown` one, { key, at }; of one that is over, what took its place. -1: there is none. */
function nextItem(items, shown) {
  if (items.length === 0) return -1;
  const at = shown ? items.findIndex(({ key }) => key === shown.key) : -1;
  const next = at >= 0 ? at + 1 : shown?.at ?? 0;
  return next < items.length ? next : 0;
}

/**
 * Shows items one after the other. `itemsNow()` says which there are, `show(item, at, of)` shows one; item is null where there is none.
 * `timers`: { now(), set(act, ms), clear(timer) }.
 */
export class Round {
  constructor(itemsNow, show, timers) {
    Object.assign(this, { itemsNow, show, timers, shown: null, timer: null });
  }

  /** From the first one on, when it is next asked to look. */
  begin() {
    this.stop();
    this.shown = null;
    this.isNew = true;
    this.since = -Infinity;
  }

  stop() {
    this.timers.clear(this.timer);
    this.timer = null;
    this.hurries = false;
  }

  /** What there is may have changed: what is shown may be over, or something may have come. */
  look() {
    const items = this.itemsNow();
    if (!this.isNew && (this.shown ? items.some(({ key }) => key === this.shown.key) : items.length === 0)) return;
    const left = this.since + LEAST_MS - this.timers.now();
    if (left <= 0) this.#step();
    else if (!this.hurries) {
      this.#wait(left);
      this.hurries = true;
    }
  }

  #wait(ms) {
    this.stop();
    this.timer = this.timers.set(() => this.#step(), ms);
  }

  /** The next one, and so on until there is none. */
  #step() {
    const items = this.itemsNow();
    const at = nextItem(items, this.shown);
    this.stop();
    this.isNew = false;
    this.since = this.timers.now();
    this.shown = at < 0 ? null : { key: items[at].key, at };
    this.show(items[at] ?? null, at, items.length);
    if (at >= 0) this.#wait(EACH_MS);
  }
}

/** The figures that a commander needs at t; `isOver`: what is not done then will not be. */
export function wallFigures(run, t, found) {
  const { tasksDone, tasksTotal, failed } = figuresAt(run, t);
  const isOver = run.ended && t >= run.nowMs;
  const kind = isOver ? "undone" : "risk";
  return { done: tasksDone, total: tasksTotal, failed, isOver, risk: found.filter((one) => one.kind === kind).length };
}
