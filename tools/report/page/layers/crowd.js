import { agentShape, cross } from "../canvas.js";
import { number } from "../dom.js";
import { theme } from "../theme.js";
import { CANCELLED, DONE, EXPIRED, FAILED } from "../words.js";

/** More symbols in view than this stand together, one for all of a kind in a square of the screen. */
export const MOST_SYMBOLS = 4000;
const CELL_PX = 30;
const KINDS = 5; // UAVs, workers, vehicles, failed agents, tasks to do
const FAILED_AGENTS = 3;
const TASKS = 4;
const NAMES = ["UAV", "worker", "vehicle", "failed", "task to do"];
/** Where in a square the symbol of each kind is, as parts of its side. */
const PLACES = [[0.27, 0.27], [0.73, 0.27], [0.27, 0.73], [0.5, 0.5], [0.73, 0.73]];

/** How many of each kind are in each square of the screen: { counts, columns, rows, most }. */
export function countCells(agents, tasks, { width, height }) {
  const columns = Math.ceil(width / CELL_PX);
  const rows = Math.ceil(height / CELL_PX);
  const counts = new Uint32Array(columns * rows * KINDS);
  const add = (px, py, kind) => {
    const column = Math.floor(px / CELL_PX);
    const row = Math.floor(py / CELL_PX);
    if (column >= 0 && column < columns && row >= 0 && row < rows) ++counts[(row * columns + column) * KINDS + kind];
  };
  for (const { agent, status, px, py } of agents) add(px, py, status === FAILED ? FAILED_AGENTS : agent.kind);
  for (const { status, px, py } of tasks) if (![DONE, EXPIRED, CANCELLED].includes(status)) add(px, py, TASKS);
  return { counts, columns, rows, most: counts.reduce((a, b) => Math.max(a, b), 1) };
}

function shape(c, kind, x, y, r) {
  if (kind < FAILED_AGENTS) agentShape(c, kind, x, y, r, -Math.PI / 2);
  else if (kind === FAILED_AGENTS) cross(c, x, y, r);
  else {
    c.moveTo(x, y - r);
    c.lineTo(x + r, y);
    c.lineTo(x, y + r);
    c.lineTo(x - r, y);
    c.closePath();
  }
}

/** One symbol for all of a kind in each square: its area grows with their number. */
function draw(c, { cells: { counts, columns, rows, most } }) {
  for (const kind of [TASKS, 2, 1, 0, FAILED_AGENTS]) {
    c.beginPath();
    for (let cell = 0; cell < columns * rows; ++cell) {
      const n = counts[cell * KINDS + kind];
      if (n === 0) continue;
      const x = ((cell % columns) + PLACES[kind][0]) * CELL_PX;
      const y = (Math.floor(cell / columns) + PLACES[kind][1]) * CELL_PX;
      shape(c, kind, x, y, Math.max(1.3, 6.5 * Math.sqrt(n / most)));
    }
    if (kind === TASKS || kind === FAILED_AGENTS) {
      c.strokeStyle = kind === TASKS ? theme.task : theme.failed;
      c.lineWidth = kind === TASKS ? 1.3 : 2;
      c.stroke();
    } else {
      c.fillStyle = theme.kinds[kind];
      c.fill();
    }
  }
}

export const crowd = { shows: ({ cells }) => cells, draw };

/** "12 UAVs, 30 workers, 4 tasks to do" in the square at (x, y) of the screen; "" where there is nothing. */
export function cellWords({ counts, columns, rows }, x, y) {
  const column = Math.floor(x / CELL_PX);
  const row = Math.floor(y / CELL_PX);
  if (column < 0 || column >= columns || row < 0 || row >= rows) return "";
  return [0, 1, 2, 3, 4].map((kind) => [counts[(row * columns + column) * KINDS + kind], kind]).filter(([n]) => n > 0)
    .map(([n, kind]) => `${number(n)} ${kind === FAILED_AGENTS || n === 1 ? NAMES[kind] : NAMES[kind].replace(/(UAV|worker|vehicle|task)/, "$1s")}`).join(", ");
}
