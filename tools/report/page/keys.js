import { byId } from "./dom.js";

/** Keys that a display for a wall has. */
const OF_WALL = ["w", "Escape", " ", "ArrowRight", "ArrowLeft", "]", "[", "Home", "End", "+", "=", "-", "f", "?"];

/** What the keyboard does; `?` shows it. */
export function bindKeys({ state, clock, transport, map, scene, panels, control, measure, search, folding, sheet }) {
  const help = byId("help");
  byId("help-open").addEventListener("click", () => help.showModal());
  const toWall = () => {
    if (measure.on) measure.stop();
    if (map.picking) control.togglePick(control.picks);
    state.setWall(true);
  };
  byId("wall-open").addEventListener("click", toWall);
  const lookAt = (looks) => {
    state.look(looks);
    byId("map-panel").scrollIntoView({ block: "nearest" });
  };
  const actions = {
    " ": () => clock.toggle(),
    ArrowRight: (event) => (event.shiftKey ? transport.step(1) : clock.seek(clock.t + state.run.tickMs)),
    ArrowLeft: (event) => (event.shiftKey ? transport.step(-1) : clock.seek(clock.t - state.run.tickMs)),
    "]": () => transport.step(1),
    "[": () => transport.step(-1),
    Home: () => clock.seek(0),
    End: () => clock.seek(clock.max, state.live),
    "+": () => clock.faster(1),
    "=": () => clock.faster(1),
    "-": () => clock.faster(-1),
    1: () => state.toggleClass(0),
    2: () => state.toggleClass(1),
    3: () => state.toggleClass(2),
    "/": () => search.focus(),
    f: () => (state.looks === "map" ? map : scene).reset(),
    m: () => lookAt("map"),
    s: () => lookAt("scene"),
    u: () => lookAt("time"),
    a: () => control.togglePick(),
    l: () => measure.toggle(),
    z: () => state.setView(null),
    t: () => panels.show("tasks"),
    d: () => panels.show("decision"),
    e: () => panels.show("events"),
    p: () => panels.show("processes"),
    i: () => panels.show("engine"),
    n: () => (sheet.phone.matches ? sheet.next() : folding.toggle("attention")),
    c: () => folding.toggle("card"),
    k: () => folding.toggle("legend"),
    o: () => folding.toggle("tools"),
    h: () => folding.toggleAll(),
    w: () => (state.wall ? state.setWall(false) : toWall()),
    Escape: () => (state.wall ? state.setWall(false) : measure.on ? measure.stop() : map.picking ? control.togglePick(control.picks) : state.select(null)),
    "?": () => help.showModal(),
  };
  document.addEventListener("keydown", (event) => {
    const action = actions[event.key];
    const target = event.target;
    if (state.wall && !OF_WALL.includes(event.key)) return;
    if (!action || event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]") || !state.run) return;
    if (target.matches("input:not([type=range]), select, textarea")) return;
    if (event.key === " " && target.matches("button, summary, [tabindex]")) return; // it presses that
    if (target.matches("input[type=range]") && event.key.startsWith("Arrow") === false && event.key === "Home") return;
    event.preventDefault();
    action(event);
  });
}
