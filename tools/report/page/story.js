import { agentWords } from "./directives.js";
import { number } from "./dom.js";
import { say } from "./language.js";
import { placeAt, statusAt, taskStatusAt } from "./run.js";
import { rowAt } from "./time.js";
import { CHARGE, CHARGES, DONE, LAST_STAY, MOVING, OPEN, SENSE, UAV, VEHICLE, WAITING, WORKER } from "./words.js";

const ACTION = 9;
const ACTIVITY = 6;
const NEAR_M = 2; // places are whole metres

export const PRIORITIES = [say("low"), say("normal"), say("high"), say("emergency")];

/** Every sensing and charging, by agent and by task: { charging, uav, partner, site, start, end, aborted }. */
export function activities(run) {
  return run.once("activities", () => {
    const byAgent = new Map();
    const byTask = new Map();
    const put = (map, key, value) => (map.has(key) ? map.get(key).push(value) : map.set(key, [value]));
    const rows = run.activities;
    const all = [];
    for (let i = 0; i < rows.length; i += ACTIVITY) {
      const [kind, uav, partner, site, start, end] = rows.slice(i, i + ACTIVITY);
      const activity = { charging: kind === CHARGES, uav, partner, site, start, end, aborted: null };
      all.push(activity);
      put(byAgent, run.agentIndex(UAV, uav), activity);
      put(byAgent, run.agentIndex(activity.charging ? VEHICLE : WORKER, partner), activity);
      if (!activity.charging) put(byTask, site, activity);
    }
    for (const event of run.events.filter((e) => e.kind.endsWith("_aborted"))) {
      const charging = event.kind === "charging_aborted";
      const ended = all.filter((a) => a.charging === charging && a.uav === event.uav && a.end > event.t && a.aborted === null
        && a.site === (charging ? event.charge : event.task) && a.partner === (charging ? event.vehicle : event.worker));
      if (ended.length) ended.reduce((x, y) => (y.end < x.end ? y : x)).aborted = event.t;
    }
    for (const list of [...byAgent.values(), ...byTask.values()]) list.sort((a, b) => a.start - b.start);
    return { byAgent, byTask };
  });
}

function actionAt(run, decision, offset) {
  const [kind, uav, worker, vehicle, task, charge, x, y, weight] = decision.actions.slice(offset, offset + ACTION);
  return { decision, kind, symbol: run.words.actions[kind], uav, worker, vehicle, task, charge, x, y, weight };
}

/** What was commanded to an agent, stays aside, in the order of decisions. */
export function commandsOf(run, agent) {
  return run.once(`commands ${agent.index}`, () => {
    const found = [];
    for (const decision of run.decisions) {
      const { actions } = decision;
      for (let i = 0; i < actions.length; i += ACTION) {
        if (actions[i + 1 + agent.kind] !== agent.id || actions[i] <= LAST_STAY) continue;
        found.push(actionAt(run, decision, i));
        break;
      }
    }
    return found;
  });
}

/** What was commanded for each task: [task] -> commands, in the order of decisions. */
export function commandsByTask(run) {
  return run.once("commands by task", () => {
    const found = run.tasks.map(() => []);
    for (const decision of run.decisions) {
      for (let i = 0; i < decision.actions.length; i += ACTION) {
        const task = decision.actions[i + 4];
        if (task >= 0 && decision.actions[i] > LAST_STAY) found[task].push(actionAt(run, decision, i));
      }
    }
    return found;
  });
}

/** What a decision commands, by the index of the agent, stays aside; nothing for no decision. */
export function commandsAt(run, decision) {
  const found = new Map();
  for (let i = 0; decision && i < decision.actions.length; i += ACTION) {
    if (decision.actions[i] <= LAST_STAY) continue;
    const command = actionAt(run, decision, i);
    [command.uav, command.worker, command.vehicle].forEach((id, kind) => id >= 0 && found.set(run.agentIndex(kind, id), command));
  }
  return found;
}

/** What a command tells its agents to do. */
export function commandWords(command) {
  const names = [command.uav >= 0 ? `uav:${command.uav}` : "", command.worker >= 0 ? `worker:${command.worker}` : "",
    command.vehicle >= 0 ? `vehicle:${command.vehicle}` : ""].filter(Boolean);
  const values = { names: agentWords(names), task: command.task, point: command.charge, x: number(command.x / 1000, 1), y: number(command.y / 1000, 1) };
  if (command.kind === SENSE) return say("{names} sense task {task}", values);
  if (command.kind === CHARGE) return say("{names} meet to charge at charging point {point}", values);
  if (command.task >= 0) return say("{names} goes ahead to task {task}", values);
  return say(command.charge >= 0 ? "{names} goes ahead to charging point {point}" : "{names} goes to {x}, {y} km", values);
}

const latest = (list, t) => list.findLast((command) => command.decision.t <= t) ?? null;

/** The time from which an agent has had its status, and until when it will have it (null: not known). */
export function spanAt(run, agent, t) {
  const i = rowAt(agent.spans, 2, t);
  const until = agent.spans[2 * i + 2] ?? null;
  return { status: statusAt(agent, t), since: i < 0 ? 0 : agent.spans[2 * i], until };
}

/** When an agent under way at t is at (x, y): { t, known }; known is false where only its speed tells. Null: never. */
export function arrivalAt(run, agent, t, x, y) {
  const { stops } = agent;
  const here = placeAt(agent, t);
  if (!here) return null;
  const left = Math.hypot(here.x - x, here.y - y);
  if (left < NEAR_M) return { t, known: true, left };
  let i = (rowAt(stops, 4, t) + 1) * 4;
  for (; i < stops.length; i += 4) {
    if (Math.hypot(stops[i + 1] - x, stops[i + 2] - y) < NEAR_M) return { t: stops[i], known: true, left };
  }
  const speed = speedAt(agent, t);
  return speed > 0 ? { t: t + left / speed, known: false, left } : null;
}

/** Metres per millisecond on the leg at t, or on the newest one. */
function speedAt(agent, t) {
  const { stops } = agent;
  for (let i = Math.min(stops.length - 4, (rowAt(stops, 4, t) + 1) * 4); i >= 4; i -= 4) {
    const way = Math.hypot(stops[i + 1] - stops[i - 3], stops[i + 2] - stops[i - 2]);
    if (way > NEAR_M) return way / (stops[i] - stops[i - 4]);
  }
  return 0;
}

/**
 * What an agent does at t: status with its times, the command that it follows, the activity that it is in or on its
 * way to, where it goes, with whom (an agent's name), its arrival.
 */
export function agentNow(run, agent, t) {
  const span = spanAt(run, agent, t);
  const command = latest(commandsOf(run, agent), t);
  const mine = activities(run).byAgent.get(agent.index) ?? [];
  const running = mine.find((a) => a.end > t && (a.aborted === null || a.aborted > t));
  const pair = command && [SENSE, CHARGE].includes(command.kind);
  // One that a later decision makes is not known at t.
  const activity = running && (running.start <= t || (pair && running.site === (command.task >= 0 ? command.task : command.charge))) ? running : null;
  const busy = activity !== null || span.status === MOVING || span.status === WAITING;
  const site = activity ?? (busy && command ? { charging: command.charge >= 0, site: command.charge >= 0 ? command.charge : command.task } : null);
  const place = site && site.site >= 0 ? (site.charging ? run.charging : run.tasks)[site.site] : null;
  const to = place ?? (busy && command ? { x: command.x, y: command.y } : null);
  const arrival = to && span.status === MOVING ? arrivalAt(run, agent, t, to.x, to.y) : null;
  return { ...span, command, activity, site: place ? site : null, to, arrival, partner: partnerOf(run, agent, activity, busy && pair ? command : null) };
}

/** The name of who meets an agent in an activity or by a command; null: nobody. */
function partnerOf(run, agent, activity, command) {
  const [uav, worker, vehicle] = activity
    ? [activity.uav, activity.charging ? -1 : activity.partner, activity.charging ? activity.partner : -1]
    : command ? [command.uav, command.worker, command.vehicle] : [-1, -1, -1];
  if (agent.kind !== UAV) return uav >= 0 ? `uav:${uav}` : null;
  return worker >= 0 ? `worker:${worker}` : vehicle >= 0 ? `vehicle:${vehicle}` : null;
}

/** What follows for an agent after t, as the log has it: the next activity or command; null: nothing more. */
export function agentNext(run, agent, now, t) {
  const activity = (activities(run).byAgent.get(agent.index) ?? []).find((a) => a !== now.activity && a.start > t);
  const command = commandsOf(run, agent).find((c) => c.decision.t > t);
  if (command && (!activity || command.decision.t <= activity.start)) return { command };
  return activity ? { activity } : null;
}

/** How a task stands at t: status, who is at it or on the way, until when or since when, and how it ends. */
export function taskNow(run, task, t) {
  const status = taskStatusAt(task, t);
  const mine = activities(run).byTask.get(task.id) ?? [];
  const lasts = (a) => a.aborted === null || a.aborted > t;
  const activity = status === DONE ? mine.findLast((a) => a.end <= t + run.tickMs && a.aborted === null)
    : status === OPEN ? null : mine.find((a) => a.end + run.tickMs > t && lasts(a));
  const command = latest(commandsByTask(run)[task.id], t);
  return { status, activity: activity ?? null, command, doneAt: doneTime(run, task) };
}

/** When a task's sensing ended; null: it was not done. */
export function doneTime(run, task) {
  return run.once("done times", () => run.tasks.map((each) => findDoneTime(run, each)))[task.id];
}

/** The tasks that were not done, as far as is known. */
export function undoneTasks(run) {
  return run.once("undone", () => run.tasks.filter((task) => !task.vacant && doneTime(run, task) === null));
}

function findDoneTime(run, task) {
  const { changes } = task;
  for (let i = changes.length - 2; i >= 0; i -= 2) {
    if (changes[i + 1] !== DONE) continue;
    const end = (activities(run).byTask.get(task.id) ?? []).findLast((a) => a.aborted === null)?.end;
    return end !== undefined && end <= changes[i] ? end : changes[i];
  }
  return null;
}

/** Metres flown by all UAVs until t, from the places in the log. */
export function flownAt(run, t) {
  const { sums, step } = run.once("flown", () => sumFlown(run));
  const at = Math.max(0, t / step);
  const i = Math.min(sums.length - 1, Math.floor(at));
  return sums[i] + (at - i) * ((sums[i + 1] ?? sums[i]) - sums[i]);
}

function sumFlown(run) {
  const bins = 512;
  const step = Math.max(1, run.nowMs) / bins;
  const sums = new Float64Array(bins + 1);
  for (const agent of run.agents) {
    if (agent.kind !== UAV) continue;
    const { stops } = agent;
    for (let i = 4; i < stops.length; i += 4) {
      const way = Math.hypot(stops[i + 1] - stops[i - 3], stops[i + 2] - stops[i - 2]);
      if (way === 0) continue;
      const [from, to] = [stops[i - 4], stops[i]];
      for (let b = Math.floor(from / step); b < bins && b * step < to; ++b) {
        const share = (Math.min(to, (b + 1) * step) - Math.max(from, b * step)) / Math.max(1, to - from);
        sums[b + 1] += share * way;
      }
    }
  }
  for (let b = 1; b <= bins; ++b) sums[b] += sums[b - 1];
  return { sums, step };
}

/** Milliseconds that agents stood waiting for partners until t. */
export function waitedMs(run, t) {
  let sum = 0;
  for (const { spans } of run.agents) {
    for (let i = 0; i < spans.length && spans[i] < t; i += 2) {
      if (spans[i + 1] === WAITING) sum += Math.min(t, spans[i + 2] ?? t) - spans[i];
    }
  }
  return sum;
}
