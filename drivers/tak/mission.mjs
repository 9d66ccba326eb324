// The mission's own interfaces: what happens on its live page, and orders over HTTP (docs/guide/orders.md).
import { setTimeout as sleep } from "node:timers/promises";
import { Run } from "../../tools/report/page/run.js";

const LONGEST_WAIT_MS = 10_000;
const ANSWER_MS = 70_000;

export class Mission {
  #ended = new AbortController();
  #isKnown = null;

  /** `changed(run, isNew)` with each piece of news, `note(words)` of what goes wrong with the connection. */
  constructor({ url, token }, { changed, note }) {
    Object.assign(this, { url, token, changed, note, run: null, isOver: false });
    /** Resolves when the mission is known. */
    this.known = new Promise((resolve) => { this.#isKnown = resolve; });
  }

  close() {
    this.#ended.abort();
  }

  /** Follows the mission until it is over, or close(). A page that goes away is asked again. */
  async follow() {
    for (let wait = 500; !this.isOver && !this.#ended.signal.aborted; wait = Math.min(2 * wait, LONGEST_WAIT_MS)) {
      try {
        await this.#listen(() => { wait = 500; });
      } catch (error) {
        if (this.#ended.signal.aborted) return;
        this.note(`the mission at ${this.url} does not answer: ${error.cause?.code ?? error.message}; asking again`);
      }
      if (!this.isOver) await sleep(wait, null, { signal: this.#ended.signal }).catch(() => {});
    }
  }

  async #listen(heard) {
    const response = await fetch(`${this.url}/events`, { signal: this.#ended.signal });
    if (!response.ok) throw new Error(`status ${response.status}`);
    const decoder = new TextDecoder();
    let text = "";
    const reader = response.body.getReader();
    const stop = () => void reader.cancel().catch(() => {});
    // Node 18 forgets the signal of a fetch whose answer has begun.
    this.#ended.signal.addEventListener("abort", stop);
    try {
      for (let part = await reader.read(); !part.done; part = await reader.read()) {
        text += decoder.decode(part.value, { stream: true });
        for (let end = text.indexOf("\n\n"); end >= 0; end = text.indexOf("\n\n")) {
          this.#take(text.slice(0, end));
          text = text.slice(end + 2);
        }
        heard();
        // The page stays after the mission's end, for people; nothing comes any more.
        if (this.isOver) return;
      }
    } finally {
      this.#ended.signal.removeEventListener("abort", stop);
      stop();
    }
  }

  #take(said) {
    const [, kind] = /^event: (\w+)/m.exec(said) ?? [];
    if (kind === "bye") this.isOver = true;
    if (kind !== "chunk") return;
    const chunk = JSON.parse(said.slice(said.indexOf("\ndata: ") + "\ndata: ".length));
    const isNew = Boolean(chunk.scenario);
    if (isNew) this.run = new Run();
    if (!this.run) return;
    this.run.apply(chunk);
    this.changed(this.run, isNew);
    this.#isKnown();
    if (this.run.ended) this.isOver = true;
  }

  /** Gives an order: {task, agent} as the mission took it, or {refused: why}. The same id twice is the same order. */
  async order(order) {
    if (!this.token) return { refused: "this bridge has no token of the mission, so it only shows" };
    const headers = { Authorization: `Bearer ${this.token}`, "Content-Type": "application/json" };
    try {
      let response = await fetch(`${this.url}/orders`, { method: "POST", headers, body: JSON.stringify(order), signal: AbortSignal.timeout(ANSWER_MS) });
      for (let i = 0; response.status === 202 && i < 60; ++i) {
        await sleep(1000);
        response = await fetch(`${this.url}/orders/${encodeURIComponent(order.id)}`, { headers, signal: AbortSignal.timeout(ANSWER_MS) });
      }
      const body = await response.json().catch(() => ({}));
      return body.taken ?? { refused: body.refused ?? body.error ?? `the mission answered ${response.status}` };
    } catch (error) {
      return { refused: `the mission does not answer (${error.cause?.code ?? error.message})` };
    }
  }

  /** What `muster explain` says of "task:12" or "uav:3"; null: nothing. */
  async why(name) {
    const response = await fetch(`${this.url}/why/${name}`, { signal: AbortSignal.timeout(ANSWER_MS) }).catch(() => null);
    return response?.ok ? (await response.text()).trim() : null;
  }
}
