// The data behind the charts as a table: the points around the playhead.
import { short } from "./formatting.js";

const ROWS = 15;

export class ChartTable {
  constructor(details, charts) {
    Object.assign(this, { details, charts });
    this.table = details.querySelector("table");
    details.addEventListener("toggle", () => this.show());
  }

  show() {
    if (!this.details.open) return;
    const { t, values, at } = this.charts.around();
    const columns = [...new Set(this.charts.chosen.flatMap((chart) => chart.columns))];
    const from = Math.max(Math.min(at - Math.floor(ROWS / 2), t.length - ROWS), 0);
    const head = this.table.tHead.rows[0];
    head.replaceChildren(...["t [s]", ...columns].map((name) => cell("th", name, "col")));
    this.table.tBodies[0].replaceChildren(
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

function cell(tag, text, scope) {
  const made = document.createElement(tag);
  made.className = "num";
  made.textContent = text;
  if (scope) made.scope = scope;
  return made;
}
