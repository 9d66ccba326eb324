import { isSameCommand, isSameScenario } from "./compare.js";
import { byId, element } from "./dom.js";
import { say } from "./language.js";
import { nameOf } from "./link.js";
import { decisionAt } from "./run.js";
import { commandWords, commandsAt } from "./story.js";
import { clockText } from "./time.js";

const MOST = 200;

/** Where a run was decided on the same scenario as `run`, so that their decisions compare. */
const comparable = (run, other) => other !== run && isSameScenario(run, other);

/** Whom the decision in force at t commands otherwise in another run: [{ agent, here, there }]; null: stays as it is. */
export function differencesAt(run, other, t) {
  const [here, there] = [commandsAt(run, decisionAt(run, t)), commandsAt(other, decisionAt(other, t))];
  return run.agents.map((agent) => ({ agent, here: here.get(agent.index) ?? null, there: there.get(agent.index) ?? null }))
    .filter((pair) => !isSameCommand(pair.here, pair.there));
}

/** The choice beside the map, and the list in the comparison, of what another run decided otherwise at the chosen time. */
export class Differences {
  constructor(state, clock) {
    this.state = state;
    this.clock = clock;
    this.choice = byId("differ");
    this.choice.addEventListener("change", () => state.differFrom(this.choice.value === "" ? null : Number(this.choice.value)));
    clock.subscribe(() => this.#show());
    state.on("run", () => this.#offer());
    state.on("run data differ", () => this.#show());
  }

  #offer() {
    const { run, runs, current } = this.state;
    const others = runs.map((other, i) => [i, other]).filter(([i, other]) => i !== current && comparable(run, other));
    byId("differ-choice").hidden = others.length === 0;
    this.choice.replaceChildren(element("option", { value: "" }, say("none")), ...others.map(([i, other]) => element("option", { value: i }, other.name)));
    this.state.differFrom(null);
  }

  #show() {
    const { run, runs, other: from } = this.state;
    const box = byId("differences");
    box.hidden = from === null;
    this.choice.value = from ?? "";
    if (from === null) return;
    const other = runs[from];
    const pairs = differencesAt(run, other, this.clock.t);
    const key = `${run.name} ${other.name} ${decisionAt(run, this.clock.t)?.index} ${decisionAt(other, this.clock.t)?.index} ${run.nowMs}`;
    if (key === this.shown) return;
    this.shown = key;
    const name = (agent) => element("button", { type: "button", class: "name", onclick: () => this.state.flyTo({ type: "agent", index: agent.index }) }, nameOf(run, { type: "agent", index: agent.index }));
    const words = (command) => (command ? commandWords(command) : say("nothing new"));
    const at = decisionAt(run, this.clock.t);
    box.replaceChildren(
      element("h3", {}, say(at ? "Decision {index}, {time}: {n} agents are commanded otherwise than in {run}" : "Before the first decision: {n} agents are commanded otherwise than in {run}", {
        index: at?.index, time: at && clockText(at.t), n: pairs.length, run: other.name })),
      element("div", { class: "wide tall", tabindex: 0, role: "group", "aria-label": say("Agents commanded otherwise") }, element("table", {},
        element("thead", {}, element("tr", {}, ...[say("agent"), run.name, other.name].map((text) => element("th", { scope: "col" }, text)))),
        element("tbody", {}, ...pairs.slice(0, MOST).map(({ agent, here, there }) => element("tr", {}, element("td", {}, name(agent)), element("td", {}, words(here)), element("td", {}, words(there)))))),
      pairs.length > MOST ? element("p", { class: "hint" }, say("and {n} more", { n: pairs.length - MOST })) : ""));
  }
}
