// The map: the area, where you are, where to go and by which way. Metres, north is up.
import { say } from "./language.mjs";
import { ahead } from "./way.mjs";

const WIDTH = 360, HEIGHT = 260, EDGE = 34;
export const SIZE = { width: WIDTH, height: HEIGHT };
const LEAST_M = 200;
const SVG = "http://www.w3.org/2000/svg";

/** What is shown: {x_m, y_m} in its middle, and pixels for a metre. */
export function frame(places, area) {
  const xs = places.map(({ x_m }) => x_m), ys = places.map(({ y_m }) => y_m);
  if (!places.length) return frame([{ x_m: 0, y_m: 0 }, { x_m: area.width_m, y_m: area.height_m }], area);
  const [west, east, south, north] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const scale = Math.min((WIDTH - 2 * EDGE) / Math.max(LEAST_M, east - west), (HEIGHT - 2 * EDGE) / Math.max(LEAST_M, north - south));
  return { x_m: (west + east) / 2, y_m: (south + north) / 2, scale };
}

/** A round length that is not too long to be drawn. */
export function roundLength_m(scale) {
  const most_m = 120 / scale, power = 10 ** Math.floor(Math.log10(most_m));
  return [5, 2, 1].find((n) => n * power <= most_m) * power;
}

function add(svg, name, attributes, text) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text) element.textContent = text;
  svg.append(element);
}

/** Returns the frame of what it shows, or null. `heading_deg`: where the phone points, from north to east; null: it does not say. */
export function drawMap(svg, view, heading_deg = null) {
  svg.replaceChildren();
  if (!view.agent) return null;
  const { area, told, order } = view;
  const own = view.place ?? told;
  const goal = order && ["going", "held", "there", "working"].includes(order.stage) ? order.to : null;
  const way = !goal ? [] : order.way && order.stage === "going" ? ahead(order.way, own) : [own, goal];
  const shown = frame([own, told, ...way], area);
  const x = ({ x_m }) => WIDTH / 2 + (x_m - shown.x_m) * shown.scale, y = ({ y_m }) => HEIGHT / 2 - (y_m - shown.y_m) * shown.scale;
  add(svg, "rect", { class: "area", x: x({ x_m: 0 }), y: y({ y_m: area.height_m }), width: area.width_m * shown.scale, height: area.height_m * shown.scale });
  if (goal) {
    add(svg, "polyline", { class: "way", points: way.map((place) => `${x(place).toFixed(1)},${y(place).toFixed(1)}`).join(" ") });
    add(svg, "circle", { class: "goal", cx: x(goal), cy: y(goal), r: 9 });
    add(svg, "text", { x: Math.min(x(goal) + 13, WIDTH - 60), y: y(goal) - 10 }, say("go here"));
  }
  if (view.place) add(svg, "circle", { class: "accuracy", cx: x(own), cy: y(own), r: Math.min(WIDTH, view.place.accuracy_m * shown.scale) });
  if (told.is_limited || !view.place) add(svg, "circle", { class: "told", cx: x(told), cy: y(told), r: 8 });
  if (view.place && heading_deg === null) add(svg, "circle", { class: "own", cx: x(own), cy: y(own), r: 6 });
  if (view.place && heading_deg !== null) {
    add(svg, "path", { class: "own", d: "M0 -12 8 9 0 5 -8 9Z", transform: `translate(${x(own)} ${y(own)}) rotate(${heading_deg})` });
  }
  const length_m = roundLength_m(shown.scale), width = length_m * shown.scale;
  add(svg, "line", { class: "scale", x1: 12, y1: HEIGHT - 12, x2: 12 + width, y2: HEIGHT - 12 });
  add(svg, "text", { x: 12, y: HEIGHT - 18 }, length_m < 1000 ? `${length_m} m` : `${length_m / 1000} km`);
  add(svg, "text", { x: WIDTH - 34, y: HEIGHT - 12 }, "N ↑");
  return shown;
}
