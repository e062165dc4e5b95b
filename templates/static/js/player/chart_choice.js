// Which charts are shown: those of the benchmark, and charts of any columns of the telemetry.
/**
 * @import { Chart, PlayerData } from "../server_data.d.ts"
 * @import { Charts } from "./charts.js"
 */
import { all, need } from "../dom.js";

const COLUMNS_MAX = 6; // of one chart: as many as there are colours

export class ChartChoice {
  /**
   * @param {ParentNode} root
   * @param {PlayerData} data
   * @param {Charts} charts
   */
  constructor(root, data, charts) {
    this.data = data;
    this.charts = charts;
    this.list = need(root, "[data-chart-choices]", HTMLElement);
    this.form = need(root, "[data-own-chart]", HTMLFormElement);
    this.listColumns();
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.add();
    });
    this.show();
  }

  listColumns() {
    const fields = need(this.form, "[data-columns]", HTMLElement);
    const units = [...new Set(this.data.columns.map(({ unit }) => unit))];
    fields.replaceChildren(
      ...units.map((unit) => {
        const group = document.createElement("fieldset");
        const legend = document.createElement("legend");
        legend.textContent = unit ? `[${unit}]` : "without unit";
        group.append(
          legend,
          ...this.data.columns
            .filter((column) => column.unit === unit)
            .map(({ name, meaning }) => {
              const { label } = this.checkbox(name, name);
              label.title = meaning;
              return label;
            }),
        );
        return group;
      }),
    );
  }

  /**
   * @param {string} text
   * @param {string} value
   */
  checkbox(text, value) {
    const label = document.createElement("label");
    const box = document.createElement("input");
    label.className = "check";
    Object.assign(box, { type: "checkbox", value });
    label.append(box, ` ${text}`);
    return { label, box };
  }

  add() {
    const boxes = all(this.form, "input:checked", HTMLInputElement);
    const columns = boxes.map(({ value }) => value);
    const note = need(this.form, "[data-own-note]", HTMLElement);
    note.textContent = columns.length ? "" : "Choose at least one column.";
    if (columns.length > COLUMNS_MAX) note.textContent = `A chart can show ${COLUMNS_MAX} columns.`;
    if (note.textContent) return;
    for (const box of boxes) box.checked = false;
    /** @type {(name: string) => string | undefined} */
    const unitOf = (name) => this.data.columns.find((column) => column.name === name)?.unit;
    const unit = [...new Set(columns.map(unitOf))].filter(Boolean).join(", ");
    this.charts.choose([...this.charts.chosen, { title: columns.join(", "), unit, columns, own: true }]);
    note.textContent = `The chart of ${columns.join(", ")} was added.`;
  }

  show() {
    /** @type {(a: Chart, b: Chart) => boolean} */
    const isSame = (a, b) => a.title === b.title && a.unit === b.unit && !a.own;
    this.list.replaceChildren(
      ...this.data.charts.map((chart) => {
        const { label, box } = this.checkbox(`${chart.title} [${chart.unit}]`, chart.title);
        box.checked = this.charts.chosen.some((chosen) => isSame(chosen, chart));
        box.addEventListener("change", () => {
          const rest = this.charts.chosen.filter((chosen) => !isSame(chosen, chart));
          this.charts.choose(box.checked ? [...rest, chart] : rest);
        });
        return label;
      }),
    );
  }
}
