// A phone in a pocket: it hums when there is something new, and sounds where its owner wants that.
import { say } from "./language.mjs";

const KEPT = "muster-phone-sound";
const HUM_MS = [250, 120, 250];

export class Noise {
  #last = null;

  /** `button`: switches the sound; `storage`: localStorage, or null. */
  constructor(button, storage) {
    Object.assign(this, { button, storage, context: null });
    this.#set(false);
    button.addEventListener("click", () => this.#set(button.getAttribute("aria-pressed") !== "true", true));
    // A browser lets a page sound only after somebody has touched it.
    if (storage?.getItem(KEPT) === "on") addEventListener("pointerdown", () => this.#set(true), { once: true });
  }

  #set(isOn, isChosen = false) {
    this.button.setAttribute("aria-pressed", String(isOn));
    this.button.textContent = say(isOn ? "Sound is on" : "Sound is off");
    if (isOn) this.context ??= new AudioContext();
    if (isOn && isChosen) this.#ring();
    if (isChosen) this.storage?.setItem(KEPT, isOn ? "on" : "off");
  }

  /** What the person is to do, as a text: when it changes, it hums. */
  hear(now) {
    const isNew = this.#last !== null && now !== this.#last;
    this.#last = now;
    if (!isNew) return;
    // A browser lets a page vibrate only after somebody has touched it, and complains where one tries before.
    if (navigator.userActivation?.hasBeenActive !== false) navigator.vibrate?.(HUM_MS);
    if (this.button.getAttribute("aria-pressed") === "true") this.#ring();
  }

  #ring() {
    const { context } = this, from_s = context.currentTime;
    for (const [at_s, hertz] of [[0, 660], [0.2, 880]]) {
      const [tone, volume] = [context.createOscillator(), context.createGain()];
      tone.frequency.value = hertz;
      volume.gain.setValueAtTime(0.3, from_s + at_s);
      volume.gain.exponentialRampToValueAtTime(0.001, from_s + at_s + 0.18);
      tone.connect(volume).connect(context.destination);
      tone.start(from_s + at_s);
      tone.stop(from_s + at_s + 0.2);
    }
  }
}
