// The way by road to the goal: its corners, and how much of it is left.

function nearestOn(a, b, at) {
  const [dx, dy] = [b.x_m - a.x_m, b.y_m - a.y_m];
  const square = dx * dx + dy * dy;
  const share = square === 0 ? 0 : Math.min(1, Math.max(0, ((at.x_m - a.x_m) * dx + (at.y_m - a.y_m) * dy) / square));
  return { x_m: a.x_m + share * dx, y_m: a.y_m + share * dy };
}

export const apart = (a, b) => Math.hypot(a.x_m - b.x_m, a.y_m - b.y_m);

/** From a place, by the part of the way that is nearest to it, to the way's end: places, the own first. `way`: at least one place. */
export function ahead(way, own) {
  let [rest, least_m] = [way.length - 1, Infinity];
  for (let i = 1; i < way.length; ++i) {
    const away_m = apart(nearestOn(way[i - 1], way[i], own), own);
    // Of equally near parts the later: the way has led here already.
    if (away_m <= least_m) [rest, least_m] = [i, away_m];
  }
  return [own, ...way.slice(rest)];
}

export const lengthOf = (places) => places.slice(1).reduce((sum, place, i) => sum + apart(places[i], place), 0);
