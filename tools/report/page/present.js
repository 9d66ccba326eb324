import { loudAlerts } from "./alert_marks.js";
import { agentsWithAlerts } from "./attention.js";
import { CHARGING_POINT, OVER, Squares, classOfTask } from "./clusters.js";
import { placeAt, statusAt, taskStatusAt } from "./run.js";
import { PRIORITIES } from "./story.js";
import { isSame } from "./state.js";
import { rowAt } from "./time.js";
import { OFFLINE, UNREPORTED } from "./words.js";

const EMERGENCY = PRIORITIES.length - 1;

/** What an item is as a selection. */
export function selectedOf({ agent, task, point }) {
  if (agent) return { type: "agent", index: agent.index };
  return task ? { type: "task", id: task.id } : { type: "charge", id: point.id };
}

/** The box around where an agent has gone for `trailMs`, and where it goes: metres. */
function wayBox({ agent: { stops, spans }, place }, t, trailMs) {
  const box = { west: Math.min(place.x, place.toX), east: Math.max(place.x, place.toX),
    south: Math.min(place.y, place.toY), north: Math.max(place.y, place.toY) };
  const end = spans[2 * (rowAt(spans, 2, t) + 1)] ?? Infinity;
  for (let i = 4 * Math.max(0, rowAt(stops, 4, t - trailMs)); i < stops.length && stops[i] <= end; i += 4) {
    box.west = Math.min(box.west, stops[i + 1]);
    box.east = Math.max(box.east, stops[i + 1]);
    box.south = Math.min(box.south, stops[i + 2]);
    box.north = Math.max(box.north, stops[i + 2]);
  }
  return box;
}

/** Who and what the map shows at a time, and in which squares: found again when that changes, and not while the map moves. */
export class Present {
  constructor(state) {
    this.state = state;
    this.t = null;
    this.items = [];
    state.on("run data classes layers trails rival", () => { this.t = null; });
    state.on("selection", () => this.#mark());
  }

  /** Looks at time t; whether that was necessary. */
  look(t) {
    if (this.t === t) return false;
    this.t = t;
    this.items = [...this.#agents(t), ...this.#tasks(t), ...this.#points()];
    this.agents = this.items.filter(({ agent }) => agent).length;
    this.#mark();
    return true;
  }

  #mark() {
    const { selected, allSelected } = this.state;
    this.chosen = -1;
    this.items.forEach((item, i) => {
      const found = allSelected.find((one) => isSame(one, selectedOf(item)));
      item.chosen = found !== undefined;
      if (found && found === selected) this.chosen = i;
    });
    this.made = null;
  }

  /** What is selected stands alone, and so does what is `loud` at that level: emergencies, and of the agents with alerts those that stand out. */
  #part(level) {
    const loud = loudAlerts(this.items.filter(({ agent, urgent }) => agent && urgent), level);
    for (const item of this.items) {
      item.loud = item.urgent && (!item.agent || item.chosen || loud.has(item));
      item.alone = item.loud || item.chosen;
    }
  }

  /** Of a cluster's items the first after what is selected, and after the last again the first. */
  after(items) {
    return items.find((item) => this.items.indexOf(item) > this.chosen) ?? items[0];
  }

  /** Whether an agent's way, past and ahead, may be seen in a box. */
  wayMeets(item, box) {
    item.way ??= wayBox(item, this.t, this.state.trailMs);
    return item.way.east >= box.west && item.way.west <= box.east && item.way.north >= box.south && item.way.south <= box.north;
  }

  squares(level) {
    if (this.made?.level !== level) {
      this.#part(level);
      this.made = { level, squares: new Squares(this.items, level) };
    }
    return this.made.squares;
  }

  *#agents(t) {
    const { run, classes } = this.state;
    const alerts = agentsWithAlerts(run, t);
    for (const agent of run.agents) {
      if (!classes[agent.kind]) continue;
      const status = statusAt(agent, t);
      if (status === OFFLINE) continue;
      const place = placeAt(agent, t);
      if (place) yield { x: place.x, y: place.y, of: agent.kind, urgent: alerts.has(agent), order: alerts.get(agent), agent, status, place };
    }
  }

  *#tasks(t) {
    const { run, off } = this.state;
    if (off.has("tasks")) return;
    for (const task of run.tasks) {
      const status = taskStatusAt(task, t);
      if (status === UNREPORTED) continue;
      const of = classOfTask(status);
      yield { x: task.x, y: task.y, of, urgent: of !== OVER && task.priority === EMERGENCY, task, status };
    }
  }

  *#points() {
    const { run, off } = this.state;
    if (off.has("charging")) return;
    for (const point of run.charging) yield { x: point.x, y: point.y, of: CHARGING_POINT, urgent: false, point };
  }
}
