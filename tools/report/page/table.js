import { element } from "./dom.js";

/** A table; heads and cells of columns whose head begins with # are numbers. */
export function table(head, rows) {
  return element("table", {},
    element("thead", {}, element("tr", {}, ...head.map((h) => element("th", { scope: "col", class: h.startsWith("#") ? "n" : null }, h.replace("#", ""))))),
    element("tbody", {}, ...rows));
}

/** A row's cells. */
export const cells = (values, head) => values.map((value, i) =>
  element("td", { class: head[i].startsWith("#") ? "n" : null }, value instanceof Node ? value : String(value)));
