import { theme } from "../theme.js";

/** The ground of the area. */
export const ground = {
  draw(c, { run, x, y }) {
    const { width_m: w, height_m: h } = run.scenario;
    c.fillStyle = theme.bg;
    c.fillRect(x(0), y(h), x(w) - x(0), y(0) - y(h));
  },
};
