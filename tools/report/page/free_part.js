// What floats on the map covers some of it. The rest is its free part: what the map is fitted to shows there.
import { byId } from "./dom.js";
import { PHONE } from "./folding.js";

export const ALL_FREE = { left: 0, top: 0, right: 0, bottom: 0 };
const MOST = 0.6; // of the map's height that a sheet counts for: below a full one no map is left

/** So many pixels at each side of `box` are covered by `covers`: { side, tools, legend }, boxes on the screen or null. */
export function freeWithin(box, { side, tools, legend }, phone) {
  const below = (cover) => (cover ? Math.max(0, box.bottom - cover.top) : 0);
  const bottom = phone ? Math.min(MOST * box.height, below(side)) : below(legend);
  return { left: phone || !side ? 0 : Math.max(0, side.right - box.left), top: tools ? Math.max(0, tools.bottom - box.top) : 0, right: 0, bottom };
}

/** Tells the style sheet how much is covered: what stands at the edges of the map stands within. */
function tell(free) {
  for (const side of ["left", "top", "bottom"]) byId("map-panel").style.setProperty(`--free-${side}`, `${Math.round(free[side])}px`);
  return free;
}

/** The same as it is on the page, of the map or of another `view` in its place; null while that is not shown. */
export function freePart(state, view = byId("map-box")) {
  const box = view.getBoundingClientRect();
  if (box.width === 0) return null;
  if (state.wall || matchMedia("print").matches || "stage" in document.documentElement.dataset) return tell(ALL_FREE);
  const phone = matchMedia(PHONE).matches;
  const boxOf = (id) => byId(id).getBoundingClientRect();
  const isLow = document.documentElement.hasAttribute("data-below");
  const side = phone ? (isLow ? null : boxOf("side")) : state.folded.has("attention") ? null : boxOf("side");
  // Tools that are unfolded on a phone, for a moment, lie over the map.
  const tools = boxOf(phone ? "search-box" : "map-tools");
  return tell(freeWithin(box, { side, tools, legend: boxOf("legend-box") }, phone));
}
