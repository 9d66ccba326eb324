import { offerLanguages } from "./languages.js"; // before those that have texts
import { Attention } from "./attention.js";
import { Card } from "./card.js";
import { Charts } from "./charts.js";
import { Clock } from "./clock.js";
import { Control } from "./control.js";
import { embeddedRuns, follow, liveAddress } from "./data.js";
import { Differences } from "./differences.js";
import { byId, number } from "./dom.js";
import { Folding, foldIds } from "./folding.js";
import { Gantt } from "./gantt.js";
import { Header } from "./header.js";
import { bindJumps } from "./jumps.js";
import { bindKeys } from "./keys.js";
import { say } from "./language.js";
import { Link, itemOf } from "./link.js";
import { MapView } from "./map.js";
import { Measure } from "./measure.js";
import { tellingMoment } from "./moment.js";
import { LayersMenu, layerIds } from "./layers_menu.js";
import { News } from "./news.js";
import { Legend, Panels } from "./panels.js";
import { SceneTab } from "./scene_tab.js";
import { RivalryView } from "./rivalry_view.js";
import { Search } from "./search.js";
import { Sheet } from "./sheet.js";
import { State } from "./state.js";
import { decidingMs } from "./run.js";
import { watchTheme } from "./theme.js";
import { timeText } from "./time.js";
import { Transport } from "./transport.js";
import { WallView } from "./wall_view.js";

const state = new State();
const clock = new Clock();
const parts = {};
watchTheme(() => state.emit("theme"));

function bindChoices(map, scene, gantt) {
  byId("trail").addEventListener("change", (event) => {
    state.setTrails(event.target.value === "all" ? Infinity : Number(event.target.value) * 60000);
  });
  byId("map-reset").addEventListener("click", () => (state.looks === "map" ? map : scene).reset());
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
    state.setFilter(event.target.value);
  });
  state.on("selection", () => {
    if (state.selected?.type === "agent") gantt.reveal(state.run.agents[state.selected.index]);
  });
}

function build() {
  const attention = new Attention(state, clock, (filter) => parts.panels.showTasks(filter));
  new Header(state, clock, attention);
  const folding = new Folding(state);
  const transport = new Transport(state, clock);
  const map = new MapView(state, clock);
  const scene = new SceneTab(state, clock);
  new LayersMenu(state);
  new News(state);
  new Charts(state, clock);
  const gantt = new Gantt(state, clock);
  const control = new Control(state, clock, map);
  const panels = new Panels(state, clock, control);
  new Legend(state, clock);
  new Card(state, clock);
  new Differences(state, clock);
  new RivalryView(state, clock, map);
  new WallView(state, clock, map, attention);
  const sheet = new Sheet(state, attention);
  Object.assign(parts, { map, control, panels });
  bindJumps(state, panels);
  bindChoices(map, scene, gantt);
  bindKeys({ state, clock, transport, map, scene, panels, control, folding, sheet, measure: new Measure(state, map), search: new Search(state, map) });
}

/** Says why the page opens where it does, until the time moves on. */
function tellMoment({ t, why }) {
  const note = byId("moment");
  note.hidden = false;
  note.title = note.textContent = say("Opened at {time}, {why}.", { time: timeText(state.run, t), why });
  clock.subscribe((now) => { note.hidden = note.hidden || Math.round(now) !== Math.round(t); });
}

/** Shows what a link says; what it does not say is as the page opens. */
function show({ tMs, sel, run, look, off, on, against, wall, fold }) {
  if (run !== null && run < state.runs.length && run !== state.current) state.open(run);
  state.setRival(against !== null && against < state.runs.length && against !== state.current ? against : state.usualRival);
  state.look(look ?? "map");
  if (off !== null || on !== null) state.setLayers({ off: off !== null ? layerIds(off) : null, extra: on !== null ? layerIds(on, true) : null });
  if (fold !== null) state.setFolded(foldIds(fold));
  const moment = tMs === null && !state.live ? tellingMoment(state.run) : null;
  if (moment) {
    clock.seek(moment.t);
    tellMoment(moment);
  } else if (tMs !== null) clock.seek(tMs);
  const items = (sel ?? "").split(",").map((name) => itemOf(state.run, name)).filter(Boolean);
  state.select(null);
  for (const item of items.reverse()) state.flyTo(item, true);
  state.setWall(wall);
}

function showLive(how, text = "") {
  byId("live-state").hidden = false;
  byId("live-state").textContent = text || say(how);
  byId("live-state").dataset.state = how;
}

/** "deciding for 3.2 s", where a scheduler says so; else "". */
function decidingText(run) {
  const ms = run.ended ? 0 : Math.max(0, ...[...run.processes.values()].map(decidingMs));
  return ms > 0 ? say("{state} for {n} s", { state: say("deciding"), n: number(ms / 1000, 1) }) : "";
}

/** The style sheet asks how high the bars above and below are: texts in them may need a line more. */
function measureBars() {
  const measured = new ResizeObserver((bars) => {
    for (const { target } of bars) document.body.style.setProperty(`--${target.localName}`, `${Math.ceil(target.getBoundingClientRect().height)}px`);
  });
  for (const bar of document.querySelectorAll("header, footer")) measured.observe(bar);
}

async function start() {
  offerLanguages(byId("language"));
  measureBars();
  const address = liveAddress();
  state.live = address !== null;
  build();
  if (address === null) {
    state.runs = await embeddedRuns();
    if (state.runs.length === 0) throw new Error(say("the page holds no run"));
    state.emit("run");
    new Link(state, clock, show).start();
  } else {
    clock.follow = true;
    showLive("connecting");
    let link = null;
    follow(address, (run, isNew) => {
      state.runs = [run];
      document.title = `${run.name} – Muster`;
      state.emit(isNew ? "run" : "data");
      if (!link) (link = new Link(state, clock, show)).start();
      showLive(run.ended ? "ended" : "live", decidingText(run));
    }, showLive);
  }
  // Once the bars have their texts and everything its size.
  requestAnimationFrame(() => requestAnimationFrame(() => {
    document.documentElement.dataset.ready = String(Math.round(performance.now()));
  }));
}

// For tests and for the console.
window.muster = { state, clock, parts };
start().catch((error) => {
  byId("problem").hidden = false;
  byId("problem").textContent = say("This page cannot be shown: {why}. It needs a browser of 2023 or later.", { why: error.message });
  throw error;
});
