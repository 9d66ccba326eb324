import { number } from "./dom.js";
import { clockText } from "./time.js";
import { PRIORITIES } from "./story.js";

const AGAIN_MS = 1000; // between two questions for an order that is pending

/** What an order asks for, as a sentence without its verb's subject: "cancel task 12". */
export function orderWords(order) {
  const { task, agent } = order;
  const changes = (fields) => [["priority", (v) => `priority ${PRIORITIES[v]}`], ["due_min", (v) => `due ${clockText(v * 60000)}`],
    ["expires_min", (v) => `expires ${clockText(v * 60000)}`], ["name", (v) => `name ${v}`]]
    .filter(([key]) => fields[key] !== undefined).map(([key, words]) => words(fields[key])).join(", ");
  switch (order.order) {
    case "task_add": return `add a task at ${number(task.x_km, 1)}, ${number(task.y_km, 1)} km: ${number(task.cost_km, 1)} km of range, ${changes(task)}`;
    case "task_change": return `change task ${task}: ${changes(order)}`;
    case "task_cancel": return `cancel task ${task}`;
    case "task_hold": return `hold task ${task}`;
    case "task_resume": return `resume task ${task}`;
    case "agent_recall": return `recall ${agent}`;
    case "agent_leave": return `let ${agent} leave`;
    default: return order.order;
  }
}

/** The token of an address "#token=..."; null: it has none. */
export function tokenOf(hash) {
  return new URLSearchParams(hash.replace(/^#/, "")).get("token") || null;
}

/**
 * Orders given on this page, the newest first: { id, order, words, at (mission time), state, note, task, agent }. state:
 * "pending", "taken", "refused", "unanswered". Without a token nothing can be ordered. `changed` is called whenever one changes.
 */
export class Orders {
  constructor(token, changed, ask = (...request) => fetch(...request)) {
    this.token = token;
    this.changed = changed;
    this.ask = ask;
    this.list = [];
    this.refused = false; // the token
    this.prefix = `page-${Math.floor(Math.random() * 2 ** 32).toString(36)}`;
  }

  get allowed() {
    return Boolean(this.token) && !this.refused;
  }

  /** Gives an order at mission time `at`; resolves when it is known what became of it. */
  give(order, at) {
    const entry = { id: `${this.prefix}-${this.list.length + 1}`, order, words: orderWords(order), at, state: "pending", note: "" };
    this.list.unshift(entry);
    return this.send(entry);
  }

  /** Sends an order; once more with the same id it is the same order. */
  async send(entry) {
    this.#set(entry, "pending", "");
    let answer = await this.#request("/orders", { method: "POST", body: JSON.stringify({ id: entry.id, issuer: "page", ...entry.order }) });
    while (answer?.status === 202) {
      this.#set(entry, "pending", "the mission has not answered yet");
      await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
      answer = await this.#request(`/orders/${encodeURIComponent(entry.id)}`, {});
    }
    this.#take(entry, answer);
  }

  async #request(address, options) {
    try {
      const response = await this.ask(address, { ...options, headers: { Authorization: `Bearer ${this.token}`, "Content-Type": "application/json" } });
      return { status: response.status, body: await response.json().catch(() => ({})) };
    } catch {
      return null;
    }
  }

  #take(entry, answer) {
    if (!answer) return this.#set(entry, "unanswered", "no connection");
    const { status, body } = answer;
    if (status === 200 && body.taken) {
      entry.task = body.taken.task ?? null;
      entry.agent = body.taken.agent ?? null;
      return this.#set(entry, "taken", `taken at ${clockText(1000 * body.taken.sim_s)}`);
    }
    if (status === 401 || status === 403) this.refused = true;
    const why = status === 401 || status === 403 ? "this page may not give orders" : body.refused ?? body.error ?? `the server answered ${status}`;
    return this.#set(entry, "refused", why);
  }

  #set(entry, state, note) {
    Object.assign(entry, { state, note });
    this.changed(entry);
  }
}
