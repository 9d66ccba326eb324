import { agentShape } from "../canvas.js";
import { CHARGING_POINT, OVER, TO_DO } from "../clusters.js";
import { theme } from "../theme.js";
import { alertDot } from "./agents.js";

const COLUMN_PX = 29;
const ROW_PX = 12;
const EDGE_PX = 2;
const SHAPE_PX = 3.4; // from a shape's middle
const FONT = "10px system-ui, sans-serif";

/** "7", "999", "1.2k", "12k" */
export function short(n) {
  if (n < 1000) return String(n);
  return n < 9950 ? `${(n / 1000).toFixed(1)}k` : `${Math.round(n / 1000)}k`;
}

/** A cluster's badge on the screen, within its square: { left, top, wide, high }. */
export function badgeOf({ x: east, y: north, counts, square }, { x, y }) {
  const n = counts.filter((count) => count > 0).length;
  const wide = Math.min(n, 2) * COLUMN_PX + 2 * EDGE_PX;
  const high = Math.ceil(n / 2) * ROW_PX + 2 * EDGE_PX;
  const within = (middle, from, to, size) => Math.min(to - size, Math.max(from, middle - size / 2));
  return { left: within(x(east), x(square.west), x(square.west + square.side), wide),
    top: within(y(north), y(square.south + square.side), y(square.south), high), wide, high };
}

function shape(c, of, x, y) {
  const r = SHAPE_PX;
  c.beginPath();
  if (of < TO_DO) {
    agentShape(c, of, x, y, r, -Math.PI / 2);
    c.fillStyle = theme.kinds[of];
    return c.fill();
  }
  c.lineWidth = 1.3;
  if (of === CHARGING_POINT) {
    c.rect(x - r, y - r, 2 * r, 2 * r);
    c.moveTo(x - r / 2, y);
    c.lineTo(x + r / 2, y);
    c.moveTo(x, y - r / 2);
    c.lineTo(x, y + r / 2);
    c.strokeStyle = theme.charging;
  } else if (of === OVER) {
    c.moveTo(x - r, y);
    c.lineTo(x - r * 0.2, y + r * 0.8);
    c.lineTo(x + r, y - r);
    c.strokeStyle = theme.done;
  } else {
    c.moveTo(x, y - r);
    c.lineTo(x + r, y);
    c.lineTo(x, y + r);
    c.lineTo(x - r, y);
    c.closePath();
    c.strokeStyle = theme.task;
  }
  return c.stroke();
}

/** A badge around the origin: for each class its shape and its number, and a dot at its corner where it hides an alert. */
function badge(c, { counts, alerts }, wide, high) {
  c.beginPath();
  c.rect(-wide / 2, -high / 2, wide, high);
  c.fillStyle = theme.panel;
  c.fill();
  c.lineWidth = 1;
  c.strokeStyle = theme.muted;
  c.stroke();
  c.font = FONT;
  c.textAlign = "left";
  c.textBaseline = "middle";
  counts.map((n, of) => [n, of]).filter(([n]) => n > 0).forEach(([n, of], i) => {
    const left = -wide / 2 + EDGE_PX + (i % 2) * COLUMN_PX;
    const middle = -high / 2 + EDGE_PX + (Math.floor(i / 2) + 0.5) * ROW_PX;
    shape(c, of, left + SHAPE_PX + 1.5, middle);
    c.fillStyle = theme.text;
    c.fillText(short(n), left + 2 * SHAPE_PX + 4, middle + 0.5);
  });
  if (alerts > 0) alertDot(c, wide / 2, -high / 2);
}

/** A badge for each cluster, and a ring around the one that the keyboard is at. */
export const clusters = {
  shows: (map) => map.clusters.length > 0,
  draw(c, map) {
    for (const cluster of map.clusters) {
      const { left, top, wide, high } = badgeOf(cluster, map);
      const key = `badge ${cluster.counts.map(short).join()} ${cluster.alerts > 0}`;
      map.sprites.stamp(c, key, Math.max(wide, high) / 2 + 3, left + wide / 2, top + high / 2, (s) => badge(s, cluster, wide, high));
      if (cluster.key !== map.pointed) continue;
      c.strokeStyle = theme.accent;
      c.lineWidth = 3;
      c.strokeRect(left - 2, top - 2, wide + 4, high + 4);
    }
  },
};
