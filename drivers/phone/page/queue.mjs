// What was pressed and seen, until the mission's side has it: in the browser's storage, so that it outlives the page.

/** Places among it; the oldest go. */
const MOST_PLACES = 60;
/** A place sooner behind one that waits takes its place. */
const PLACES_MS = 10_000;
/** Sent at once. */
const MOST_SENT = 100;

export function newId() {
  return Array.from(crypto.getRandomValues(new Uint8Array(12)), (byte) => byte.toString(16).padStart(2, "0")).join("");
}

export class Queue {
  /** `storage`: localStorage, or null; `key`: of this link. */
  constructor(storage, key) {
    Object.assign(this, { storage, key, items: [] });
    try {
      const kept = JSON.parse(storage?.getItem(key) ?? "[]");
      if (Array.isArray(kept)) this.items = kept;
    } catch { /* not ours, or not allowed */ }
  }

  #keep() {
    try {
      if (this.items.length) this.storage?.setItem(this.key, JSON.stringify(this.items));
      else this.storage?.removeItem(this.key);
    } catch { /* full, or not allowed: the page has it */ }
  }

  add(item) {
    if (item.type === "place") this.#makeRoom(item);
    this.items.push({ id: newId(), ...item });
    this.#keep();
  }

  #makeRoom({ at_ms }) {
    const places = this.items.filter(({ type, isSent }) => type === "place" && !isSent);
    const [before, last] = places.slice(-2);
    const isClose = before && last && last.at_ms - before.at_ms < PLACES_MS && at_ms - last.at_ms < PLACES_MS;
    const gone = isClose ? last : places.length >= MOST_PLACES ? places[0] : null;
    if (gone) this.items = this.items.filter((item) => item !== gone);
  }

  /** What to send next, in order. It stays until it is settled, and is not changed any more. */
  next() {
    const sent = this.items.slice(0, MOST_SENT);
    for (const item of sent) item.isSent = true;
    return sent.map(({ isSent, ...item }) => item);
  }

  /** The other side has these: {id: "" or why it was not taken}. Returns them as [item, why]. */
  settle(results) {
    const isSettled = ({ id }) => Object.hasOwn(results, id);
    const settled = this.items.filter(isSettled).map((item) => [item, results[item.id]]);
    this.items = this.items.filter((item) => !isSettled(item));
    this.#keep();
    return settled;
  }

  /** Buttons that wait; places are of no concern to who pressed none. */
  get pressed() {
    return this.items.filter(({ type }) => type !== "place");
  }

  isWaiting(type, order) {
    return this.items.some((item) => item.type === type && item.order === order);
  }
}
