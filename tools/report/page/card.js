import { altitudeAt } from "./air.js";
import { oncePerFrame } from "./canvas.js";
import { ChartTable } from "./chart_table.js";
import { describe, rangeWords, roomWords } from "./describe.js";
import { directiveWords, directivesOf } from "./directives.js";
import { byId, element, isolated, number } from "./dom.js";
import { say } from "./language.js";
import { nameOf } from "./link.js";
import { mentions, pointName, taskName } from "./names.js";
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
  const facts = [[say("priority"), PRIORITIES[task.priority]], [say("reported"), timeText(run, task.reported)]];
  if (task.due !== null) facts.push([say("due"), say("sensing should begin by {time}", { time: timeText(run, task.due) })]);
  if (task.expires !== null) facts.push([say("expires"), say("sensing must begin before {time}", { time: timeText(run, task.expires) })]);
  return facts;
}

/** "in 6:30" */
function within(ms) {
  const s = Math.max(0, Math.round(ms / 1000));
  return say("in {time}", { time: s >= 3600 ? clockText(ms) : `${Math.floor(s / 60)}:${String(s % 60).padStart(2, "0")}` });
}

const siteName = (site) => (site.charging ? pointName(site.site) : taskName(site.site));

/** "moving to task 17": what an agent does and where, as far as that is known. */
function doingWords(run, { status, site, to }) {
  const values = { status: say(run.words.statuses[status]), id: site?.site };
  if (site?.charging) return say(status === MOVING ? "{status} to charging point {id}" : "{status} at charging point {id}", values);
  if (site) return say(status === MOVING ? "{status} to task {id}" : "{status} at task {id}", values);
  return to && status === MOVING ? say("{status} to {place}", { ...values, place: placeWords(run, to) }) : values.status;
}

/** Beginning and end of an activity that has not begun, or the end of one that has. */
function activityWords(run, { charging, start, end }, t) {
  const values = { from: timeText(run, start), to: timeText(run, end), within: within(end - t) };
  if (start > t) return say(charging ? "charging {from} to {to}" : "sensing {from} to {to}", values);
  return say(charging ? "charging until {to}, {within}" : "sensing until {to}, {within}", values);
}

/** What an agent does next: a command that it will get, or an activity. */
function nextWords(run, { command, activity }) {
  if (command) return say("{what} (decision {index}, {time})", { what: commandWords(command), index: command.decision.index, time: clockText(command.decision.t) });
  const { charging, site, start } = activity;
  const what = say(charging ? "{status} at charging point {id}" : "{status} at task {id}", { status: say(charging ? "charging" : "sensing"), id: site });
  return `${what}, ${timeText(run, start)}`;
}

/** "uav:3 and worker:7" */
const pairWords = ({ charging, uav, partner }) => say("{a} and {b}", { a: `uav:${uav}`, b: `${charging ? "vehicle" : "worker"}:${partner}` });

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
    if (local) now.facts.push([say("time"), local]);
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
    byId("card-others").replaceChildren(element("h3", {}, say("Selected too: {n}", { n: others.length })), element("ul", {},
      ...others.map((item, i) => element("li", {},
        element("button", { type: "button", class: "name", onclick: () => this.state.lead(item) }, words[i]),
        element("button", { type: "button", class: "quiet", "aria-label": say("Select {what} no longer", { what: nameOf(run, item) }), onclick: () => this.state.select(item, true) }, "×")))));
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
      box.replaceChildren(...(undone ? [element("p", { class: "empty" }, say("{command} says why not.", { command: `muster explain ${run.name} --task ${task}` }))] : []));
      return;
    }
    const open = box.querySelector("details")?.open ?? false;
    box.replaceChildren(
      element("h3", {}, reason ? say("Why not, at decision {index}", { index: reason.index }) : say("Why not")),
      ...(reason?.lines ?? []).map((line) => element("p", {}, ...this.#linked(run, taskWords(line)))),
      element("details", { open }, element("summary", {}, say("All decisions")),
        ...story.head.slice(1).map((line) => element("p", {}, line)),
        element("ol", {}, ...story.decisions.map((d) => element("li", {},
          element("button", { type: "button", class: "name", onclick: () => this.clock.seek(run.decisions.find((other) => other.index === d.index)?.t ?? t) }, say("decision {index}", { index: d.index })),
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
    return mentions(run, String(text)).map(({ text: part, item }) =>
      (item ? element("button", { type: "button", class: "name", onclick: () => this.state.flyTo(item) }, part) : part));
  }

  /** What is so now, with what the commander has decided about it. */
  #now(run, selected, t) {
    const now = this.#facts(run, selected, t);
    for (const one of directivesOf(run, selected, t)) now.facts.push([say("directed"), directiveWords(one)]);
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
    return { title: pointName(point.id), state: say("{n} charging", { n: number(there.length) }),
      facts: [[say("now"), there.length ? there.map((agent) => agent.label).join(", ") : say("nobody charges")], [say("room for"), roomWords(point)],
        [say("place"), placeWords(run, point)]] };
  }

  #agentNow(run, agent, t) {
    const now = agentNow(run, agent, t);
    const { activity, arrival } = now;
    const doing = doingWords(run, now);
    const facts = [[say("now"), say("{what}, since {time}", { what: doing, time: timeText(run, now.since) })]];
    if (now.partner) facts.push([say("with"), now.partner]);
    if (arrival) {
      const values = { time: timeText(run, arrival.t), within: within(arrival.t - t), way: way(arrival.left) };
      facts.push([say("arrives"), say(arrival.known ? "{time}, {within}, {way} left" : "about {time}, {within}, {way} left", values)]);
    }
    if (activity) {
      facts.push([say("then"), activityWords(run, activity, t)]);
      if (activity.aborted !== null) facts.push([say("but"), say("broken off at {time}", { time: timeText(run, activity.aborted) })]);
    } else if (now.until !== null && !arrival) facts.push([say("until"), timeText(run, now.until)]);
    const next = now.status === FAILED ? null : agentNext(run, agent, now, t);
    if (next) facts.push([say("next"), nextWords(run, next)]);
    const place = now.status === OFFLINE ? null : placeAt(agent, t);
    const up = agent.kind === UAV ? altitudeAt(run, agent, t) : null;
    if (up !== null) facts.push([say("altitude"), up > 0 ? say("{n} m above the ground", { n: number(up) }) : say("on the ground")]);
    if (place && agent.kind === UAV) {
      const left = say("{n} of {total}", { n: km(place.range), total: km(agent.fullRange) });
      facts.push([say("range"), `${left} (${number((100 * place.range) / agent.fullRange)} %)`]);
    }
    if (place) facts.push([say("place"), placeWords(run, place)]);
    const range = place && agent.kind === UAV ? `, ${rangeWords(agent, place)}` : "";
    return { title: agent.label, state: `${doing}${range}`, facts };
  }

  #taskNow(run, task, t) {
    const now = taskNow(run, task, t);
    const facts = [];
    const status = say(run.words.tasks[now.status]);
    const pair = now.activity ? pairWords(now.activity) : null;
    if (now.status === DONE) facts.push([say("now"), say(pair ? "done at {time} by {pair}" : "done at {time}", { time: timeText(run, now.doneAt), pair })]);
    else if (now.activity && now.status !== OPEN) {
      facts.push([say("now"), say(now.activity.start <= t ? "sensed by {pair}" : "reserved for {pair}", { pair })]);
      facts.push([say("sensing"), say("{from} to {to}", { from: timeText(run, now.activity.start), to: timeText(run, now.activity.end) })]);
      if (now.activity.start > t) {
        for (const [kind, id] of [[0, now.activity.uav], [1, now.activity.partner]]) {
          const agent = run.agents[run.agentIndex(kind, id)];
          const arrival = arrivalAt(run, agent, t, task.x, task.y);
          const values = { agent: agent.label, time: arrival && timeText(run, arrival.t) };
          const known = arrival?.known ? `${values.agent} ${values.time}` : say("{agent} about {time}", values);
          if (arrival) facts.push([say("arrival"), arrival.left < 2 ? say("{agent} is there", values) : known]);
        }
      }
    } else facts.push([say("now"), say("{status}: nobody is sent for it", { status })]);
    if (now.status !== DONE && run.ended) {
      facts.push([say("in the end"), now.doneAt === null ? say("never done") : say("done at {time}", { time: timeText(run, now.doneAt) })]);
    }
    if (run.timed) facts.push(...timeFacts(run, task));
    facts.push([say("takes"), say("{km} of range", { km: km(task.cost) })], [say("place"), placeWords(run, task)]);
    if (task.note) facts.push([say("note"), isolated(task.note)]);
    return { title: `${taskName(task.id)}${task.name ? ` ${isolated(task.name)}` : ""}`, state: status, facts };
  }

  #more(run, selected) {
    if (selected.type === "charge") return [];
    const agent = selected.type === "agent" ? run.agents[selected.index] : null;
    const commands = agent ? commandsOf(run, agent) : commandsByTask(run)[selected.id];
    const { byAgent, byTask } = activities(run);
    const history = (agent ? byAgent.get(agent.index) : byTask.get(selected.id)) ?? [];
    return [
      agent?.kind === UAV ? rangeCurve(run, agent) : null,
      this.#list(say("What was decided"), commands.map((c) => [c.decision.t, say("decision {index}", { index: c.decision.index }), `${commandWords(c)} (${number(c.weight, 3)})`]),
        say("No decision sent anybody.")),
      this.#list(say("History"), history.map((a) => [a.start, say(a.charging ? "charging" : "sensing"),
        say(a.aborted === null ? "{site}, {pair}, until {time}" : "{site}, {pair}, until {time}, broken off", {
          site: siteName(a), pair: pairWords(a), time: clockText(a.aborted ?? a.end) })]), say("Nothing was begun.")),
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
  svg.setAttribute("aria-label", say("Range of {agent} over time, 0 to {full}", { agent: agent.label, full: km(agent.fullRange) }));
  svg.querySelector("polyline").setAttribute("points", points.join(" "));
  const table = new ChartTable(say("range of {agent}", { agent: agent.label }), () => ({ head: [say("time"), say("km left")],
    rows: Array.from({ length: stops.length / 4 }, (_, i) => [stops[4 * i], number(stops[4 * i + 3] / 1000, 1)]) }));
  return element("figure", {}, svg, element("figcaption", {}, say("range, 0 to {full}, over the mission", { full: km(agent.fullRange) })), table.node);
}
