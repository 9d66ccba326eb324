// Which alerts stand out on the map. With hundreds of them a ring around each would make none stand out. As with clusters, that
// depends on places, urgency and zoom, and never on which part of the map is in view.
import { FAILED } from "./words.js";

const MOST = 10; // of the whole map stand out wherever they are
const COARSER = 1; // levels: the squares, in each of which one more stands out, are 128 to 256 pixels wide

/**
 * Of items with an alert ({ x, y in metres, status, order: 0 is the most urgent }) those that stand out at a level of clusters.js'
 * grid: the most urgent of all, and the most urgent of each square. Those that have failed are counted apart: they are crosses.
 */
export function loudAlerts(items, level) {
  const failed = ({ status }) => status === FAILED;
  return new Set([...mostUrgent(items.filter(failed), level), ...mostUrgent(items.filter((item) => !failed(item)), level)]);
}

function mostUrgent(items, level) {
  const side = 2 ** (level + COARSER);
  const squares = new Set();
  return [...items].sort((a, b) => a.order - b.order).filter(({ x, y }, i) => {
    const square = `${Math.floor(x / side)} ${Math.floor(y / side)}`;
    const first = !squares.has(square);
    squares.add(square);
    return first || i < MOST;
  });
}
