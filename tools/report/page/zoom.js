const LEAST = 0.8;
export const MOST = 60;
const DRAG_PX = 3;

/** What is at scale 1 at x is on the screen at left + k x; y alike with top. */
export const WHOLE = { k: 1, left: 0, top: 0 };

/** `view` so many times larger, within bounds; what is at (x, y) stays there. */
export function zoomed(view, factor, x, y) {
  const k = Math.min(MOST, Math.max(Math.min(LEAST, view.k), view.k * factor));
  const by = k / view.k;
  return { k, left: x - (x - view.left) * by, top: y - (y - view.top) * by };
}

/** `view` moved and zoomed so that what was under `before` is under `after`: one or two places. */
export function gripped(view, before, after) {
  const middle = (places) => places.reduce((sum, p) => ({ x: sum.x + p.x / places.length, y: sum.y + p.y / places.length }), { x: 0, y: 0 });
  const [from, to] = [middle(before), middle(after)];
  const moved = { ...view, left: view.left + to.x - from.x, top: view.top + to.y - from.y };
  if (before.length < 2) return moved;
  const apart = ([a, b]) => Math.hypot(a.x - b.x, a.y - b.y) || 1;
  return zoomed(moved, apart(after) / apart(before), to.x, to.y);
}

/** The wheel, a drag and two fingers move and zoom `canvas`: change(next view) after each. Returns whether it is held, when asked. */
export function bindZoom(canvas, view, change) {
  const pointers = new Map();
  let travelled = 0;
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const perNotch = event.deltaMode === 1 ? 0.05 : event.deltaMode ? 1 : 0.002;
    const { x, y } = place(event);
    // A pinch on a touchpad is a wheel with ctrl, in smaller steps.
    change(zoomed(view(), 2 ** (-event.deltaY * perNotch * (event.ctrlKey ? 10 : 1)), x, y));
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || event.ctrlKey || pointers.size === 2) return;
    if (pointers.size === 0) travelled = 0;
    pointers.set(event.pointerId, place(event));
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = pointers.get(event.pointerId);
    if (!last) return;
    const before = [...pointers.values()];
    const now = place(event);
    travelled += Math.hypot(now.x - last.x, now.y - last.y);
    pointers.set(event.pointerId, now);
    change(gripped(view(), before, [...pointers.values()]));
  });
  for (const end of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
  }
  // The click at a drag's end is none.
  canvas.addEventListener("click", (event) => {
    if (travelled > DRAG_PX) event.stopImmediatePropagation();
    travelled = 0;
  }, true);
  return () => pointers.size > 0;
}
