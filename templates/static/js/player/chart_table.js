// The data behind the charts as a table: the points around the playhead.
/** @import { Charts } from "./charts.js" */
import { need } from "../dom.js";
import { short } from "./formatting.js";

const ROWS = 15;

export class ChartTable {
  /**
   * @param {HTMLDetailsElement} details
   * @param {Charts} charts
   */
  constructor(details, charts) {
    this.details = details;
    this.charts = charts;
    this.table = need(details, "table", HTMLTableElement);
    details.addEventListener("toggle", () => this.show());
  }

  show() {
    if (!this.details.open) return;
    const { t, values, at } = this.charts.around();
    const columns = [...new Set(this.charts.chosen.flatMap((chart) => chart.columns))];
    const from = Math.max(Math.min(at - Math.floor(ROWS / 2), t.length - ROWS), 0);
    const head = need(this.table, "thead tr", HTMLTableRowElement);
    head.replaceChildren(...["t [s]", ...columns].map((name) => cell("th", name, "col")));
    need(this.table, "tbody", HTMLTableSectionElement).replaceChildren(
      ...t.slice(from, from + ROWS).map((time, index) => {
        const row = document.createElement("tr");
        if (from + index === at) row.className = "mine";
        row.append(
          cell("th", time.toFixed(2), "row"),
          ...columns.map((name) => cell("td", short(values[name]?.[from + index]))),
        );
        return row;
      }),
    );
  }
}

/**
 * @param {"td" | "th"} tag
 * @param {string} text
 * @param {string} [scope]
 */
function cell(tag, text, scope) {
  const made = document.createElement(tag);
  made.className = "num";
  made.textContent = text;
  if (scope) made.setAttribute("scope", scope);
  return made;
}
