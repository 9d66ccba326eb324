const KINDS = ["driver_says", "driver_calls"];
const SHOWN_MS = 10 * 60000;

/** The agent that an event of a driver names. */
const agentOf = (run, event) => run.agents.find(({ kind, id }) => event[run.words.agents[kind]] === id);

/**
 * What drivers have said to people by t, of each agent the newest: [{ agent, text, at, isCall }]. A call for help stands until the
 * same agent says something else, a message for ten minutes. The terminal has the same rule (tools/top/attention.cc).
 */
export function messagesAt(run, t) {
  if (run.ended && t >= run.nowMs) return [];
  const newest = new Map();
  for (const event of run.events) {
    if (!KINDS.includes(event.kind) || event.t > t) continue;
    const agent = agentOf(run, event);
    if (agent) newest.set(agent, { agent, text: event.detail, at: event.t, isCall: event.kind === "driver_calls" });
  }
  return [...newest.values()].filter(({ isCall, at }) => isCall || t - at <= SHOWN_MS);
}
