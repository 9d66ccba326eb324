const DRAG_PX = 4;

/**
 * Agents that are dragged with a mouse or a pen; a finger moves the map. `grab(event)`: who is there, null: nobody who may be dragged.
 * `moved({ agent, event })` follows the pointer, `moved(null)` at the end. `dropped(agent, event)`: unless Escape was pressed.
 */
export function bindDrag(canvas, { grab, moved, dropped }) {
  let held = null;
  let dragged = false;
  const end = () => {
    held = null;
    moved(null);
  };
  canvas.addEventListener("pointerdown", (event) => {
    dragged = false;
    if (event.button !== 0 || event.ctrlKey || event.pointerType === "touch") return;
    const agent = grab(event);
    if (!agent) return;
    held = { agent, x: event.offsetX, y: event.offsetY };
    canvas.setPointerCapture(event.pointerId);
    event.stopImmediatePropagation(); // the map stays
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!held) return;
    event.stopImmediatePropagation();
    dragged ||= Math.hypot(event.offsetX - held.x, event.offsetY - held.y) > DRAG_PX;
    if (dragged) moved({ agent: held.agent, event });
  });
  canvas.addEventListener("pointerup", (event) => {
    if (!held) return;
    const { agent } = held;
    end();
    if (dragged) dropped(agent, event);
  });
  canvas.addEventListener("pointercancel", end);
  document.addEventListener("keydown", (event) => {
    if (held && event.key === "Escape") end();
  });
  // The click at a drag's end is none.
  canvas.addEventListener("click", (event) => {
    if (dragged) event.stopImmediatePropagation();
    dragged = false;
  }, true);
}
