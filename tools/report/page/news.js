import { byId, number } from "./dom.js";
import { say } from "./language.js";
import { messagesAt } from "./messages.js";
import { taskName } from "./names.js";
import { statusAt, taskStatusAt } from "./run.js";
import { PRIORITIES } from "./story.js";
import { FAILED, UNREPORTED } from "./words.js";

const EMERGENCY = PRIORITIES.length - 1;
const KEPT = "muster.sound"; // in the browser's storage
const TOLD = 3; // by name

/** What has to be known at once when it is new, in words: calls for help, emergencies that are reported, agents that have failed. */
export function alarmsAt(run, t) {
  const isEmergency = (task) => !task.vacant && task.priority === EMERGENCY && taskStatusAt(task, t) !== UNREPORTED;
  const calls = messagesAt(run, t).filter(({ isCall }) => isCall);
  return [
    ...calls.map(({ agent, text }) => say("{agent} calls for help: {text}", { agent: agent.label, text })),
    ...run.tasks.filter(isEmergency).map(({ id, name }) => say("{task}: emergency", { task: `${taskName(id)}${name ? `, ${name}` : ""}` })),
    ...run.agents.filter((agent) => statusAt(agent, t) === FAILED).map(({ label }) => say("{agent} has failed", { agent: label })),
  ];
}

/** "uav:3 has failed; worker:7 has failed; and 4 more" */
export function newsWords(news) {
  const rest = news.length - TOLD;
  return [...news.slice(0, TOLD), ...(rest > 0 ? [say("and {n} more", { n: number(rest) })] : [])].join("; ");
}

/** Two short tones. */
function ring(context) {
  for (const [at, hertz] of [[0, 880], [0.18, 660]]) {
    const [tone, volume] = [context.createOscillator(), context.createGain()];
    tone.frequency.value = hertz;
    volume.gain.setValueAtTime(0.15, context.currentTime + at);
    volume.gain.exponentialRampToValueAtTime(0.001, context.currentTime + at + 0.16);
    tone.connect(volume).connect(context.destination);
    tone.start(context.currentTime + at);
    tone.stop(context.currentTime + at + 0.17);
  }
}

/** On a live page: says what is new in a line, and, where the user wants it, by a sound and a notification of the browser. */
export class News {
  constructor(state) {
    this.state = state;
    this.button = byId("sound");
    this.button.hidden = !state.live;
    this.run = null;
    this.known = new Set(); // what the page said last, whenever it heard of it
    this.button.addEventListener("click", () => this.#switch(!this.on));
    state.on("run data", () => this.#tell());
    // A browser lets a page sound only after the user has touched it.
    const restored = () => this.#kept() && this.#switch(true);
    if (state.live) document.addEventListener("pointerdown", restored, { once: true });
  }

  get on() {
    return this.button.getAttribute("aria-pressed") === "true";
  }

  #kept() {
    try {
      return localStorage.getItem(KEPT) === "on" && !this.on;
    } catch {
      return false;
    }
  }

  #switch(on) {
    this.button.setAttribute("aria-pressed", String(on));
    this.button.textContent = say(on ? "Sound on" : "Sound off");
    try {
      localStorage.setItem(KEPT, on ? "on" : "off");
    } catch { /* a browser that keeps nothing */ }
    if (!on) return;
    this.context ??= new AudioContext();
    if (window.Notification?.permission === "default") window.Notification.requestPermission();
  }

  #tell() {
    const { run, live } = this.state;
    if (!live || !run) return;
    const alarms = alarmsAt(run, run.nowMs);
    // What was before the page was opened is no news.
    const news = run === this.run ? alarms.filter((words) => !this.known.has(words)) : [];
    this.run = run;
    this.known = new Set(alarms);
    if (news.length === 0) return;
    const words = newsWords(news);
    byId("news").title = byId("news").textContent = say("New: {what}", { what: words });
    byId("news").hidden = false;
    if (!this.on) return;
    ring(this.context);
    if (window.Notification?.permission === "granted") new window.Notification(`Muster: ${run.name}`, { body: words, tag: "muster" });
  }
}
