import { Charts } from "./charts.js";
import { Clock } from "./clock.js";
import { embeddedRuns, follow, liveAddress } from "./data.js";
import { byId } from "./dom.js";
import { Gantt } from "./gantt.js";
import { Header } from "./header.js";
import { bindKeys } from "./keys.js";
import { MapView } from "./map.js";
import { Legend, Panels } from "./panels.js";
import { State } from "./state.js";
import { watchTheme } from "./theme.js";
import { Transport } from "./transport.js";

const state = new State();
const clock = new Clock();
watchTheme(() => state.emit("theme"));

function bindChoices(map, gantt) {
  byId("trail").addEventListener("change", (event) => {
    map.trailMs = event.target.value === "all" ? Infinity : Number(event.target.value) * 60000;
    map.draw();
  });
  byId("map-reset").addEventListener("click", () => map.reset());
  byId("view-reset").addEventListener("click", () => state.setView(null));
  state.on("view", () => { byId("view-reset").hidden = !state.view; });
  byId("axis").addEventListener("change", (event) => {
    state.byDecision = event.target.value === "decision";
    state.emit("axis");
  });
  byId("sort").addEventListener("change", (event) => {
    gantt.sort = event.target.value;
    gantt.layout();
  });
  byId("rows").addEventListener("change", (event) => {
    gantt.mode = event.target.value;
    gantt.layout();
  });
  byId("filter").addEventListener("input", (event) => {
    gantt.filter = event.target.value;
    gantt.layout();
  });
  state.on("selection", () => {
    if (state.selected?.type === "agent") gantt.reveal(state.run.agents[state.selected.index]);
  });
}

function build() {
  new Header(state);
  const transport = new Transport(state, clock);
  const map = new MapView(state, clock);
  new Charts(state, clock);
  const gantt = new Gantt(state, clock);
  const panels = new Panels(state, clock);
  new Legend(state, clock);
  bindChoices(map, gantt);
  bindKeys({ state, clock, transport, map, panels });
}

function showLive(text) {
  byId("live-state").hidden = false;
  byId("live-state").textContent = text;
  byId("live-state").dataset.state = text;
}

async function start() {
  build();
  const address = liveAddress();
  if (address === null) {
    state.runs = await embeddedRuns();
    if (state.runs.length === 0) throw new Error("the page holds no run");
    state.emit("run");
    clock.seek(0);
  } else {
    state.live = true;
    clock.follow = true;
    showLive("connecting");
    follow(address, (run, isNew) => {
      state.runs = [run];
      document.title = `${run.name} – Muster`;
      state.emit(isNew ? "run" : "data");
      showLive(run.ended ? "ended" : "live");
    }, showLive);
  }
  document.documentElement.dataset.ready = String(Math.round(performance.now()));
}

// For tests and for the console.
window.muster = { state, clock };
start().catch((error) => {
  byId("problem").hidden = false;
  byId("problem").textContent = `This page cannot be shown: ${error.message}. It needs a browser of 2023 or later.`;
  throw error;
});
