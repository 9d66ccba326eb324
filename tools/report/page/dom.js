/** An element: element("td", { class: "n", onclick }, "text", child...). */
export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

export const byId = (id) => document.getElementById(id);

const BIDI = /[\u0590-\u08ff\u200f\u202a-\u202e\u2066-\u2069\ufb1d-\ufdff\ufe70-\ufefc]/;

/** A name within a line of text, such that its direction of writing does not turn the rest of the line. */
export const isolated = (name) => (BIDI.test(name) ? `\u2068${name}\u2069` : name);

const FORMATS = []; // by digits: making one takes longer than using it

export function number(value, digits = 0) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  FORMATS[digits] ??= new Intl.NumberFormat("en-GB", { minimumFractionDigits: digits, maximumFractionDigits: digits });
  return FORMATS[digits].format(value);
}

export const percent = (share, digits = 1) => `${number(100 * share, digits)} %`;

/** "1.9 ms", "2.3 s" */
export function duration(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  if (seconds === 0) return "0 ms";
  if (seconds < 0.0995) return `${number(seconds * 1000, 1)} ms`;
  return seconds < 1 ? `${number(seconds * 1000)} ms` : `${number(seconds, 2)} s`;
}

export function bytes(n) {
  return n >= 1e9 ? `${number(n / 1e9, 2)} GB` : n >= 1e6 ? `${number(n / 1e6, 1)} MB` : `${number(n / 1e3)} kB`;
}
