/** Colours of the style sheet, for the canvases. Okabe and Ito's palette: told apart by all eyes. */
const NAMES = ["bg", "page", "panel", "line", "grid", "text", "muted", "accent", "uav", "worker", "vehicle", "idle",
  "moving", "waiting", "sensing", "charging", "failed", "task", "done", "band", "cursor", "water", "shore", "road", "green", "built", "building", "street", "coverage"];

export const theme = {};

export function readTheme() {
  const style = getComputedStyle(document.documentElement);
  for (const name of NAMES) theme[name] = style.getPropertyValue(`--${name}`).trim();
  for (const [key, name] of [["openHeat", "open-heat"], ["responseHeat", "response-heat"]]) theme[key] = style.getPropertyValue(`--${name}`).trim();
  theme.kinds = [theme.uav, theme.worker, theme.vehicle];
  theme.status = ["transparent", theme.idle, theme.moving, theme.waiting, theme.sensing, theme.charging, theme.failed, theme.idle];
  theme.runs = ["--run0", "--run1", "--run2", "--run3", "--run4", "--run5"].map((name) =>
    style.getPropertyValue(name).trim());
}

export const RUN_DASHES = [[], [7, 3], [2, 3], [10, 3, 2, 3], [5, 5], [1, 4]];

/** Reads the colours, and again when they change: dark or light, and on paper, which is always light. */
export function watchTheme(changed) {
  readTheme();
  for (const query of [matchMedia("(prefers-color-scheme: dark)"), matchMedia("print")]) {
    query.addEventListener("change", () => {
      readTheme();
      changed();
    });
  }
}
