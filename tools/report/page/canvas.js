import { VEHICLE, WORKER } from "./words.js";

/** Fits a canvas to its box at the screen's resolution; returns its context and size in CSS pixels. */
export function fit(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

const paper = globalThis.matchMedia?.("print");

/** Runs `draw` at most once a frame, however often it is asked for; on paper, which does not wait for a frame, at once. */
export function oncePerFrame(draw) {
  let due = false;
  let drawing = false;
  return () => {
    if (paper?.matches) {
      if (drawing) return;
      drawing = true;
      draw();
      drawing = false;
      return;
    }
    if (due) return;
    due = true;
    requestAnimationFrame(() => {
      due = false;
      draw();
    });
  };
}

/** Adds an agent's shape around (x, y) to the path: arrow head, circle or square by class. */
export function agentShape(path, kind, x, y, r, heading = 0) {
  if (kind === WORKER) {
    path.moveTo(x + r, y);
    path.arc(x, y, r, 0, 2 * Math.PI);
  } else if (kind === VEHICLE) {
    path.rect(x - r * 0.9, y - r * 0.9, r * 1.8, r * 1.8);
  } else {
    const point = (angle, length) => [x + length * Math.cos(heading + angle), y + length * Math.sin(heading + angle)];
    path.moveTo(...point(0, r * 1.55));
    path.lineTo(...point(2.5, r * 1.35));
    path.lineTo(...point(Math.PI, r * 0.55));
    path.lineTo(...point(-2.5, r * 1.35));
    path.closePath();
  }
}

export function cross(path, x, y, r) {
  path.moveTo(x - r, y - r);
  path.lineTo(x + r, y + r);
  path.moveTo(x - r, y + r);
  path.lineTo(x + r, y - r);
}
