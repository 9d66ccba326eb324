import { numbersOf } from "../compare.js";
import { say } from "../language.js";
import { doneAt } from "../run.js";
import { clockText } from "../time.js";
import { theme } from "../theme.js";
import { webm } from "./webm.js";

const KEY_EVERY = 48; // frames
const BITS_PER_S = 8_000_000;
const CODECS = [["vp09.00.40.08", "V_VP9"], ["vp8", "V_VP8"]];
const WAITING = 4; // frames that wait for the encoder

/** Base64 of a blob. */
const base64 = (blob) => new Promise((resolve, reject) => {
  const reader = new FileReader();
  reader.onload = () => resolve(reader.result.slice(reader.result.indexOf(",") + 1));
  reader.onerror = () => reject(reader.error);
  reader.readAsDataURL(blob);
});

const frames = (n) => new Promise((resolve) => {
  const next = (left) => (left === 0 ? resolve() : requestAnimationFrame(() => next(left - 1)));
  next(n);
});

/** Pictures and films of the scene, over all of the window: `muster report --scene`. */
export class Film {
  constructor(view) {
    this.view = view;
  }

  /** Gives the scene the whole window. */
  async stage() {
    document.documentElement.dataset.stage = "";
    await frames(3); // until the canvas has its size
    const { canvas, orbit } = this.view;
    this.view.measure();
    if (!this.view.follow) orbit.fit();
    this.canvas = Object.assign(document.createElement("canvas"), { width: canvas.clientWidth, height: canvas.clientHeight });
    if (this.canvas.width === 0) throw new Error(say("the scene has no room"));
  }

  /** Scene, names and a caption on one canvas. */
  #compose() {
    const { view, canvas } = this;
    view.drawNow();
    const { width, height } = canvas;
    const c = canvas.getContext("2d", { willReadFrequently: true });
    c.drawImage(view.canvas, 0, 0, width, height);
    c.drawImage(view.labels, 0, 0, width, height);
    const { run, clock } = view;
    const u = height / 36;
    c.font = `600 ${u * 1.15}px system-ui, "DejaVu Sans", sans-serif`;
    c.fillStyle = theme.text;
    c.textAlign = "left";
    c.fillText(`${run.scenario.name}, ${numbersOf(run).policy}`, u, u * 1.8);
    c.font = `${u * 0.9}px system-ui, "DejaVu Sans", sans-serif`;
    c.fillText(`${clockText(clock.t)}   ${say("{n} of {total} tasks done", { n: doneAt(run, clock.t), total: run.tasksTotal })}`, u, u * 3.2);
    c.fillStyle = theme.muted;
    c.font = `${u * 0.55}px system-ui, "DejaVu Sans", sans-serif`;
    c.fillText(this.#caption(), u, height - u * 0.8);
    return canvas;
  }

  #caption() {
    const { view } = this;
    if (view.mode === "time") return say("Time goes up.");
    if (view.times === null && view.scenery) return say("Heights and sizes are for the eye; blocks are scenery.");
    return view.scenery ? `${view.heightWords} ${say("Blocks are scenery.")}` : view.heightWords;
  }

  /** A PNG, in base64. */
  async picture() {
    await this.stage();
    const canvas = this.#compose();
    return base64(await new Promise((resolve) => canvas.toBlob(resolve, "image/png")));
  }

  /** Begins a film of all the mission; returns how many frames frame() must be told. */
  async begin(seconds, perSecond, turn) {
    if (this.view.state.selected?.type === "agent") this.view.setFollow(true);
    await this.stage();
    Object.assign(this, { n: Math.round(seconds * perSecond), perSecond, turn, frames: [] });
    this.start = this.view.orbit.azimuth;
    const { width, height } = this.canvas;
    for (const [codec, name] of typeof VideoEncoder === "undefined" ? [] : CODECS) {
      const config = { codec, width, height, bitrate: BITS_PER_S, framerate: perSecond, latencyMode: "quality" };
      if (!(await VideoEncoder.isConfigSupported(config)).supported) continue;
      this.codec = name;
      this.encoder = new VideoEncoder({ output: (chunk) => this.#keep(chunk), error: (error) => { this.failed = error; } });
      this.encoder.configure(config);
      return this.n;
    }
    throw new Error(say("this browser encodes no WebM film"));
  }

  #keep(chunk) {
    const data = new Uint8Array(chunk.byteLength);
    chunk.copyTo(data);
    this.frames.push({ ms: Math.round(chunk.timestamp / 1000), key: chunk.type === "key", data });
  }

  /** Draws and takes frames from `i` on, `count` of them. */
  async take(i, count) {
    const { view, encoder } = this;
    for (const until = Math.min(this.n, i + count); i < until; ++i) {
      const share = i / Math.max(1, this.n - 1);
      view.clock.seek(share * view.run.nowMs);
      view.orbit.azimuth = this.start + share * this.turn;
      if (!view.follow) view.orbit.fit();
      const frame = new VideoFrame(this.#compose(), { timestamp: Math.round((i * 1e6) / this.perSecond), duration: Math.round(1e6 / this.perSecond) });
      encoder.encode(frame, { keyFrame: i % KEY_EVERY === 0 });
      frame.close();
      while (encoder.encodeQueueSize > WAITING && !this.failed) await frames(1);
      if (this.failed) throw this.failed;
    }
  }

  /** The film, in base64. */
  async end() {
    await this.encoder.flush();
    this.encoder.close();
    const { width, height } = this.canvas;
    return base64(webm({ width, height, codec: this.codec, frames: this.frames, durationMs: (1000 * this.n) / this.perSecond }));
  }
}
