// One chart: lines over simulated time with uPlot, the levels, and the playhead as a line on top.
/**
 * @import { Chart, PlayerData } from "../server_data.d.ts"
 * @import { Charts } from "./charts.js"
 * @import { Samples } from "./samples.js"
 * @import uPlot from "uplot"
 */
import { marksPlugin } from "./chart_marks.js";
import { drawable, isDistance, yAxis, yScale } from "./chart_scales.js";
import { colour, LINES } from "./colours.js";
import { short } from "./formatting.js";
import { paced } from "./paced.js";
import { lastUntil } from "./samples.js";

const HEIGHT = 190;
const WIDTH_MIN = 200;
const { uPlot: Plot } = window;

export class ChartPlot {
  /**
   * @param {Chart} chart
   * @param {PlayerData} data
   * @param {Charts} owner
   */
  constructor(chart, data, owner) {
    this.chart = chart;
    this.data = data;
    this.owner = owner;
    /** @type {number[]} */
    this.t = [];
    /** @type {Samples["values"]} */
    this.values = {};
    /** @type {number | null} */
    this.marked = null;
    this.zoomed = false; // by a drag that has not ended
    this.logarithmic = owner.logarithmic && isDistance(chart);
    this.writeValues = paced(() => this.showValues());
    this.box = document.createElement("div");
    this.box.className = "chart";
    const title = document.createElement("p");
    title.className = "chart-title";
    const label = document.createElement("span");
    label.textContent = `${chart.title}${chart.unit ? ` [${chart.unit}]` : ""}`;
    this.readout = document.createElement("output");
    title.append(label, this.readout);
    if (chart.own) title.append(this.removeButton());
    const canvas = document.createElement("div");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${chart.title} over simulated time; the values are in the data table below`);
    this.box.append(title, canvas);
    owner.box.append(this.box);
    this.plot = this.createPlot(canvas);
    this.line = this.listen();
  }

  removeButton() {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "button small ghost";
    button.textContent = "Remove";
    button.setAttribute("aria-label", `Remove the chart of ${this.chart.title}`);
    button.addEventListener("click", () => this.owner.remove(this.chart));
    return button;
  }

  /**
   * @param {HTMLElement} target
   * @returns {uPlot}
   */
  createPlot(target) {
    const axis = {
      stroke: colour("--text-2"),
      grid: { stroke: colour("--chart-grid"), width: 1 },
      ticks: { show: false },
    };
    return new Plot(
      {
        width: this.width(),
        height: HEIGHT,
        cursor: { sync: { key: "run" }, drag: { x: true, y: false, setScale: false } },
        legend: { show: false },
        scales: { y: yScale(this.logarithmic), x: { time: false, range: () => this.owner.range() } },
        axes: [
          { ...axis, values: (_plot, ticks) => ticks.map((tick) => `${tick} s`), size: 32 },
          yAxis(axis, this.logarithmic),
        ],
        series: [
          {},
          ...this.chart.columns.map((name, index) => ({
            label: name,
            stroke: colour(LINES[index % LINES.length]),
            width: 1.5,
            points: { show: false },
          })),
        ],
        plugins: [marksPlugin(this.data, this.owner)],
        hooks: { setCursor: [() => this.showValues()], setSelect: [(plot) => this.zoom(plot)] },
      },
      [[], ...this.chart.columns.map(() => [])],
      target,
    );
  }

  // Returns the line of the playhead.
  listen() {
    const line = document.createElement("i");
    line.className = "chart-playhead";
    this.plot.over.append(line);
    this.plot.over.addEventListener("click", (event) => {
      const t = this.plot.posToVal(event.offsetX, "x");
      if (!this.zoomed && Number.isFinite(t)) this.owner.onSeek(t);
      this.zoomed = false;
    });
    this.plot.over.addEventListener("dblclick", () => this.owner.onZoom(null));
    return line;
  }

  /** @param {uPlot} plot */
  zoom(plot) {
    const { left, width } = plot.select;
    if (width < 4) return;
    this.zoomed = true; // the click that ends the drag does not seek
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.owner.onZoom([plot.posToVal(left, "x"), plot.posToVal(left + width, "x")]);
  }

  /**
   * @param {number[]} t
   * @param {Samples["values"]} values
   */
  show(t, values) {
    Object.assign(this, { t, values });
    const empty = () => new Array(t.length).fill(null);
    this.plot.setData([t, ...this.chart.columns.map((name) => drawable(values[name] ?? empty(), this.logarithmic))]);
    this.mark(this.marked);
  }

  /**
   * Moves the line of the playhead at once, the values soon after; the canvas is not drawn again.
   * @param {number | null} t
   */
  mark(t) {
    this.marked = t;
    if (t === null) return;
    const x = this.plot.valToPos(t, "x");
    this.line.hidden = !(x >= 0 && x <= this.plot.bbox.width / Plot.pxRatio);
    if (!this.line.hidden) this.line.style.transform = `translateX(${x}px)`;
    this.writeValues();
  }

  // The values under the cursor, else those at the playhead.
  showValues() {
    const { chart, values, t } = this;
    const at = this.plot.cursor.idx ?? (this.marked === null ? t.length - 1 : lastUntil(t, this.marked));
    if (at < 0 || !t.length) {
      this.readout.textContent = "";
      return;
    }
    const parts = chart.columns.map((name, index) => {
      const part = document.createElement("span");
      const text = short(values[name]?.[at]);
      part.textContent = chart.columns.length > 1 ? `${name} ${text} ` : `${text} ${chart.unit}`;
      if (chart.columns.length > 1) part.style.color = colour(LINES[index % LINES.length]);
      return part;
    });
    const stage = this.owner.stageAt(t[at]);
    this.readout.replaceChildren(`${t[at].toFixed(1)} s${stage && `, ${stage.toLowerCase()}`}: `, ...parts);
  }

  width() {
    return Math.max(this.owner.box.clientWidth, WIDTH_MIN);
  }

  resize() {
    this.plot.setSize({ width: this.width(), height: HEIGHT });
    this.mark(this.marked);
  }

  destroy() {
    this.plot.destroy();
    this.box.remove();
  }
}
