import { byId, element } from "./dom.js";
import { isWater } from "./coast.js";
import { agentsOfClass, directiveWords, directivesOf } from "./directives.js";
import { say, sayParts } from "./language.js";
import { taskName } from "./names.js";
import { OrderForm } from "./order_form.js";
import { Orders, orderEffect, orderWords, ordersOf, tokenOf } from "./orders.js";
import { statusAt, taskStatusAt } from "./run.js";
import { clockText } from "./time.js";
import { zoneAt } from "./layers/zones.js";
import { CANCELLED, DONE, EXPIRED, FAILED, OFFLINE, UAV } from "./words.js";

const KEPT = "muster-token";
/** Asks for the click on the map, by the button that was pressed before. */
const PICKED = { "order-add": say("Click the place of the new task on the map, or"), "order-road": say("Click the roads on the map, or"),
  "order-zone": say("Click the middle of the zone, or a zone to lift on the map, or"), "go-to": say("Click where it is to go on the map, or") };
/** What can be ordered of several at once. */
const TO_SEVERAL = ["task_hold", "task_resume", "task_cancel", "charge_now", "agent_recall", "agent_leave"];
const MARKS = { pending: "…", taken: "✓", refused: "×", withdrawn: "↶", unanswered: "!" };

/** The token of the address, or of this tab before it was loaded again; null on pages that may not give orders. */
function tokenOfPage() {
  const token = tokenOf(location.hash);
  // The address is passed on, the token is not.
  if (token) history.replaceState(null, "", `#${location.hash.slice(1).split("&").filter((part) => !part.startsWith("token=")).join("&")}`);
  try {
    if (token) sessionStorage.setItem(KEPT, token);
    return token ?? sessionStorage.getItem(KEPT);
  } catch {
    return token; // a browser that keeps nothing
  }
}

/** Hands on a live mission: what orders can be given where, each asked back, and what became of them. */
export class Control {
  constructor(state, clock, map) {
    this.state = state;
    this.clock = clock;
    this.map = map;
    this.orders = new Orders(state.live ? tokenOfPage() : null, (entry) => this.#onOrder(entry));
    this.form = new OrderForm((order) => this.#words(order), (order) => this.orders.give(order, state.run.nowMs), (order) => this.orders.whatIf(order));
    this.form.closed = () => this.map.mark(null);
    this.picks = "order-add"; // what the next click on the map is for
    byId("order-add").addEventListener("click", () => this.togglePick());
    for (const button of ["order-road", "order-zone"]) byId(button).addEventListener("click", () => this.togglePick(button));
    byId("order-decide").addEventListener("click", () => this.form.simple({ order: "decide_now" }));
    byId("pick-stop").addEventListener("click", () => this.#stopPicking());
    this.taken = null; // what the map tells clicks to while they are an order's
    this.corners = null; // of an area that is being drawn, in metres
    byId("pick-area").addEventListener("click", () => this.#area());
    byId("pick-enter").addEventListener("click", () => this.#add({ x: state.run.scenario.width_m / 2, y: state.run.scenario.height_m / 2 }));
    state.on("run data selection", () => this.draw());
    clock.subscribe(() => this.#drawCard());
  }

  get allowed() {
    const { run, live } = this.state;
    return Boolean(live && run && !run.ended && this.orders.allowed);
  }

  draw() {
    const { live, run } = this.state;
    const badge = byId("control-state");
    badge.hidden = !live || !run || run.ended;
    badge.dataset.state = this.allowed ? "control" : "read-only";
    badge.textContent = say(this.allowed ? "control" : "read-only");
    badge.title = say(this.allowed ? "This page gives orders to the mission" : "Orders need the address that muster run --control tells");
    byId("order-add").hidden = !this.allowed;
    byId("order-road").hidden = !this.allowed || !run.scenario.roads;
    byId("order-zone").hidden = !this.allowed || !run.scenario.air;
    byId("order-decide").hidden = !this.allowed;
    byId("tab-orders").hidden = !this.allowed && this.orders.list.length === 0;
    if (!this.allowed && this.#picking) this.#stopPicking();
    this.map.drops = this.allowed ? (...dropped) => this.#dropped(...dropped) : null;
    if (run) this.#findAdded();
    this.#drawCard();
  }

  /** The next click on the map is the place of a new task, of roads or of a zone; or no longer. */
  togglePick(button = "order-add") {
    if (!this.allowed) return;
    const again = this.#picking && this.picks === button;
    if (this.#picking) this.#stopPicking();
    if (again) return;
    this.picks = button;
    this.state.look("map");
    this.#pick();
  }

  /** The next click on the map is where the agent is to go. */
  #goTo(agent) {
    if (this.#picking) this.#stopPicking();
    this.going = agent.label;
    this.picks = "go-to";
    this.state.look("map");
    this.#pick();
  }

  /** An agent was dragged to a task, a charging point (UAVs) or a place. */
  #dropped(agent, goal, place) {
    const { run } = this.state;
    if ([FAILED, OFFLINE].includes(statusAt(agent, run.nowMs))) return;
    if (goal?.type === "task" && this.#isOpen(run.tasks[goal.id])) this.form.pin(run.tasks[goal.id], this.#crews(run), agent.label);
    else if (goal?.type === "charge") this.form.simple({ order: "charge_now", agents: [agent.label], charge: goal.id });
    else this.#sendTo(agent.label, place);
  }

  #sendTo(agent, place) {
    this.map.mark(place);
    this.form.simple({ order: "go_to", agent, x_km: Math.round(place.x) / 1000, y_km: Math.round(place.y) / 1000 });
  }

  #isOpen(task) {
    return ![DONE, EXPIRED, CANCELLED].includes(taskStatusAt(task, this.state.run.nowMs));
  }

  /** Names of the UAVs and of the workers that are there. */
  #crews(run) {
    const isThere = (agent) => ![OFFLINE, FAILED].includes(statusAt(agent, run.nowMs));
    return [0, 1].map((kind) => agentsOfClass(run, kind).filter(isThere).map(({ label }) => label));
  }

  /** Whether the next click on the map is an order's. */
  get #picking() {
    return this.taken !== null && this.map.picking === this.taken;
  }

  #pick() {
    this.taken = (place) => this.#add(place);
    this.map.pick(this.taken, () => {
      this.taken = null;
      this.corners = null;
      this.#showPicking(false);
    });
    this.#showPicking(true);
  }

  #stopPicking() {
    this.map.pick(null);
    this.map.mark(null);
  }

  /** Begins to draw an area, or uses the one that is drawn. */
  #area() {
    if (this.corners === null) {
      this.corners = [];
      return this.#showPicking(true);
    }
    const { corners } = this;
    this.#stopPicking();
    this.map.mark(null, corners);
    if (this.picks === "order-road") this.form.roads(null, corners);
    else this.form.zone(null, null, corners);
  }

  #showPicking(on) {
    byId("pick-hint").hidden = !on;
    byId("pick-what").textContent = this.corners ? say("Click the corners of the area, one after the other, on the map, or") : PICKED[this.picks];
    byId("pick-enter").hidden = this.corners !== null;
    byId("pick-area").hidden = ["order-add", "go-to"].includes(this.picks) || (this.corners !== null && this.corners.length < 3);
    byId("pick-area").textContent = this.corners ? say("Use these {n} corners", { n: this.corners.length }) : say("draw an area");
    byId(this.picks)?.setAttribute("aria-pressed", String(on));
  }

  #add(place) {
    if (this.corners) {
      this.corners.push(place);
      this.map.mark(null, this.corners);
      return this.#showPicking(true);
    }
    this.#stopPicking();
    this.map.mark(place);
    if (this.picks === "order-road") this.form.roads(place);
    else if (this.picks === "go-to") this.#sendTo(this.going, place);
    else if (this.picks === "order-zone") this.form.zone(place, zoneAt(this.state.run, this.clock.t, place));
    else this.form.add(this.state.run, place);
  }

  /** What is asked back: with what speaks against it. */
  #words(order) {
    const { run } = this.state;
    const words = orderWords(order);
    if (order.order === "task_add" && isWater(run, order.task.x_km * 1000, order.task.y_km * 1000)) return say("{order}. The place is in water", { order: words });
    const effect = orderEffect(order);
    return effect ? `${words}: ${effect}` : words;
  }

  /** What can be ordered of what is selected, at the newest time: [button, act] each. */
  #choices(run, selected) {
    const released = directivesOf(run, selected, run.nowMs).map((one) => [say("Release: {what}", { what: one.words }),
      () => this.form.simple({ order: "release", directive: one.order, words: directiveWords(one) })]);
    if (selected.type === "task") return [...this.#taskChoices(run, run.tasks[selected.id]), ...released];
    if (selected.type !== "agent") return [];
    const agent = run.agents[selected.index];
    const status = statusAt(agent, run.nowMs);
    if (status === FAILED) return released;
    const acts = { go_to: () => this.#goTo(agent), charge_now: () => this.form.simple({ order: "charge_now", agents: [agent.label] }) };
    const kinds = [...(agent.kind === UAV ? ordersOf("uav", status) : []), ...ordersOf("agent", status)];
    return [...kinds.map(([text, order]) => [text, acts[order] ?? (() => this.form.simple({ order, agent: agent.label }))]), ...released];
  }

  #taskChoices(run, task) {
    const status = taskStatusAt(task, run.nowMs);
    if (!this.#isOpen(task)) return [];
    const acts = { task_change: () => this.form.change(run, task), pin: () => this.form.pin(task, this.#crews(run)) };
    return ordersOf("task", status).map(([text, order]) => [text, acts[order] ?? (() => this.form.simple({ order, task: task.id }))]);
  }

  /** What can be ordered of several that are selected: [button, act] each, which orders it of all of whom it can be ordered. */
  #choicesOfAll(run, items) {
    const byText = new Map();
    for (const item of items) {
      for (const [text, order] of this.#alike(run, item)) byText.set(text, [...(byText.get(text) ?? []), order]);
    }
    return [...byText].filter(([, orders]) => orders.length > 1).map(([text, orders]) => [`${text}: ${orders.length}`, () => this.form.several(orders)]);
  }

  /** Orders to one of several: those that have nothing to write. */
  #alike(run, { type, index, id }) {
    const named = (on, status, who) => ordersOf(on, status).filter(([, order]) => TO_SEVERAL.includes(order))
      .map(([text, order]) => [text, { order, ...who }]);
    if (type === "task") return this.#isOpen(run.tasks[id]) ? named("task", taskStatusAt(run.tasks[id], run.nowMs), { task: id }) : [];
    if (type !== "agent") return [];
    const { kind, label } = run.agents[index], status = statusAt(run.agents[index], run.nowMs);
    if (status === FAILED) return [];
    return [...(kind === UAV ? named("uav", status, { agents: [label] }) : []), ...named("agent", status, { agent: label })];
  }

  #drawCard() {
    const { run, selected, others, allSelected } = this.state;
    const isAllowed = this.allowed && selected !== null;
    const choices = isAllowed ? this.#choices(run, selected) : [];
    const ofAll = isAllowed && others.length > 0 ? this.#choicesOfAll(run, allSelected) : [];
    const key = JSON.stringify([allSelected, choices.map(([text]) => text), ofAll.map(([text]) => text)]);
    if (key === this.key) return; // what has the focus stays
    this.key = key;
    for (const [id, list] of [["card-orders", choices], ["card-all", ofAll]]) {
      byId(id).hidden = list.length === 0;
      byId(id).replaceChildren(...list.map(([text, act]) => element("button", { type: "button", onclick: act }, text)));
    }
  }

  #onOrder(entry) {
    this.latest = entry;
    this.#drawLatest();
    this.draw();
    this.state.emit("orders");
  }

  #drawLatest() {
    const latest = byId("order-latest");
    latest.hidden = false;
    latest.dataset.state = this.latest.state;
    latest.replaceChildren(...this.#told(this.latest, false));
  }

  /** An order is taken before the page hears of the task that it brought. */
  #findAdded() {
    const { tasks } = this.state.run;
    const found = this.orders.list.filter((entry) => entry.task != null && !entry.known && tasks[entry.task] && !tasks[entry.task].vacant);
    if (found.length === 0) return;
    for (const entry of found) entry.known = true;
    this.#drawLatest();
    this.state.emit("orders");
  }

  /** The orders given here, for their tab. */
  table() {
    if (this.orders.list.length === 0) return [element("p", { class: "empty" }, say("No orders were given on this page."))];
    return [element("ol", { id: "order-list" }, ...this.orders.list.map((entry) => element("li", { "data-state": entry.state }, ...this.#told(entry, true))))];
  }

  #told(entry, withTime) {
    const item = { type: "task", id: entry.task };
    return [element("b", { "aria-hidden": "true" }, MARKS[entry.state]), withTime ? ` ${clockText(entry.at)} ` : ` ${say("Order:")} `, entry.words, ": ",
      element("b", {}, say(entry.state === "unanswered" ? "no answer" : entry.state)),
      entry.taken ? `, ${say("at {time}", { time: entry.taken })}` : entry.note ? `, ${entry.note}` : "",
      ...(entry.known && entry.order.order === "task_add" ? [" ", ...sayParts("as {task}", {
        task: element("button", { type: "button", class: "name", onclick: () => this.state.flyTo(item) }, taskName(entry.task)) })] : []),
      ...(entry.state === "pending" ? [" ", element("button", { type: "button", class: "undo", disabled: Boolean(entry.withdrawal),
        title: say("Take the order back, as long as the mission has not answered it"), onclick: () => this.orders.withdraw(entry) }, say("Undo"))] : []),
      ...(entry.state === "unanswered" ? [" ", element("button", { type: "button", onclick: () => this.orders.send(entry) }, say("Send again"))] : [])];
  }
}
