export const SPEEDS = [30, 60, 120, 300, 600, 1200, 3600]; // mission seconds per second

/** The one time that everything on the page shows. */
export class Clock {
  constructor() {
    this.t = 0;
    this.max = 1;
    this.playing = false;
    this.follow = false; // stays at the newest time of a live mission
    this.speed = 300;
    this.listeners = new Set();
    this.last = null;
  }

  subscribe(listener) {
    this.listeners.add(listener);
  }

  seek(t, follow = false) {
    this.follow = follow;
    this.t = Math.min(this.max, Math.max(0, t));
    if (this.playing && this.t >= this.max) this.playing = false;
    for (const listener of this.listeners) listener(this.t);
  }

  toggle() {
    if (!this.playing && this.t >= this.max) this.t = 0;
    this.playing = !this.playing;
    this.last = null;
    if (this.playing) requestAnimationFrame((now) => this.#frame(now));
    this.seek(this.t);
  }

  pause() {
    if (this.playing) this.toggle();
  }

  faster(steps) {
    const i = SPEEDS.indexOf(this.speed);
    this.speed = SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, i + steps))];
    this.seek(this.t, this.follow);
  }

  #frame(now) {
    if (!this.playing) return;
    if (this.last !== null) this.seek(this.t + Math.min(250, now - this.last) * this.speed);
    this.last = now;
    if (this.playing) requestAnimationFrame((next) => this.#frame(next));
  }
}
