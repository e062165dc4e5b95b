// The charts of a run: which ones, in which unit, over which range, and their data at a level of detail
// that fits the screen. The x axis of all charts is the same.
/**
 * @import { Chart, Moments, PlayerData, SeriesAnswer } from "../server_data.d.ts"
 * @import { Memory } from "./memory.js"
 * @import { Samples } from "./samples.js"
 */
import { all, maybe, need } from "../dom.js";
import { ChartChoice } from "./chart_choice.js";
import { ChartPlot } from "./chart_plot.js";
import { isDistance } from "./chart_scales.js";
import { NONE } from "./marks.js";
import { appendRows, lastUntil, levelAt, noSamples, thinned } from "./samples.js";
import { bandAt, bandsOf } from "./stages.js";

const INITIAL = 3; // number of charts shown initially
const POINTS = 1600; // of a request: a few per pixel
const LIVE_POINTS_MAX = 3200; // beyond this, older points of a live run are thinned out
const DRAW_MS = 150; // between two drawings of live data
const ZOOM_MIN_S = 0.5;

export class Charts {
  /**
   * @param {ParentNode} root
   * @param {PlayerData} data
   * @param {Memory} memory
   */
  constructor(root, data, memory) {
    this.data = data;
    this.memory = memory;
    /** @type {number | null} time of the playhead [s] */
    this.marked = null;
    this.sequence = 0; // of the newest request
    this.moments = NONE;
    this.trial = 0;
    /** @type {[number, number] | null} [s] */
    this.zoomed = null;
    /** @type {ChartPlot[]} */
    this.plots = [];
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.timer = undefined;
    /** @type {(t: number) => void} */
    this.onSeek = () => {};
    /** @type {(t: number, trial: number) => void} */
    this.onLoad = () => {};
    this.box = need(root, "[data-charts]", HTMLElement);
    this.whole = noSamples();
    /** @type {Samples | null} the same over the zoomed range */
    this.detail = null;
    this.units = all(root, 'input[name="unit"]', HTMLInputElement);
    this.rangeSelect = maybe(root, "[data-range]", HTMLSelectElement);
    /** @type {(chart: Chart) => boolean} */
    const known = (chart) =>
      chart.columns?.length > 0 && chart.columns.every((name) => data.columns.some((column) => column.name === name));
    this.chosen = memory.get("charts", /** @type {Chart[]} */ ([])).filter(known);
    // Work on something is read in distances and in forces; all else in one unit at first.
    if (!this.chosen.length) this.chosen = this.presets(data.stages.length ? undefined : data.charts[0]?.unit);
    this.choice = new ChartChoice(root, data, this);
    const units = new Set(data.charts.map(({ unit }) => unit));
    const choice = maybe(root, "[data-units]", HTMLElement);
    if (choice) choice.hidden = !this.units.every(({ value }) => units.has(value));
    for (const input of this.units) {
      input.checked =
        this.chosen.some(({ unit }) => unit === input.value) || (input.checked && this.units[0] === input);
      input.addEventListener("change", () => this.choose(this.presets(input.value)));
    }
    this.rangeSelect?.addEventListener("change", () => this.zoomAround(Number(this.rangeSelect?.value)));
    /** @type {boolean} */
    this.logarithmic = false;
    this.offerLogarithmic(need(root, "[data-log-axis]", HTMLInputElement));
    this.build();
    document.addEventListener("themechange", () => this.build());
    new ResizeObserver(() => this.resize()).observe(this.box);
  }

  /** @param {HTMLInputElement} box */
  offerLogarithmic(box) {
    box.checked = this.logarithmic = this.memory.get("logarithmic", false);
    const label = box.closest("label");
    if (label) label.hidden = !this.data.charts.some(isDistance);
    box.addEventListener("change", () => {
      this.logarithmic = box.checked;
      this.memory.set("logarithmic", box.checked);
      this.build();
    });
  }

  /**
   * Those of a unit; else the first ones.
   * @param {string} [unit]
   */
  presets(unit) {
    const matching = this.data.charts.filter((chart) => chart.unit === unit);
    return (matching.length ? matching : this.data.charts).slice(0, INITIAL);
  }

  /** @param {Chart[]} charts */
  choose(charts) {
    this.chosen = charts;
    this.memory.set("charts", charts);
    this.choice.show();
    this.build();
    this.load();
  }

  /** @param {Chart} chart */
  remove(chart) {
    this.choose(this.chosen.filter((one) => one !== chart));
  }

  resize() {
    for (const plot of this.plots) plot.resize();
  }

  build() {
    for (const plot of this.plots) plot.destroy();
    this.plots = this.chosen.map((chart) => new ChartPlot(chart, this.data, this));
    this.draw();
    this.mark(this.marked);
  }

  columns() {
    return [...new Set(["level", ...this.chosen.flatMap(({ columns }) => columns)])];
  }

  /**
   * The whole trial, including the part still to come, unless somebody has zoomed in.
   * @returns {[number, number]}
   */
  range() {
    if (this.zoomed) return this.zoomed;
    const { t } = this.whole;
    return [0, Math.max(this.data.trial_s, t.length ? t[t.length - 1] : 0)];
  }

  /**
   * The level that ran at a position of the trial; null if that is not known yet.
   * @param {number} position
   * @returns {number | null}
   */
  levelAt(position) {
    const { level_s: length, ordered, levels } = this.data;
    return ordered ? Math.min(position, levels.length - 1) : levelAt(this.whole, position, length);
  }

  async load() {
    const sequence = ++this.sequence;
    const whole = await this.fetchSeries("");
    if (!whole || sequence !== this.sequence) return;
    this.whole = whole;
    this.draw();
    this.onLoad(whole.t.length ? whole.t[whole.t.length - 1] : 0, this.trial);
    if (this.zoomed) await this.loadDetail();
  }

  async loadDetail() {
    const zoomed = this.zoomed;
    if (!zoomed) return;
    const detail = await this.fetchSeries(`&start=${Math.max(zoomed[0], 0)}&stop=${Math.max(zoomed[1], 0)}`);
    if (!detail || zoomed !== this.zoomed) return;
    this.detail = detail;
    this.draw();
  }

  /**
   * @param {string} range
   * @returns {Promise<Samples | null>}
   */
  async fetchSeries(range) {
    const names = this.columns().join(",");
    const response = await fetch(
      `${this.data.api}/series.json?columns=${names}&max_points=${POINTS}&trial=${this.trial}${range}`,
    );
    if (!response.ok) return null;
    /** @type {SeriesAnswer} */
    const { t, columns } = await response.json();
    return { t, values: columns };
  }

  /** @param {number} trial */
  setTrial(trial) {
    if (trial === this.trial) return;
    this.trial = trial;
    this.clear();
  }

  clear() {
    this.whole = noSamples();
    this.detail = null;
    this.draw();
  }

  /** @param {[number, number] | null} range */
  onZoom(range) {
    const [from, to] = range ?? [0, 0];
    this.zoomed = range && to - from > ZOOM_MIN_S ? [Math.max(from, 0), to] : null;
    if (this.rangeSelect) this.rangeSelect.value = this.zoomed ? "custom" : "0";
    this.detail = null;
    this.draw();
    if (this.zoomed) this.loadDetail();
  }

  /** @param {number} length */
  zoomAround(length) {
    const middle = this.marked ?? 0;
    const from = Math.max(middle - length / 2, 0);
    this.onZoom(length > 0 ? [from, from + length] : null);
    if (this.rangeSelect) this.rangeSelect.value = String(length);
  }

  /**
   * Appends rows of the event stream.
   * @param {string[]} columns
   * @param {(number | null)[][]} rows
   */
  append(columns, rows) {
    appendRows(this.whole, this.columns(), columns, rows);
    if (this.whole.t.length > LIVE_POINTS_MAX) this.whole = thinned(this.whole);
    this.timer ??= setTimeout(() => {
      this.timer = undefined;
      this.draw();
    }, DRAW_MS);
  }

  draw() {
    const { t, values } = this.zoomed && this.detail ? this.detail : this.whole;
    for (const plot of this.plots) plot.show(t, values);
  }

  /**
   * moments: of the trial
   * @param {Moments} moments
   */
  setMoments(moments) {
    this.moments = moments;
    this.draw();
  }

  // What is marked in each chart.
  marks() {
    const { t } = this.whole;
    const end = (t[t.length - 1] ?? 0) + this.data.step_s; // of the last row
    return { ...this.moments, bands: bandsOf(this.moments, end, this.data.level_s) };
  }

  /**
   * The stage that was reached at a time, in words; empty if none was.
   * @param {number} t
   */
  stageAt(t) {
    const band = bandAt(this.marks().bands, t);
    return band ? this.data.stages[band.stage] : "";
  }

  /** @param {number | null} t */
  mark(t) {
    this.marked = t;
    if (
      this.zoomed &&
      t !== null &&
      this.rangeSelect?.value !== "custom" &&
      (t < this.zoomed[0] || t > this.zoomed[1])
    ) {
      this.zoomAround(this.zoomed[1] - this.zoomed[0]); // the range goes along with the playhead
    }
    for (const plot of this.plots) plot.mark(t);
  }

  // The largest index shown up to the playhead, for the data table: {t, values, at}.
  around() {
    const { t, values } = this.zoomed && this.detail ? this.detail : this.whole;
    return { t, values, at: lastUntil(t, this.marked ?? 0) };
  }
}
