import { say } from "../language.js";
import { theme } from "../theme.js";

/** By class, as tools/tiles/vector_tile.h numbers them: a colour of the theme, and of lines the width in pixels. */
const STYLES = [["green"], ["built"], ["water"], ["shore", 0.8], ["building"], ["street", 0.5], ["street", 0.8], ["street", 1], ["road", 1.4], ["road", 2.2]];
const PICTURE_ALPHA = 0.62; // symbols stay the loudest thing
const OVERLAP_PX = 1; // of strips, so that no gap shows between them
const NAMES = 40;
/** The least important names that are shown at so many pixels a metre. */
const RANKS = [[0.1, 5], [0.05, 4], [0.02, 3], [0.01, 2], [0, 1]];

function drawPicture(c, { picture, strips }, { x, y }) {
  for (const { from, to, corners: [nw, ne, sw] } of strips) {
    const { width } = picture;
    const [top, height] = [from * picture.height, (to - from) * picture.height];
    const right = [x(ne.x) - x(nw.x), y(ne.y) - y(nw.y)];
    const down = [x(sw.x) - x(nw.x), y(sw.y) - y(nw.y)];
    const grow = 1 + OVERLAP_PX / Math.max(1, down[1]);
    c.save();
    c.transform(right[0] / width, right[1] / width, down[0] / height, down[1] / height, x(nw.x), y(nw.y));
    c.drawImage(picture, 0, top, width, height, 0, 0, width * (1 + OVERLAP_PX / Math.max(1, right[0])), height * grow);
    c.restore();
  }
}

function drawShapes(c, tiles, { x, y }) {
  const perM = x(1) - x(0);
  const widen = Math.min(5, Math.max(1, Math.sqrt(perM / 0.03)));
  c.transform(perM, 0, 0, y(1) - y(0), x(0), y(0));
  c.lineJoin = "round";
  STYLES.forEach(([colour, width], of) => {
    c.fillStyle = c.strokeStyle = theme[colour];
    c.lineWidth = ((width ?? 0) * widen) / perM;
    for (const { paths } of tiles) {
      if (width) c.stroke(paths[of]);
      else c.fill(paths[of]);
    }
  });
}

/** Draws only within these squares. */
function clip(c, parts, { x, y }) {
  c.beginPath();
  for (const corners of parts) {
    corners.forEach((corner, i) => (i ? c.lineTo(x(corner.x), y(corner.y)) : c.moveTo(x(corner.x), y(corner.y))));
    c.closePath();
  }
  c.clip();
}

function drawTiles(c, tiles, map, isVector) {
  for (const tile of tiles.filter(({ parts }) => parts)) {
    c.save();
    clip(c, tile.parts, map);
    if (isVector) drawShapes(c, [tile], map);
    else drawPicture(c, tile, map);
    c.restore();
  }
  const whole = tiles.filter(({ parts }) => !parts);
  if (isVector) drawShapes(c, whole, map);
  else for (const tile of whole) drawPicture(c, tile, map);
}

export const boxOf = ({ x, y, width, height }) => ({ west: x.invert(0), east: x.invert(width), south: y.invert(height), north: y.invert(0) });

/** The base map, drawn once for what is in view and then kept until that changes. */
let kept = { key: "", canvas: null };

/** A base map from a file of tiles. */
export const baseMap = {
  id: "map",
  title: say("Base map"),
  legend: [{ id: "basemap", mark: '<path d="M.5 2 4 .5l4 1.5 3.5-1.5V10L8 11.5 4 10 .5 11.5Z" class="l-road"/>',
    words: (run) => (run.baseMap?.info.source ? say("map: {source}", { source: run.baseMap.info.source }) : say("map")), shows: (run) => run.baseMap !== null }],
  shows: ({ run }) => run.baseMap,
  draw(c, map) {
    const { run, x, y, width, height } = map;
    const { baseMap: base } = run;
    if (!base) return;
    const tiles = base.within(boxOf(map), x(1) - x(0));
    const { a: ratio } = c.getTransform();
    const key = [x(0), y(0), x(1), width, height, ratio, base.version, theme.bg].join();
    if (kept.key !== key || kept.base !== base) {
      const canvas = kept.canvas ?? document.createElement("canvas");
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
      const below = canvas.getContext("2d");
      below.scale(ratio, ratio);
      drawTiles(below, tiles, map, base.info.vector);
      kept = { key, base, canvas };
    }
    c.save();
    c.globalAlpha = base.info.vector ? 1 : PICTURE_ALPHA;
    c.drawImage(kept.canvas, 0, 0, width, height);
    c.restore();
  },
};

/** The names of places in view, the most important first: { text, x, y } in metres. */
export function baseMapNames(map) {
  const { baseMap: base } = map.run;
  if (!base?.info.vector) return [];
  const [, most] = RANKS.find(([least]) => map.perMetre >= least);
  const names = base.within(boxOf(map), map.perMetre).flatMap((tile) => tile.names).filter(({ rank }) => rank <= most);
  const once = new Map(names.map((name) => [name.text, name])); // a closer tile repeats what the one below has
  return [...once.values()].sort((a, b) => a.rank - b.rank).slice(0, NAMES);
}
