// Line charts over simulated time with uPlot: their selection, unit and level markers.

const COLOURS = ["--chart-1", "--chart-2", "--chart-3", "--good", "--bad"];
const HEIGHT = 190;
const INITIAL = 3; // number of charts shown initially
const POINTS_MAX = 6000; // of a live run; beyond this, older points are thinned out
const uPlot = window.uPlot;

// Custom properties may contain light-dark(...), which is only resolved in a computed colour.
export function colour(name) {
  const probe = document.createElement("i");
  probe.style.color = `var(${name})`;
  document.body.append(probe);
  const value = getComputedStyle(probe).color;
  probe.remove();
  return value;
}

function short(value) {
  if (value === null || value === undefined) return "–";
  const text = Math.abs(value) >= 100 ? value.toFixed(0) : value.toPrecision(3);
  return text.replace("-", "−");
}

function levelPlugin(data, owner) {
  return {
    hooks: {
      drawAxes: (plot) => {
        const { ctx, bbox } = plot;
        ctx.save();
        ctx.strokeStyle = colour("--chart-level");
        ctx.fillStyle = colour("--text-2");
        ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
        ctx.textAlign = "left";
        ctx.textBaseline = "alphabetic";
        // In a grid, several levels can share a value, so their names are shown instead.
        const names = data.names.length ? data.names : data.levels.map(String);
        const longest = names.reduce((a, b) => (b.length > a.length ? b : a), "");
        const width = plot.valToPos(data.level_s, "x", true) - plot.valToPos(0, "x", true);
        const sample = `0.4 ${data.level.unit} `;
        const fits = !data.names.length && ctx.measureText(sample).width < width;
        // If there are many levels, only every n-th is labelled so that the labels do not overlap.
        const every = Math.ceil(ctx.measureText(`${longest}  `).width / width);
        ctx.setLineDash([4 * devicePixelRatio, 4 * devicePixelRatio]);
        names.forEach((_name, index) => {
          const x = Math.round(plot.valToPos(index * data.level_s, "x", true));
          if (x < bbox.left || x > bbox.left + bbox.width) return;
          ctx.beginPath();
          ctx.moveTo(x, bbox.top);
          ctx.lineTo(x, bbox.top + bbox.height);
          if (index) ctx.stroke();
          if (index % every) return;
          const level = owner.levelAt(index);
          if (level === null) return;
          const value = names[level];
          ctx.fillText(fits ? `${value} ${data.level.unit}` : `${value}`, x + 5 * devicePixelRatio, bbox.top + 12 * devicePixelRatio);
        });
        ctx.restore();
      },
      draw: (plot) => {
        if (owner.marked === null) return;
        const { ctx, bbox } = plot;
        const x = plot.valToPos(owner.marked, "x", true);
        if (x < bbox.left || x > bbox.left + bbox.width) return;
        ctx.save();
        ctx.strokeStyle = colour("--focus");
        ctx.lineWidth = 1.5 * devicePixelRatio;
        ctx.beginPath();
        ctx.moveTo(x, bbox.top);
        ctx.lineTo(x, bbox.top + bbox.height);
        ctx.stroke();
        ctx.restore();
      },
    },
  };
}

export class Charts {
  constructor(data) {
    this.data = data;
    this.box = document.querySelector("[data-charts]");
    this.marked = null;
    this.t = [];
    this.values = {};
    this.shown = [];
    this.scheduled = false;
    this.onChoice = () => {};
    this.onSeek = () => {};
    const first = data.charts.filter((chart) => chart.unit === "px").slice(0, INITIAL);
    this.chosen = new Set(first.length ? first : data.charts.slice(0, INITIAL));
    this.listChoices();
    this.build();
    for (const input of document.querySelectorAll('input[name="unit"]')) {
      input.addEventListener("change", () => this.chooseUnit(input.value));
    }
    document.addEventListener("themechange", () => this.build());
    new ResizeObserver(() => this.resize()).observe(this.box);
  }

  columns() {
    return [...new Set(["level", ...[...this.chosen].flatMap((chart) => chart.columns)])];
  }

  // The level that ran at a position of the trial; null if that is not known yet. Benchmarks may
  // draw the order of the levels, so it is read from the telemetry.
  levelAt(position) {
    const { level_s: length, ordered, levels } = this.data;
    if (ordered) return Math.min(position, levels.length - 1);
    // The middle of a level, since points between two levels may be averages of both.
    const from = this.t.findIndex((t) => t >= (position + 0.1) * length);
    if (from < 0 || this.t[from] >= (position + 1) * length) return null;
    return this.values.level?.[from] ?? null;
  }

  chooseUnit(unit) {
    this.chosen = new Set(this.data.charts.filter((chart) => chart.unit === unit).slice(0, INITIAL));
    this.listChoices();
    this.changed();
  }

  changed() {
    this.build();
    this.onChoice();
  }

  listChoices() {
    const list = document.querySelector("[data-chart-choices]");
    list.replaceChildren(...this.data.charts.map((chart) => {
      const label = document.createElement("label");
      const box = document.createElement("input");
      label.className = "check";
      box.type = "checkbox";
      box.checked = this.chosen.has(chart);
      box.addEventListener("change", () => {
        if (box.checked) this.chosen.add(chart);
        else this.chosen.delete(chart);
        this.changed();
      });
      label.append(box, ` ${chart.title} [${chart.unit}]`);
      return label;
    }));
  }

  build() {
    for (const { plot } of this.shown) plot.destroy();
    const ordered = this.data.charts.filter((chart) => this.chosen.has(chart));
    this.box.replaceChildren();
    this.shown = ordered.map((chart) => this.createPlot(chart));
    this.draw();
  }

  createPlot(chart) {
    const container = document.createElement("div");
    const title = document.createElement("p");
    const readout = document.createElement("output");
    const target = document.createElement("div");
    container.className = "chart";
    title.className = "chart-title";
    title.append(`${chart.title} [${chart.unit}]`, readout);
    container.append(title, target);
    this.box.append(container);
    target.setAttribute("role", "img");
    target.setAttribute("aria-label", `${chart.title} in ${chart.unit} over simulated time`);
    const axis = { stroke: colour("--text-2"), grid: { stroke: colour("--chart-grid"), width: 1 }, ticks: { show: false } };
    const plot = new uPlot({
      width: this.width(),
      height: HEIGHT,
      cursor: { sync: { key: "run" }, drag: { x: true, y: false } },
      legend: { show: false },
      scales: { y: { range: (_plot, min, max) => this.yRange(min, max) }, x: { time: false, range: (_plot, min, max) => this.xRange(min, max) } },
      axes: [{ ...axis, values: (_plot, ticks) => ticks.map((tick) => `${tick} s`), size: 32 }, { ...axis, size: 56 }],
      series: [{}, ...chart.columns.map((name, index) => ({
        label: name, stroke: colour(COLOURS[index % COLOURS.length]), width: 1.5, points: { show: false },
      }))],
      plugins: [levelPlugin(this.data, this)],
      hooks: { setCursor: [(self) => this.showValues(self, chart, readout)] },
    }, [[], ...chart.columns.map(() => [])], target);
    plot.over.addEventListener("click", () => {
      if (plot.cursor.idx !== null && this.t.length) this.onSeek(this.t[plot.cursor.idx]);
    });
    return { chart, plot, readout };
  }

  // Shows the whole trial, including the part still to come, unless the user has zoomed in.
  xRange(min, max) {
    if (min === null || max === null || !this.t.length) return [0, this.data.trial_s];
    const whole = min <= this.t[0] && max >= this.t[this.t.length - 1];
    return whole ? [0, Math.max(this.data.trial_s, max)] : [min, max];
  }

  // Leaves room above the lines for the labels of the levels.
  yRange(min, max) {
    if (min === null || max === null) return [0, 1];
    const span = Math.max(max - min, 1e-6);
    const base = min >= 0 && min < 0.5 * max ? 0 : min - 0.08 * span;
    return [base, max + 0.28 * span];
  }

  showValues(plot, chart, output) {
    const at = plot.cursor.idx ?? this.t.length - 1;
    if (at < 0 || !this.t.length) {
      output.textContent = "";
      return;
    }
    const parts = chart.columns.map((name, index) => {
      const part = document.createElement("span");
      const text = short(this.values[name]?.[at]);
      part.textContent = chart.columns.length > 1 ? `${name} ${text} ` : `${text} ${chart.unit}`;
      if (chart.columns.length > 1) part.style.color = colour(COLOURS[index % COLOURS.length]);
      return part;
    });
    output.replaceChildren(`${this.t[at].toFixed(1)} s: `, ...parts);
  }

  clear() {
    this.replace([], {});
  }

  replace(t, values) {
    this.t = t;
    this.values = values;
    this.draw();
  }

  // Appends rows of the event stream; returns the latest time, or null if there are no rows.
  append(columns, rows) {
    const at = columns.indexOf("t");
    for (const row of rows) {
      if (this.t.length && row[at] <= this.t[this.t.length - 1]) continue; // replayed
      this.t.push(row[at]);
      columns.forEach((name, index) => (this.values[name] ??= this.blank()).push(row[index]));
      for (const name in this.values) {
        if (this.values[name].length < this.t.length) this.values[name].push(null);
      }
    }
    if (this.t.length > POINTS_MAX) this.thin();
    if (!this.scheduled) {
      this.scheduled = true;
      requestAnimationFrame(() => {
        this.scheduled = false;
        this.draw();
      });
    }
    return this.t.length ? this.t[this.t.length - 1] : null;
  }

  blank() {
    return new Array(this.t.length - 1).fill(null);
  }

  thin() {
    const kept = (_value, index) => index % 2 === 0 || index > this.t.length - 200;
    for (const name in this.values) this.values[name] = this.values[name].filter(kept);
    this.t = this.t.filter(kept);
  }

  draw() {
    for (const { chart, plot, readout } of this.shown) {
      const empty = () => new Array(this.t.length).fill(null);
      plot.setData([this.t, ...chart.columns.map((name) => this.values[name] ?? empty())]);
      this.showValues(plot, chart, readout);
    }
  }

  mark(t) {
    this.marked = t;
    for (const { plot } of this.shown) plot.redraw(false, false);
  }

  width() {
    return Math.max(this.box.clientWidth, 200);
  }

  resize() {
    for (const { plot } of this.shown) plot.setSize({ width: this.width(), height: HEIGHT });
  }
}
