import { theme } from "../theme.js";

/** A place that is being asked about. */
export const marked = {
  shows: ({ place }) => place,
  draw(c, { place, x, y, r }) {
    const [px, py] = [x(place.x), y(place.y)];
    c.strokeStyle = theme.accent;
    c.lineWidth = 2;
    c.beginPath();
    c.arc(px, py, r * 2, 0, 2 * Math.PI);
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      c.moveTo(px + dx * r, py + dy * r);
      c.lineTo(px + dx * r * 3, py + dy * r * 3);
    }
    c.stroke();
  },
};
