// Charts with one line per run over simulated time, for the columns that are chosen.
/**
 * @import { CompareData, ComparedChart, ComparedSeries } from "../server_data.d.ts"
 * @import { Playhead } from "../player/playhead.js"
 * @import uPlot from "uplot"
 */
import { need } from "../dom.js";
import { linearRange } from "../player/chart_scales.js";
import { colour } from "../player/colours.js";
import { short } from "../player/formatting.js";
import { valueAt } from "../player/samples.js";
import { COLOURS, DASHES } from "./lines.js";

const HEIGHT = 180;
const INITIAL = 3; // number of charts shown initially
const ROOM = 0.2; // above the lines, for the names of the levels
const { uPlot: Plot } = window;

// The colour of a run, and a dash so that lines differ without colours too.

/** @typedef {{chart: ComparedChart, plot: uPlot, readout: HTMLElement, line: HTMLElement}} ShownChart */

export class OverlaidCharts {
  /**
   * @param {CompareData} data
   * @param {Playhead} playhead
   * @param {string[]} chosen
   */
  constructor(data, playhead, chosen) {
    this.data = data;
    this.playhead = playhead;
    this.box = need(document, "[data-charts]", HTMLElement);
    /** @type {ComparedSeries[]} */
    this.series = [];
    /** @type {ShownChart[]} */
    this.shown = [];
    /** @type {number | null} */
    this.level = null;
    this.onChoice = () => {};
    const known = data.charts.filter(({ column }) => chosen.includes(column));
    const first = data.charts.filter(({ unit }) => unit === data.charts[0]?.unit).slice(0, INITIAL);
    this.chosen = new Set(known.length ? known : first.length ? first : data.charts.slice(0, INITIAL));
    this.listChoices();
    this.build();
    playhead.listen(() => this.mark());
    document.addEventListener("themechange", () => this.build());
    new ResizeObserver(() => this.resize()).observe(this.box);
  }

  columns() {
    return this.data.charts.filter((chart) => this.chosen.has(chart)).map(({ column }) => column);
  }

  listChoices() {
    const list = need(document, "[data-chart-choices]", HTMLElement);
    list.replaceChildren(
      ...this.data.charts.map((chart) => {
        const label = document.createElement("label");
        const box = document.createElement("input");
        label.className = "check";
        box.type = "checkbox";
        box.checked = this.chosen.has(chart);
        box.addEventListener("change", () => this.choose(chart, box));
        label.append(box, ` ${chart.title} [${chart.unit}]`);
        return label;
      }),
    );
  }

  /**
   * @param {ComparedChart} chart
   * @param {HTMLInputElement} box
   */
  choose(chart, box) {
    if (box.checked && this.chosen.size >= this.data.columns_max) box.checked = false;
    else if (box.checked) this.chosen.add(chart);
    else this.chosen.delete(chart);
    this.build();
    this.onChoice();
  }

  /**
   * `series`: of each run its own times and columns; `level`: shown alone, null for whole trials.
   * @param {ComparedSeries[]} series
   * @param {number | null} level
   */
  show(series, level) {
    this.series = series;
    this.level = level;
    this.draw();
  }

  build() {
    for (const { plot } of this.shown) plot.destroy();
    this.box.replaceChildren();
    this.shown = this.data.charts.filter((chart) => this.chosen.has(chart)).map((chart) => this.createPlot(chart));
    this.draw();
  }

  /**
   * @param {ComparedChart} chart
   * @returns {ShownChart}
   */
  createPlot(chart) {
    const container = document.createElement("div");
    const title = document.createElement("p");
    const readout = document.createElement("span");
    const target = document.createElement("div");
    container.className = "chart";
    title.className = "chart-title";
    readout.className = "readout";
    title.append(`${chart.title} [${chart.unit}]`, readout);
    container.append(title, target);
    this.box.append(container);
    target.setAttribute("role", "img");
    const runs = this.data.runs.map(({ id }) => id).join(", ");
    target.setAttribute("aria-label", `${chart.title} in ${chart.unit} over simulated time, runs ${runs}`);
    const axis = {
      stroke: colour("--text-2"),
      grid: { stroke: colour("--chart-grid"), width: 1 },
      ticks: { show: false },
    };
    const plot = new Plot(
      {
        width: this.width(),
        height: HEIGHT,
        cursor: { sync: { key: "compare" }, drag: { x: true, y: false } },
        legend: { show: false },
        scales: {
          x: { time: false, range: (_plot, min, max) => [min ?? 0, max ?? this.data.trial_s] },
          y: { range: (_plot, min, max) => linearRange(min, max, ROOM) },
        },
        axes: [
          { ...axis, values: (_plot, ticks) => ticks.map((tick) => `${tick} s`), size: 32 },
          { ...axis, size: 56 },
        ],
        series: [
          {},
          ...this.data.runs.map(({ id }, index) => ({
            label: `#${id}`,
            stroke: colour(COLOURS[index]),
            dash: DASHES[index],
            width: 1.5,
            points: { show: false },
          })),
        ],
        plugins: [this.levelsPlugin()],
        hooks: { setCursor: [(self) => this.showValues(self, chart, readout)] },
      },
      [[], ...this.data.runs.map(() => [])],
      target,
    );
    const line = document.createElement("i");
    line.className = "chart-playhead";
    line.hidden = true;
    plot.over.append(line);
    plot.over.addEventListener("click", () => {
      const { left } = plot.cursor;
      if (left !== undefined && left >= 0) this.playhead.seek(plot.posToVal(left, "x"));
    });
    return { chart, plot, readout, line };
  }

  /**
   * Borders and names of the levels behind the lines.
   * @returns {uPlot.Plugin}
   */
  levelsPlugin() {
    return {
      hooks: {
        drawAxes: (plot) => {
          if (this.level !== null || !this.data.level_s) return;
          const { ctx, bbox } = plot;
          ctx.save();
          ctx.strokeStyle = colour("--chart-level");
          ctx.setLineDash([4 * devicePixelRatio, 4 * devicePixelRatio]);
          this.data.levels.forEach((name, index) => {
            const x = Math.round(plot.valToPos(index * this.data.level_s, "x", true));
            if (x < bbox.left || x > bbox.left + bbox.width) return;
            ctx.beginPath();
            ctx.moveTo(x, bbox.top);
            ctx.lineTo(x, bbox.top + bbox.height);
            if (index) ctx.stroke();
            this.drawName(plot, name, x);
          });
          ctx.restore();
        },
      },
    };
  }

  /**
   * The name of a level, if it fits between its borders.
   * @param {uPlot} plot
   * @param {string} name
   * @param {number} x
   */
  drawName(plot, name, x) {
    const { ctx, bbox } = plot;
    const width = plot.valToPos(this.data.level_s, "x", true) - plot.valToPos(0, "x", true);
    ctx.save();
    ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
    ctx.fillStyle = colour("--text-2");
    ctx.textAlign = "left";
    ctx.textBaseline = "alphabetic";
    const fits = ctx.measureText(`${name}  `).width < width;
    if (fits) ctx.fillText(name, x + 5 * devicePixelRatio, bbox.top + 12 * devicePixelRatio);
    ctx.restore();
  }

  /**
   * Values of all runs at the cursor, otherwise at the playhead.
   * @param {uPlot} plot
   * @param {ComparedChart} chart
   * @param {HTMLElement} readout
   */
  showValues(plot, chart, readout) {
    const { idx } = plot.cursor;
    const hovered = idx !== null && idx !== undefined ? plot.data[0][idx] : undefined;
    const t = hovered ?? this.playhead.t;
    const parts = this.series.map((series, index) => {
      const part = document.createElement("span");
      part.textContent = `#${series.run} ${short(valueAt({ t: series.t, values: series.columns }, chart.column, t))}`;
      part.style.color = colour(COLOURS[index]);
      return part;
    });
    readout.replaceChildren(...(parts.length ? [`${t.toFixed(1)} s`, ...parts] : []));
  }

  draw() {
    for (const { chart, plot } of this.shown) {
      // Runs have their own times: `join` lets lines span the times of others, not their own gaps.
      /** @type {uPlot.AlignedData[]} */
      const tables = this.series.map(({ t, columns }) => [t, columns[chart.column] ?? new Array(t.length).fill(null)]);
      plot.setData(tables.length ? Plot.join(tables) : [[], ...this.data.runs.map(() => [])]);
    }
    this.mark();
  }

  // Moves the line of the playhead; the canvas is not drawn again.
  mark() {
    for (const { chart, plot, readout, line } of this.shown) {
      const x = plot.valToPos(this.playhead.t, "x");
      line.hidden = !(this.series.length && x >= 0 && x <= plot.over.clientWidth);
      if (!line.hidden) line.style.transform = `translateX(${x}px)`;
      this.showValues(plot, chart, readout);
    }
  }

  width() {
    return Math.max(this.box.clientWidth, 200);
  }

  resize() {
    for (const { plot } of this.shown) plot.setSize({ width: this.width(), height: HEIGHT });
    this.mark();
  }
}
