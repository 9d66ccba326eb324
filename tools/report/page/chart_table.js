import { element } from "./dom.js";
import { say } from "./language.js";
import { clockText } from "./time.js";

const MOST_ROWS = 200;

/** At most `most` of `list`, evenly, the last one among them. */
export function thinned(list, most = MOST_ROWS) {
  const every = Math.max(1, Math.ceil(list.length / most));
  return list.filter((_, i) => (list.length - 1 - i) % every === 0);
}

/**
 * The numbers behind a chart, in a table beneath it that is made when it is opened. `rows()` gives { head, rows }, each
 * row's first cell naming it; a number at the start of a row is a time in ms.
 */
export class ChartTable {
  constructor(name, rows) {
    this.name = name;
    this.rows = rows;
    this.body = element("div", { class: "behind-body", tabindex: "0", role: "group", "aria-label": say("{name}: table", { name }) });
    this.node = element("details", { class: "behind" }, element("summary", {}, say("Table: {name}", { name })), this.body);
    this.node.addEventListener("toggle", () => this.update());
  }

  update() {
    if (!this.node.open) return;
    const { head, rows } = this.rows();
    const few = thinned(rows);
    this.body.replaceChildren(
      few.length < rows.length ? element("p", { class: "hint" }, say("{n} of {total} rows, evenly chosen.", { n: few.length, total: rows.length })) : "",
      element("table", {},
        element("caption", { class: "unseen" }, this.name),
        element("thead", {}, element("tr", {}, ...head.map((text, i) => element("th", { scope: "col", class: i > 0 ? "n" : null }, text)))),
        element("tbody", {}, ...few.map(([first, ...rest]) => element("tr", {},
          element("th", { scope: "row" }, typeof first === "number" ? clockText(first) : first),
          ...rest.map((value) => element("td", { class: "n" }, value)))))));
  }
}
