import { oncePerFrame } from "./canvas.js";
import { ChartTable } from "./chart_table.js";
import { describe } from "./describe.js";
import { directiveWords, directivesOf } from "./directives.js";
import { byId, element, isolated, number } from "./dom.js";
import { itemOf, nameOf } from "./link.js";
import { placeWords } from "./place.js";
import { reasonAt, storyOf } from "./reasons.js";
import { decisionAt, placeAt } from "./run.js";
import { PRIORITIES, activities, agentNext, agentNow, arrivalAt, commandWords, commandsByTask, commandsOf, taskNow } from "./story.js";
import { clockText, localWords, timeText } from "./time.js";
import { DONE, FAILED, MOVING, OFFLINE, OPEN, UAV } from "./words.js";

const km = (m) => `${number(m / 1000, 1)} km`;
const way = (m) => (m < 1000 ? `${number(m)} m` : km(m));
const MOST_RANGE_POINTS = 600;

/** When a task was reported, is due and expires, and how much it matters. */
function timeFacts(run, task) {
  const facts = [["priority", PRIORITIES[task.priority]], ["reported", timeText(run, task.reported)]];
  if (task.due !== null) facts.push(["due", `sensing should begin by ${timeText(run, task.due)}`]);
  if (task.expires !== null) facts.push(["expires", `sensing must begin before ${timeText(run, task.expires)}`]);
  return facts;
}

/** "in 6:30" */
function within(ms) {
  const s = Math.max(0, Math.round(ms / 1000));
  return s >= 3600 ? `in ${clockText(ms)}` : `in ${Math.floor(s / 60)}:${String(s % 60).padStart(2, "0")}`;
}

export function siteName(site) {
  return site.charging ? `charging point ${site.site}` : `task ${site.site}`;
}

/** `muster explain` writes task:17 where the page writes task 17. */
const taskWords = (line) => line.replace(/\btask:(\d+)/g, "task $1");

/** What is known of the selected agent, task or charging point at the clock's time. */
export class Card {
  constructor(state, clock) {
    this.state = state;
    this.clock = clock;
    this.box = byId("card");
    this.facts = byId("card-facts");
    this.draw = oncePerFrame(() => this.#draw());
    clock.subscribe(this.draw);
    state.on("run data selection", this.draw);
    byId("card-close").addEventListener("click", () => state.select(null));
  }

  #draw() {
    const { run, selected } = this.state;
    this.box.hidden = !run || !selected;
    byId("card-hint").hidden = !this.box.hidden;
    if (this.box.hidden) {
      this.shown = null;
      return;
    }
    const t = this.clock.t;
    const now = this.#now(run, selected, t);
    const local = localWords(run, t);
    if (local) now.facts.push(["time", local]);
    byId("card-title").textContent = now.title;
    byId("selection").textContent = `${now.title}: ${now.state}`;
    const key = JSON.stringify(now.facts);
    if (key !== this.factsKey) {
      this.factsKey = key;
      this.facts.replaceChildren(...now.facts.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, ...this.#linked(run, value))]));
    }
    this.#others(run, t);
    this.#why(run, selected, t);
    const shown = `${run.name} ${nameOf(run, selected)} ${run.decisions.length} ${run.activities.length} ${run.ended}`;
    if (shown !== this.shown) {
      const other = this.shown?.split(" ")[1] !== nameOf(run, selected);
      this.shown = shown;
      byId("card-more").replaceChildren(...this.#more(run, selected));
      if (other) this.box.scrollTop = 0;
    }
    const cursor = byId("range-cursor");
    cursor?.setAttribute("transform", `translate(${(300 * t) / run.limitMs} 0)`);
  }

  /** What else is selected: a line for each, which makes it the one that this card is about, or selects it no longer. */
  #others(run, t) {
    const { others } = this.state;
    const words = others.map((item) => describe(run, item, t));
    const key = JSON.stringify(words);
    if (key === this.othersKey) return;
    this.othersKey = key;
    byId("card-others").hidden = others.length === 0;
    byId("card-others").replaceChildren(element("h3", {}, `Selected too: ${others.length}`), element("ul", {}, ...others.map((item, i) => element("li", {},
      element("button", { type: "button", class: "name", onclick: () => this.state.lead(item) }, words[i]),
      element("button", { type: "button", class: "quiet", "aria-label": `Select ${nameOf(run, item)} no longer`, onclick: () => this.state.select(item, true) }, "×")))));
  }

  /** Why the task is not done: what the decision in force did without it, then all decisions. */
  #why(run, selected, t) {
    const box = byId("card-why");
    const task = selected.type === "task" ? selected.id : null;
    if (task !== null && this.state.live && !run.ended) this.#askWhy(run, task);
    const story = task === null ? null : storyOf(run, task);
    const reason = story && reasonAt(story, decisionAt(run, t));
    const key = `${run.name} ${task} ${reason?.index}`;
    if (key === this.whyKey) return;
    this.whyKey = key;
    const undone = task !== null && run.ended && taskNow(run, run.tasks[task], run.nowMs).doneAt === null;
    if (!story) {
      box.replaceChildren(...(undone ? [element("p", { class: "empty" }, `muster explain ${run.name} --task ${task} says why not.`)] : []));
      return;
    }
    const open = box.querySelector("details")?.open ?? false;
    box.replaceChildren(
      element("h3", {}, reason ? `Why not, at decision ${reason.index}` : "Why not"),
      ...(reason?.lines ?? []).map((line) => element("p", {}, ...this.#linked(run, taskWords(line)))),
      element("details", { open }, element("summary", {}, "All decisions"),
        ...story.head.slice(1).map((line) => element("p", {}, line)),
        element("ol", {}, ...story.decisions.map((d) => element("li", {},
          element("button", { type: "button", class: "name", onclick: () => this.clock.seek(run.decisions.find((other) => other.index === d.index)?.t ?? t) }, `decision ${d.index}`),
          " ", ...this.#linked(run, taskWords(d.lines.join("; ")))))),
        ...story.tail.map((line) => element("p", {}, line))));
  }

  /** A live mission is asked itself, once for each decision. */
  async #askWhy(run, task) {
    const decision = run.decisions.at(-1)?.index;
    const asked = `${run.name} ${task} ${decision}`;
    if (decision === undefined || asked === this.askedWhy || taskNow(run, run.tasks[task], run.nowMs).doneAt !== null) return;
    this.askedWhy = asked;
    const response = await fetch(`/why/task:${task}`).catch(() => null);
    if (!response?.ok) return;
    const text = await response.text();
    run.reasons ??= new Map();
    run.reasons.set(task, text);
    run.derived.delete(`reasons ${task}`);
    this.whyKey = null;
    this.draw();
  }

  /** Names of things in a text are buttons that select them. */
  #linked(run, text) {
    return String(text).split(/((?:uav|worker|vehicle):\d+|task \d+|charging point \d+)/).filter(Boolean).map((part) => {
      const item = itemOf(run, part.replace("charging point ", "charge:").replace("task ", "task:"));
      return item ? element("button", { type: "button", class: "name", onclick: () => this.state.flyTo(item) }, part) : part;
    });
  }

  /** What is so now, with what the commander has decided about it. */
  #now(run, selected, t) {
    const now = this.#facts(run, selected, t);
    for (const one of directivesOf(run, selected, t)) now.facts.push(["directed", directiveWords(one)]);
    return now;
  }

  #facts(run, selected, t) {
    if (selected.type === "agent") return this.#agentNow(run, run.agents[selected.index], t);
    if (selected.type === "task") return this.#taskNow(run, run.tasks[selected.id], t);
    const point = run.charging[selected.id];
    const there = run.agents.filter((agent) => agent.kind === UAV).filter((agent) => {
      const { activity } = agentNow(run, agent, t);
      return activity?.charging && activity.site === point.id && activity.start <= t;
    });
    const room = point.capacity === null ? "any number of UAVs" : `${point.capacity} UAV${point.capacity === 1 ? "" : "s"}`;
    return { title: `charging point ${point.id}`, state: `${number(there.length)} charging`,
      facts: [["now", there.length ? there.map((agent) => agent.label).join(", ") : "nobody charges"], ["room for", `${room} at a time`], ["place", placeWords(run, point)]] };
  }

  #agentNow(run, agent, t) {
    const now = agentNow(run, agent, t);
    const { activity, site, arrival } = now;
    const status = run.words.statuses[now.status];
    const facts = [];
    const doing = site ? ` ${now.status === MOVING ? "to" : "at"} ${siteName(site)}` : now.to && now.status === MOVING ? ` to ${placeWords(run, now.to)}` : "";
    facts.push(["now", `${status}${doing}, since ${timeText(run, now.since)}`]);
    if (now.partner) facts.push(["with", now.partner]);
    if (arrival) facts.push(["arrives", `${arrival.known ? "" : "about "}${timeText(run, arrival.t)}, ${within(arrival.t - t)}, ${way(arrival.left)} left`]);
    if (activity) {
      const what = activity.charging ? "charging" : "sensing";
      facts.push(["then", activity.start > t ? `${what} ${timeText(run, activity.start)} to ${timeText(run, activity.end)}` : `${what} until ${timeText(run, activity.end)}, ${within(activity.end - t)}`]);
      if (activity.aborted !== null) facts.push(["but", `broken off at ${timeText(run, activity.aborted)}`]);
    } else if (now.until !== null && !arrival) facts.push(["until", timeText(run, now.until)]);
    const next = now.status === FAILED ? null : agentNext(run, agent, now, t);
    if (next?.command) facts.push(["next", `${commandWords(next.command)} (decision ${next.command.decision.index}, ${clockText(next.command.decision.t)})`]);
    else if (next) facts.push(["next", `${next.activity.charging ? "charging" : "sensing"} at ${siteName(next.activity)}, ${timeText(run, next.activity.start)}`]);
    const place = now.status === OFFLINE ? null : placeAt(agent, t);
    const up = agent.kind === UAV ? run.altitudes.at(agent.id, t) : null;
    if (up !== null) facts.push(["altitude", up > 0 ? `${number(up)} m above the ground` : "on the ground"]);
    if (place && agent.kind === UAV) facts.push(["range", `${km(place.range)} of ${km(agent.fullRange)} (${number((100 * place.range) / agent.fullRange)} %)`]);
    if (place) facts.push(["place", placeWords(run, place)]);
    const range = place && agent.kind === UAV ? `, ${(place.range / 1000).toFixed(1)} of ${(agent.fullRange / 1000).toFixed(0)} km left` : "";
    return { title: agent.label, state: `${status}${doing}${range}`, facts };
  }

  #taskNow(run, task, t) {
    const now = taskNow(run, task, t);
    const facts = [];
    const status = run.words.tasks[now.status];
    const pair = now.activity ? `uav:${now.activity.uav} and worker:${now.activity.partner}` : null;
    if (now.status === DONE) facts.push(["now", `done at ${timeText(run, now.doneAt)}${pair ? ` by ${pair}` : ""}`]);
    else if (now.activity && now.status !== OPEN) {
      facts.push(["now", now.activity.start <= t ? `sensed by ${pair}` : `reserved for ${pair}`]);
      facts.push(["sensing", `${timeText(run, now.activity.start)} to ${timeText(run, now.activity.end)}`]);
      if (now.activity.start > t) {
        for (const [kind, id] of [[0, now.activity.uav], [1, now.activity.partner]]) {
          const agent = run.agents[run.agentIndex(kind, id)];
          const arrival = arrivalAt(run, agent, t, task.x, task.y);
          if (arrival) facts.push(["arrival", `${agent.label} ${arrival.left < 2 ? "is there" : `${arrival.known ? "" : "about "}${timeText(run, arrival.t)}`}`]);
        }
      }
    } else facts.push(["now", `${status}: nobody is sent for it`]);
    if (now.status !== DONE && run.ended) facts.push(["in the end", now.doneAt === null ? "never done" : `done at ${timeText(run, now.doneAt)}`]);
    if (run.timed) facts.push(...timeFacts(run, task));
    facts.push(["takes", `${km(task.cost)} of range`], ["place", placeWords(run, task)]);
    return { title: `task ${task.id}${task.name ? ` ${isolated(task.name)}` : ""}`, state: status, facts };
  }

  #more(run, selected) {
    if (selected.type === "charge") return [];
    const agent = selected.type === "agent" ? run.agents[selected.index] : null;
    const commands = agent ? commandsOf(run, agent) : commandsByTask(run)[selected.id];
    const { byAgent, byTask } = activities(run);
    const history = (agent ? byAgent.get(agent.index) : byTask.get(selected.id)) ?? [];
    return [
      agent?.kind === UAV ? rangeCurve(run, agent) : null,
      this.#list("What was decided", commands.map((c) => [c.decision.t, `decision ${c.decision.index}`, `${commandWords(c)} (${number(c.weight, 3)})`]), "No decision sent anybody."),
      this.#list("History", history.map((a) => [a.start, a.charging ? "charging" : "sensing",
        `${siteName(a)}, uav:${a.uav} and ${a.charging ? "vehicle" : "worker"}:${a.partner}, until ${clockText(a.aborted ?? a.end)}${a.aborted === null ? "" : ", broken off"}`]), "Nothing was begun."),
    ].filter(Boolean);
  }

  /** Rows of [time, what, text] under a heading; a click on the time goes there. */
  #list(title, rows, none) {
    return element("details", { open: true }, element("summary", {}, `${title} (${rows.length})`),
      rows.length === 0 ? element("p", { class: "empty" }, none) : element("ol", {}, ...rows.map(([t, what, text]) => element("li", {},
        element("button", { type: "button", class: "name", onclick: () => this.clock.seek(t) }, clockText(t)), ` ${what}: `, ...this.#linked(this.state.run, text)))));
  }
}

/** Range over the mission's time. */
function rangeCurve(run, agent) {
  const { stops } = agent;
  const every = Math.max(1, Math.ceil(stops.length / 4 / MOST_RANGE_POINTS)) * 4;
  const points = [];
  for (let i = 0; i < stops.length; i += every) {
    points.push(`${((300 * stops[i]) / run.limitMs).toFixed(1)},${(42 - (40 * stops[i + 3]) / agent.fullRange).toFixed(1)}`);
  }
  const template = document.createElement("template");
  template.innerHTML = '<svg class="range" viewBox="0 0 300 44" preserveAspectRatio="none" role="img"><path class="frame" d="M0 2H300M0 22H300M0 42H300"/><polyline/><path id="range-cursor" d="M0 0V44"/></svg>';
  const svg = template.content.firstChild;
  svg.setAttribute("aria-label", `Range of ${agent.label} over time, 0 to ${km(agent.fullRange)}`);
  svg.querySelector("polyline").setAttribute("points", points.join(" "));
  const table = new ChartTable(`range of ${agent.label}`, () => ({ head: ["time", "km left"],
    rows: Array.from({ length: stops.length / 4 }, (_, i) => [stops[4 * i], number(stops[4 * i + 3] / 1000, 1)]) }));
  return element("figure", {}, svg, element("figcaption", {}, `range, 0 to ${km(agent.fullRange)}, over the mission`), table.node);
}
