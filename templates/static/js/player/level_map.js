// The map of a level beside the charts, north up, which plays with the time line. What it draws, and what it says
// below, is of the kind of the run.
/**
 * @import { Moments, Row, SceneData, SeriesAnswer } from "../server_data.d.ts"
 */
import { maybe, need } from "../dom.js";
import { NONE } from "./marks.js";
import { paced } from "./paced.js";
import { levelAround } from "./places.js";
import { ROUTE } from "./route_map.js";
import { SAME_S } from "./rows.js";
import { SEARCH } from "./search_map.js";

const POINTS = 2400; // of a trial
const LIVE_S = 0.25; // from one row of a live run that is kept to the next
const LOAD_AGAIN_MS = 2000; // what could not be loaded
const HEIGHT_MAX = 460; // [px]

/**
 * What a map of a kind shows: columns that it takes, what it needs of a scene, null if that has none, what stays for a
 * level, and what a moment adds, which returns names and values for below the map.
 * @template S
 * @template G
 * @typedef {object} MapKind
 * @property {string[]} columns
 * @property {(scene: SceneData) => S | null} of
 * @property {(svg: SVGSVGElement, rows: Row[], scene: S, size: {width: number, height: number}) => G} ground
 * @property {(svg: SVGSVGElement, ground: G, scene: S, moment: MapMoment) => [string, string][]} moment
 */

/**
 * count: of the rows of the level up to the moment; now: the row at it
 * @typedef {{rows: Row[], count: number, now: Row, moments: Moments}} MapMoment
 */

/** @typedef {{api: string, scene: (trial: number, level: number) => Promise<SceneData | null>}} MappedRun */

/**
 * The map with a name, if the page has one.
 * @param {ParentNode} page
 * @param {string} name
 * @param {MappedRun} run
 */
export function mapIn(page, name, run) {
  const box = maybe(page, `[data-level-map="${name}"]`, HTMLElement);
  if (!box) return null;
  return box.dataset.kind === "route" ? new LevelMap(box, run, ROUTE) : new LevelMap(box, run, SEARCH);
}

/**
 * @template S
 * @template G
 */
export class LevelMap {
  /**
   * scene: of a level, null if it has none
   * @param {HTMLElement} box
   * @param {MappedRun} run
   * @param {MapKind<S, G>} kind
   */
  constructor(box, { api, scene }, kind) {
    this.api = api;
    this.sceneOf = scene;
    this.kind = kind;
    this.svg = need(box, "svg", SVGSVGElement);
    this.note = need(box, "[data-map-note]", HTMLElement);
    this.figures = need(box, "[data-map-figures]", HTMLElement);
    /** @type {Row[]} of the trial, in order */
    this.rows = [];
    /** @type {number | null} */
    this.trial = null;
    this.asked = -Infinity; // when rows were asked for [ms]
    this.moments = NONE;
    /** @type {S | null} */
    this.scene = null;
    this.sceneKey = "";
    /** @type {{trial: number, t: number, row: Row | null} | null} */
    this.shown = null;
    /** @type {{key: string, drawn: G} | null} */
    this.ground = null;
    this.draw = paced(() => this.drawNow());
    new ResizeObserver(() => this.draw()).observe(box);
  }

  /**
   * row: of the telemetry at the moment, null if it is not known
   * @param {{trial: number, t: number, newest?: number}} moment
   * @param {Row | null} [row]
   */
  show({ trial, t, newest = Infinity }, row = null) {
    this.shown = { trial, t, row };
    const again = !this.rows.length && performance.now() - this.asked > LOAD_AGAIN_MS;
    if (newest > 0 && (trial !== this.trial || again)) this.load(trial);
    this.draw();
  }

  /** @param {number} trial */
  async load(trial) {
    if (trial !== this.trial) this.rows = [];
    this.trial = trial;
    this.asked = performance.now();
    const query = `columns=${this.kind.columns.join(",")}&trial=${trial}&sample=rows&max_points=${POINTS}`;
    const response = await fetch(`${this.api}/series.json?${query}`);
    if (!response.ok || trial !== this.trial) return;
    const loaded = rowsOf(await response.json());
    const last = loaded[loaded.length - 1]?.t ?? -Infinity;
    this.rows = [...loaded, ...this.rows.filter((row) => row.t > last)];
    this.draw();
  }

  /**
   * Rows of a live run have arrived, which name their columns.
   * @param {number} trial
   * @param {string[]} columns
   * @param {number[][]} rows
   */
  append(trial, columns, rows) {
    if (trial !== this.trial) return;
    const at = columns.indexOf("t");
    for (const values of rows) {
      if (values[at] < (this.rows[this.rows.length - 1]?.t ?? -Infinity) + LIVE_S) continue;
      this.rows.push({ t: values[at], ...Object.fromEntries(columns.map((name, index) => [name, values[index]])) });
    }
    this.draw();
  }

  /**
   * Shows a sentence instead of a map.
   * @param {string} sentence
   */
  hide(sentence) {
    this.shown = null;
    this.note.textContent = sentence;
    this.draw();
  }

  /** @param {Moments} moments */
  setMoments(moments) {
    this.moments = moments;
    this.draw();
  }

  clear() {
    this.rows = [];
    this.trial = null;
    this.asked = -Infinity;
    this.draw();
  }

  drawNow() {
    const { shown } = this;
    const rows = shown && shown.trial === this.trial ? levelAround(this.rows, shown.t) : [];
    this.note.hidden = rows.length > 0;
    this.svg.toggleAttribute("hidden", !rows.length);
    this.svg.style.visibility = this.ground ? "visible" : "hidden"; // its marks have no place yet
    this.figures.hidden = !rows.length;
    if (!shown || !rows.length) return;
    const level = Number(rows[0].level);
    this.useScene(shown.trial, level);
    if (!this.scene) return;
    const { svg, kind, scene } = this;
    const { clientWidth: width } = svg;
    if (!width) return;
    const size = { width, height: Math.min(width, HEIGHT_MAX) };
    const key = [this.sceneKey, rows.length, rows[rows.length - 1].t, width].join();
    if (this.ground?.key !== key) {
      svg.setAttribute("viewBox", `0 0 ${size.width} ${size.height}`);
      svg.style.height = `${size.height}px`;
      this.ground = { key, drawn: kind.ground(svg, rows, scene, size) };
      svg.style.visibility = "visible";
    }
    const known = rows.filter((row) => row.t <= shown.t + SAME_S);
    const now = shown.row?.level === level ? shown.row : known[known.length - 1];
    if (!now) return;
    const moment = { rows, count: known.length, now, moments: this.moments };
    this.showFigures(kind.moment(svg, this.ground.drawn, scene, moment));
  }

  /**
   * The scene of a level is requested once; until it has arrived there is no map of it.
   * @param {number} trial
   * @param {number} level
   */
  async useScene(trial, level) {
    const key = `${trial}:${level}`;
    if (this.sceneKey === key) return;
    this.sceneKey = key;
    this.scene = null;
    const scene = await this.sceneOf(trial, level);
    if (this.sceneKey !== key || !scene) return;
    this.scene = this.kind.of(scene);
    this.draw();
  }

  /**
   * What the map says, in words and numbers.
   * @param {[string, string][]} figures
   */
  showFigures(figures) {
    const texts = figures.flat();
    if (this.figures.childElementCount !== figures.length)
      this.figures.replaceChildren(
        ...figures.map(() => {
          const pair = document.createElement("div");
          pair.append(document.createElement("dt"), document.createElement("dd"));
          return pair;
        }),
      );
    [...this.figures.querySelectorAll("dt, dd")].forEach((cell, index) => {
      if (cell.textContent !== texts[index]) cell.textContent = texts[index];
    });
  }
}

/**
 * @param {SeriesAnswer} answer
 * @returns {Row[]}
 */
function rowsOf({ t, columns }) {
  return t.map((time, index) => ({
    t: time,
    ...Object.fromEntries(Object.entries(columns).map(([name, values]) => [name, values[index]])),
  }));
}
