import { say } from "../language.js";
import { theme } from "../theme.js";

function mark(c, r) {
  c.strokeStyle = theme.charging;
  c.lineWidth = 1.4;
  c.beginPath();
  c.rect(-r, -r, 2 * r, 2 * r);
  c.moveTo(-r * 0.5, 0);
  c.lineTo(r * 0.5, 0);
  c.moveTo(0, -r * 0.5);
  c.lineTo(0, r * 0.5);
  c.stroke();
}

/** Charging points. */
export const charging = {
  id: "charging",
  title: say("Charging points"),
  legend: [{ mark: '<path d="M1.5 1.5h9v9h-9ZM6 4v4M4 6h4" class="l-charging"/>', words: say("charging point") }],
  draw(c, { points, r, sprites }) {
    for (const { px, py } of points) sprites.stamp(c, `charging ${r}`, r * 2 + 3, px, py, (s) => mark(s, r));
  },
};
