import { agentWords } from "./directives.js";
import { number } from "./dom.js";
import { fill, say } from "./language.js";
import { clockText } from "./time.js";
import { PRIORITIES } from "./story.js";
import { HELD, OFFLINE, OPEN, RESERVED } from "./words.js";

const AGAIN_MS = 1000; // between two questions for an order that is pending

const changes = (fields) => [["priority", (v) => say("priority {priority}", { priority: PRIORITIES[v] })], ["due_min", (v) => say("due {time}", { time: clockText(v * 60000) })],
  ["expires_min", (v) => say("expires {time}", { time: clockText(v * 60000) })], ["name", (v) => say("name {name}", { name: v })],
  ["note", (v) => say("note {note}", { note: v })]]
  .filter(([key]) => fields[key] !== undefined).map(([key, words]) => words(fields[key])).join(", ");

function whereWords({ area_km: corners, circle_km: circle }) {
  if (corners) return say("in an area of {n} corners", { n: corners.length });
  const [x, y, r] = circle;
  return say("within {r} km of {x}, {y} km", { r: number(r, 2), x: number(x, 1), y: number(y, 1) });
}

/** Where and for how long, and the name in brackets. */
function closureWords(lasting, limited, { until_in_min: min, name, ...where }) {
  const words = fill(min ? limited : lasting, { where: whereWords(where), min: min && number(min, 0) });
  return name ? `${words} (${name})` : words;
}

const place = (x, y, digits) => ({ x: number(x, digits), y: number(y, digits) });

/**
 * All that is particular to one kind of order. `words(order)`: what it asks for. `more`: what follows from it, told before it is
 * given. `directs`: it decides in the policy's place. `button`: shown on the card of a task or an agent (`on`) whose status passes `when`.
 */
const KINDS = {
  task_add: { words: ({ task }) => say("add a task at {x}, {y} km: {cost} km of range, {changes}", {
    ...place(task.x_km, task.y_km, 1), cost: number(task.cost_km, 1), changes: changes(task) }) },
  task_change: { words: (order) => say("change task {task}: {changes}", { task: order.task, changes: changes(order) }), on: "task", button: say("Change …") },
  task_resume: { words: (order) => say("resume task {task}", order), on: "task", button: say("Resume"), when: (status) => status === HELD },
  task_hold: { words: (order) => say("hold task {task}", order), more: say("nobody is sent to it until it is resumed"), on: "task", button: say("Hold"),
    when: (status) => [OPEN, RESERVED].includes(status) },
  task_cancel: { words: (order) => say("cancel task {task}", order), more: say("nobody will do it, and all who are on the way are called off"), on: "task",
    button: say("Cancel task") },
  agent_recall: { words: (order) => say("recall {agent}", order), more: say("it hands back what it is at and leaves the mission at once, from where it is"), on: "agent",
    button: say("Recall"), when: (status) => status !== OFFLINE },
  road_close: { words: (order) => closureWords(say("close the roads {where}"), say("close the roads {where} for {min} min"), order),
    more: say("all who are on the way to them go round, and pairs that cannot are called off") },
  road_open: { words: (where) => say("open the closed roads {where}", { where: whereWords(where) }) },
  zone_add: { words: (order) => closureWords(say("keep UAVs out of what is {where}"), say("keep UAVs out of what is {where} for {min} min"), order),
    more: say("all who are on the way through it fly around it, and pairs that cannot are called off") },
  zone_lift: { words: (order) => say("lift the zone {zone}", order) },
  pin: { directs: true, words: ({ agents, task }) => say(agents.length === 1 ? "let {agents} do task {task} with the best partner" : "let {agents} do task {task}", {
    agents: agentWords(agents), task }), more: say("nobody else is sent there; who is under way finishes first"), on: "task", button: say("Pin or forbid …"),
  when: (status) => status === OPEN },
  unpin: { directs: true, words: (order) => say("unpin task {task}", order) },
  forbid: { directs: true, words: (order) => say("never send {agent} to task {task}", order) },
  charge_now: { directs: true, words: ({ agents, charge }) => say(charge === undefined ? "charge {agents} now" : "charge {agents} now at charging point {charge}", {
    agents: agentWords(agents), charge }), more: say("it does nothing else before; what it is at it finishes first"), on: "uav", button: say("Charge now"),
  when: (status) => status !== OFFLINE },
  go_to: { directs: true, words: ({ agent, x_km: x, y_km: y }) => say("send {agent} to {x}, {y} km", { agent, ...place(x, y, 2) }),
    more: say("it waits there until it is released; what it is at it finishes first"), on: "agent", button: say("Go to …"),
    when: (status) => status !== OFFLINE },
  decide_now: { words: () => say("decide now"), more: say("all who are free are sent anew, and who is under way goes on") },
  release: { directs: true, words: ({ directive, words }) => say("release {what}", { what: words ?? directive }) },
  agent_leave: { words: (order) => say("let {agent} leave", order), more: say("it is sent nowhere any more, and goes when what it is at is done"), on: "agent",
    button: say("Let it leave") },
};

/** What an order asks for, as a sentence without its verb's subject: "cancel task 12". */
export function orderWords(order) {
  return KINDS[order.order]?.words(order) ?? order.order;
}

/** What follows from an order; undefined: nothing that its words leave out. */
export function orderEffect(order) {
  return KINDS[order.order]?.more;
}

/** What can be ordered of a task, an agent or a UAV (`on`) of that status: [button, kind] each. */
export function ordersOf(on, status) {
  return Object.entries(KINDS).filter(([, kind]) => kind.on === on && (kind.when?.(status) ?? true)).map(([name, kind]) => [kind.button, name]);
}

/** The token of an address "#token=..."; null: it has none. */
export function tokenOf(hash) {
  return new URLSearchParams(hash.replace(/^#/, "")).get("token") || null;
}

/**
 * Orders given on this page, the newest first: { id, order, words, at (mission time), state, note, task, agent }. state:
 * "pending", "taken", "refused", "withdrawn", "unanswered". Without a token nothing can be ordered. `changed` is called whenever one changes.
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

  /** What a directive would change at the newest decision, as text; null: that is not known, or it is none. */
  async whatIf(order) {
    if (!KINDS[order.order]?.directs) return null;
    try {
      const response = await this.ask("/what-if", { method: "POST", body: JSON.stringify(order), headers: { Authorization: `Bearer ${this.token}` } });
      return response.ok ? (await response.text()).trim() : null;
    } catch {
      return null;
    }
  }

  /** Sends an order; once more with the same id it is the same order. */
  async send(entry) {
    this.#set(entry, "pending", "");
    let answer = await this.#request("/orders", { method: "POST", body: JSON.stringify({ id: entry.id, ...entry.order, words: undefined }) });
    while (answer?.status === 202) {
      this.#set(entry, "pending", say("the mission has not answered yet"));
      await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
      answer = await this.#request(`/orders/${encodeURIComponent(entry.id)}`, {});
    }
    this.#take(entry, answer);
  }

  /** Takes back an order that waits for its tick. One that is answered before stays as it is answered. */
  async withdraw(entry) {
    entry.withdrawal = `${entry.id}-withdraw`;
    this.changed(entry);
    const answer = await this.#request("/orders", { method: "POST", body: JSON.stringify({ id: entry.withdrawal, order: "withdraw", withdraws: entry.id }) });
    if (answer) return;
    entry.withdrawal = null; // no connection: it may be tried again
    this.changed(entry);
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
    if (!answer) return this.#set(entry, "unanswered", say("no connection"));
    const { status, body } = answer;
    if (status === 200 && body.taken) {
      entry.task = body.taken.task ?? null;
      entry.agent = body.taken.agent ?? null;
      entry.taken = clockText(1000 * body.taken.sim_s);
      return this.#set(entry, "taken", say("taken at {time}", { time: entry.taken }));
    }
    if (entry.withdrawal && body.refused?.endsWith(` ${entry.withdrawal}`)) return this.#set(entry, "withdrawn", "");
    // 403 with a reason: of this order alone, which asks for another role.
    const barred = status === 401 || (status === 403 && !body.refused);
    if (barred) this.refused = true;
    const why = body.refused ?? (barred ? say("this page may not give orders") : body.error ?? say("the server answered {status}", { status }));
    return this.#set(entry, "refused", why);
  }

  #set(entry, state, note) {
    Object.assign(entry, { state, note });
    this.changed(entry);
  }
}
