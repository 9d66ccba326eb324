/** Numbers of `domain` to places of `range`, both [from, to]; scale.invert goes back. */
export function linear([d0, d1], [r0, r1]) {
  const scale = (value) => r0 + ((value - d0) / (d1 - d0)) * (r1 - r0);
  scale.invert = (place) => d0 + ((place - r0) / (r1 - r0)) * (d1 - d0);
  return scale;
}

const tidy = (value) => Number(value.toPrecision(12));

/** The smallest of `parts` times a power of ten that is not below `least`. */
function roundStep(least, parts) {
  const power = 10 ** Math.floor(Math.log10(least));
  return tidy(([...parts, 10].find((part) => part * power >= least) ?? 10) * power);
}

/** Round numbers from `from` to `to`, at most `most` steps between them. */
export function roundTicks([from, to], most, parts = [1, 2, 2.5, 5]) {
  if (!(to > from) || !(most > 0)) return [];
  const step = roundStep((to - from) / most, parts);
  const ticks = [];
  for (let i = Math.ceil(from / step - 1e-9); i * step <= to + step * 1e-9; ++i) ticks.push(tidy(i * step));
  return ticks;
}

/** The part of the area that is in view and not covered at the left and above: pixels. */
export function frameOf({ x, y, width, height, left = 0, top = 0 }, { width_m: w, height_m: h }) {
  return { left: Math.max(left, x(0)), top: Math.max(top, y(h)), right: Math.min(width, x(w)), bottom: Math.min(height, y(0)) };
}
