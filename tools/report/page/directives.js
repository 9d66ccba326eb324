import { say } from "./language.js";

/** Rows of a chunk as objects: what the commander has decided, each for as long as it was in force. */
export const readDirectives = (rows) => rows.map(([from, until, order, issuer, kind, words, uav, worker, vehicle, task]) => ({
  from, until, order, issuer, kind, words, agents: [uav, worker, vehicle], task }));

/** Those in force at t. */
export const directivesAt = (run, t) => run.directives.filter(({ from, until }) => from <= t && (until === null || t < until));

/** Those in force at t that name what is selected. */
export function directivesOf(run, selected, t) {
  if (selected.type === "task") return directivesAt(run, t).filter((one) => one.task === selected.id);
  if (selected.type !== "agent") return [];
  const { kind, id } = run.agents[selected.index];
  return directivesAt(run, t).filter((one) => one.agents[kind] === id);
}

/** "pin: uav:3 to task 12, by chief" */
export const directiveWords = ({ words, issuer, order }) => say("{what}, by {who}", { what: words, who: issuer || say("order {order}", { order }) });

/** Agents that an order may name: those that the mission has, of that class. */
export const agentsOfClass = (run, kind) => run.agents.filter((agent) => agent.kind === kind && !agent.vacant);

/** "uav:3 and worker:7" of the agents of an order. */
export const agentWords = ([first = "", ...others]) => others.reduce((a, b) => say("{a} and {b}", { a, b }), first);
