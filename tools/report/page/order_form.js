import { byId, element, number } from "./dom.js";
import { say } from "./language.js";
import { PRIORITIES } from "./story.js";

const DEFAULT_COST_KM = 3;
const DEFAULT_RADIUS_KM = 0.1;
const DEFAULT_ZONE_KM = 1;

function field(label, input) {
  return element("label", { class: "field" }, element("span", {}, label), input);
}

const decimal = (name, value, more = {}) => element("input", { name, type: "number", step: "any", value: value === null ? "" : String(value), autocomplete: "off", ...more });

function priorityChoice(chosen) {
  const select = element("select", { name: "priority" }, ...PRIORITIES.map((name, i) => element("option", { value: i, selected: i === chosen }, name)));
  return field(say("Priority"), select);
}

const times = () => [field(say("Due in, minutes from now"), decimal("due", null, { min: 0 })), field(say("Expires in, minutes from now"), decimal("expires", null, { min: 0 }))];

/** Fields for what people call a task, and what they should know of it. */
function namesOf({ name = "", note = "" }) {
  const text = (key, value, maxlength) => element("input", { name: key, type: "text", maxlength, value, autocomplete: "off" });
  return [field(say("Name"), text("name", name, 80)), field(say("Note"), text("note", note, 500))];
}

/** Fields for a circle around a place, { x, y } in metres; none for an area that is drawn. */
function circleFields(place, label, radius_km) {
  const km = (m) => Math.round(m) / 1000;
  return place ? [field(say("East, km"), decimal("x", km(place.x))), field(say("North, km"), decimal("y", km(place.y))), field(label, decimal("radius", radius_km, { min: 0 }))] : [];
}

/** The keys of an order that say where: the area's corners, or the circle that was written; null: that is none. */
function whereOf(values, area) {
  if (area) return { area_km: area.map(({ x, y }) => [Math.round(x) / 1000, Math.round(y) / 1000]) };
  return values.x === null || values.y === null || !(values.radius >= 0.001) ? null : { circle_km: [values.x, values.y, values.radius] };
}

/**
 * The dialog in which an order is written and asked back. `ask(title, parts, read)`: shows `parts`; `read(values)` gives the
 * order, or a text that says what is wrong. Then what is ordered is asked once more, with what `effect(order)` promises to say of
 * its consequences, and `send(order)` called.
 */
export class OrderForm {
  constructor(words, send, effect) {
    this.words = words;
    this.send = send;
    this.effect = effect;
    this.dialog = byId("order");
    this.form = byId("order-form");
    this.dialog.addEventListener("close", () => this.closed?.());
  }

  /** A new task at a place, { x, y } in metres. */
  add(run, place) {
    const km = (m) => Math.round(m) / 1000;
    this.#write(say("Add a task"), [
      field(say("East, km"), decimal("x", km(place.x))), field(say("North, km"), decimal("y", km(place.y))),
      priorityChoice(1), field(say("Takes, km of range"), decimal("cost", DEFAULT_COST_KM, { min: 0 })),
      ...times(), ...namesOf({})], (values) => {
      const task = { x_km: values.x, y_km: values.y, cost_km: values.cost, priority: values.priority, ...timesOf(values, run) };
      const { width_m: w, height_m: h } = run.scenario;
      if (!(task.x_km >= 0 && task.x_km * 1000 <= w && task.y_km >= 0 && task.y_km * 1000 <= h)) {
        return say("The place is outside the area of {w} by {h} km.", { w: number(w / 1000), h: number(h / 1000) });
      }
      if (!(task.cost_km > 0)) return say("Sensing takes some range: more than 0 km.");
      for (const key of ["name", "note"]) if (values[key]) task[key] = values[key];
      return { order: "task_add", task };
    });
  }

  /** Roads to close or open around a place, { x, y } in metres, or in an area of such corners. */
  roads(place, area) {
    const what = element("select", { name: "what" }, element("option", { value: "road_close" }, say("Close")), element("option", { value: "road_open" }, say("Open|roads")));
    this.#write(say("Close or open roads"), [field(say("Do what"), what), ...circleFields(place, say("All roads within, km"), DEFAULT_RADIUS_KM), field(say("To close: for so many minutes"), decimal("minutes", null, { min: 0 })),
      field(say("To close: name"), element("input", { name: "name", type: "text", maxlength: 80, autocomplete: "off" }))], (values) => {
      const where = whereOf(values, area);
      if (!where) return say("A place and a distance of at least a metre are needed.");
      const order = { order: values.what, ...where };
      if (values.what === "road_open") return order;
      if (values.minutes !== null && !(values.minutes > 0)) return say("Roads are closed for more than 0 minutes.");
      if (values.minutes !== null) order.until_in_min = values.minutes;
      if (values.name) order.name = values.name;
      return order;
    });
  }

  /**
   * A zone to add around a place, { x, y } in metres, or in an area of such corners; or to lift: the one that the place lies in,
   * if any.
   */
  zone(place, inside, area) {
    const what = element("select", { name: "what" }, element("option", { value: "zone_add" }, say("Add a zone")));
    if (inside) what.append(element("option", { value: "zone_lift" }, say("Lift {zone}", { zone: inside.name || inside.order })));
    this.#write(say("Zone that UAVs keep out of"), [field(say("Do what"), what), ...circleFields(place, say("Radius, km"), DEFAULT_ZONE_KM), field(say("To add: for so many minutes"), decimal("minutes", null, { min: 0 })),
      field(say("To add: name"), element("input", { name: "name", type: "text", maxlength: 80, autocomplete: "off" }))], (values) => {
      if (values.what === "zone_lift") return { order: "zone_lift", zone: inside.order };
      const where = whereOf(values, area);
      if (!where) return say("A place and a radius of at least a metre are needed.");
      if (values.minutes !== null && !(values.minutes > 0)) return say("A zone holds for more than 0 minutes.");
      const order = { order: "zone_add", ...where };
      if (values.minutes !== null) order.until_in_min = values.minutes;
      if (values.name) order.name = values.name;
      return order;
    });
  }

  /** Another priority, due time, expiry or name of a task. */
  change(run, task) {
    this.#write(say("Change task {id}", { id: task.id }), [priorityChoice(task.priority ?? 1), ...times(), ...namesOf(task)], (values) => {
      const order = { order: "task_change", task: task.id, ...timesOf(values, run) };
      if (values.priority !== (task.priority ?? 1)) order.priority = values.priority;
      for (const key of ["name", "note"]) if (values[key] !== (task[key] ?? "")) order[key] = values[key];
      return Object.keys(order).length === 2 ? say("Nothing is other than it was.") : order;
    });
  }

  /** Who is to do a task, or must not: the names of the UAVs and workers that are there. `chosen`: one of them. */
  pin(task, [uavs, workers], chosen = "") {
    const option = (one) => element("option", { value: one, selected: one === chosen }, one);
    const choice = (name, any, names) => element("select", { name }, element("option", { value: "" }, any), ...names.map(option));
    const what = element("select", { name: "what" }, element("option", { value: "pin" }, say("These do it")), element("option", { value: "forbid" }, say("This one must not do it")));
    this.#write(say("Who does task {id}", { id: task.id }), [field(say("Do what"), what), field(say("UAV"), choice("uav", say("the best"), uavs)), field(say("Worker"), choice("worker", say("the best"), workers))], (values) => {
      const agents = [values.uav, values.worker].filter(Boolean);
      if (agents.length === 0) return say("A UAV, a worker or both are needed.");
      if (values.what === "pin") return { order: "pin", task: task.id, agents };
      return agents.length === 1 ? { order: "forbid", task: task.id, agent: agents[0] } : say("One agent at a time is forbidden a task.");
    });
  }

  /** An order that has nothing to write. */
  simple(order) {
    this.#ask(order, null);
  }

  /** Several of them, asked back together. */
  several(orders) {
    this.#show(say("Give these {n} orders?", { n: orders.length }), [element("ul", { class: "asked" }, ...orders.map((order) => element("li", {}, this.words(order))))], [
      [say("Give the orders"), () => {
        this.dialog.close();
        for (const order of orders) this.send(order);
      }], [say("Cancel"), () => this.dialog.close()]]);
  }

  #write(title, parts, read) {
    const problem = element("p", { class: "wrong", role: "alert" });
    this.#show(title, [...parts, problem], [[say("Next|order"), () => {
      const order = read(this.#values());
      if (typeof order === "string") problem.textContent = order;
      else this.#ask(order, () => this.#write(title, parts, read));
    }], [say("Cancel"), () => this.dialog.close()]]);
  }

  /** What is ordered is asked back; `back` leads to where it was written. */
  #ask(order, back) {
    const words = this.words(order);
    const effect = element("pre", { class: "effect", "aria-live": "polite", hidden: true });
    this.effect(order).then((text) => Object.assign(effect, { hidden: !text, textContent: text ?? "" }));
    this.#show(say("Give this order?"), [element("p", { class: "asked" }, `${words[0].toUpperCase()}${words.slice(1)}.`), effect], [
      [say("Give the order"), () => {
        this.dialog.close();
        this.send(order);
      }], back ? [say("Back"), back] : null, [say("Cancel"), () => this.dialog.close()]]);
  }

  #values() {
    const data = new FormData(this.form);
    const text = (name) => String(data.get(name) ?? "").trim();
    const numeric = (name) => (String(data.get(name) ?? "").trim() === "" ? null : Number(data.get(name)));
    return { x: numeric("x"), y: numeric("y"), cost: numeric("cost"), priority: numeric("priority"), due: numeric("due"), expires: numeric("expires"),
      what: data.get("what"), uav: data.get("uav"), worker: data.get("worker"), radius: numeric("radius"), minutes: numeric("minutes"),
      name: text("name"), note: text("note") };
  }

  #show(title, parts, buttons) {
    byId("order-title").textContent = title;
    const made = buttons.filter(Boolean).map(([text, act], i) => element("button", { type: i === 0 ? "submit" : "button", class: i === 0 ? "primary" : null,
      onclick: (event) => {
        event.preventDefault();
        act();
      } }, text));
    this.form.replaceChildren(...parts, element("div", { class: "buttons" }, ...made));
    if (!this.dialog.open) this.dialog.showModal();
    (this.form.querySelector("select, input") ?? made[0]).focus();
  }
}

/** Minutes of mission time of what was written as minutes from now. */
function timesOf({ due, expires }, run) {
  const now = run.nowMs / 60000;
  const at = (minutes) => Math.round(100 * (now + minutes)) / 100;
  return { ...(due === null ? {} : { due_min: at(due) }), ...(expires === null ? {} : { expires_min: at(expires) }) };
}

