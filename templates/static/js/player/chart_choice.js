// Which charts are shown: those of the benchmark, and charts of any columns of the telemetry.

const COLUMNS_MAX = 6; // of one chart: as many as there are colours

export class ChartChoice {
  constructor(root, data, charts) {
    Object.assign(this, { data, charts });
    this.list = root.querySelector("[data-chart-choices]");
    this.form = root.querySelector("[data-own-chart]");
    this.listColumns();
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.add();
    });
    this.show();
  }

  listColumns() {
    const fields = this.form.querySelector("[data-columns]");
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
              const label = this.checkbox(name, name);
              label.title = meaning;
              return label;
            }),
        );
        return group;
      }),
    );
  }

  checkbox(text, value) {
    const label = document.createElement("label");
    const box = document.createElement("input");
    label.className = "check";
    Object.assign(box, { type: "checkbox", value });
    label.append(box, ` ${text}`);
    return label;
  }

  add() {
    const boxes = [...this.form.querySelectorAll("input:checked")];
    const columns = boxes.map(({ value }) => value);
    const note = this.form.querySelector("[data-own-note]");
    note.textContent = columns.length ? "" : "Choose at least one column.";
    if (columns.length > COLUMNS_MAX) note.textContent = `A chart can show ${COLUMNS_MAX} columns.`;
    if (note.textContent) return;
    for (const box of boxes) box.checked = false;
    const unitOf = (name) => this.data.columns.find((column) => column.name === name).unit;
    const unit = [...new Set(columns.map(unitOf))].filter(Boolean).join(", ");
    this.charts.choose([...this.charts.chosen, { title: columns.join(", "), unit, columns, own: true }]);
    note.textContent = `The chart of ${columns.join(", ")} was added.`;
  }

  show() {
    const isSame = (a, b) => a.title === b.title && a.unit === b.unit && !a.own;
    this.list.replaceChildren(
      ...this.data.charts.map((chart) => {
        const label = this.checkbox(`${chart.title} [${chart.unit}]`, chart.title);
        const box = label.firstElementChild;
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
