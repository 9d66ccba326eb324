import { byId } from "./dom.js";

/** The strip below the map that leads to the parts below it, and back. */
export function bindJumps(state, panels) {
  for (const button of byId("jumps").querySelectorAll("button")) {
    const { jump, tab } = button.dataset;
    button.addEventListener("click", () => {
      if (tab) panels.open(tab);
      byId(jump).scrollIntoView({ block: "start" });
    });
  }
  state.on("run", () => { byId("jump-comparison").hidden = state.runs.length < 2; });
}
