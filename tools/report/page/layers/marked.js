import { theme } from "../theme.js";

/** A place, or the corners of an area, that is being asked about; and from where to where an agent is dragged. */
export const marked = {
  shows: ({ place, area, drag }) => place || area?.length || drag,
  draw(c, { place, area, drag, near, x, y, r }) {
    c.strokeStyle = theme.accent;
    c.lineWidth = 2;
    c.beginPath();
    for (const corner of area ?? []) c.lineTo(x(corner.x), y(corner.y));
    if (area?.length > 2 && !area.open) c.closePath();
    for (const corner of area ?? []) c.rect(x(corner.x) - 2, y(corner.y) - 2, 4, 4);
    const from = drag && near.find(({ agent }) => agent === drag.agent);
    if (from) {
      c.moveTo(from.px, from.py);
      c.lineTo(...drag.to);
      c.moveTo(drag.to[0] + r * 2, drag.to[1]);
      c.arc(...drag.to, r * 2, 0, 2 * Math.PI);
    }
    if (!place) return c.stroke();
    const [px, py] = [x(place.x), y(place.y)];
    c.moveTo(px + r * 2, py);
    c.arc(px, py, r * 2, 0, 2 * Math.PI);
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      c.moveTo(px + dx * r, py + dy * r);
      c.lineTo(px + dx * r * 3, py + dy * r * 3);
    }
    c.stroke();
  },
};
