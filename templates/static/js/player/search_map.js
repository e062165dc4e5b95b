// The map of a search: north up, what the camera has seen, where the vehicle was and is, and where the boxes are.
/**
 * @import { Moments, Row, SceneData, SearchData, SeriesAnswer } from "../server_data.d.ts"
 * @import { Phase, Place } from "./search_track.js"
 */
import { need } from "../dom.js";
import { number } from "./formatting.js";
import { EDGE_PX, MapScale } from "./map_scale.js";
import { NONE } from "./marks.js";
import { paced } from "./paced.js";
import { SAME_S } from "./rows.js";
import { distance, footprint, levelAround, phaseOf, placeOf, TRACK_COLUMNS, wayUntil } from "./search_track.js";

const POINTS = 2400; // of a trial
const LIVE_S = 0.25; // from one row of a live run that is kept to the next
const LOAD_AGAIN_MS = 2000; // what could not be loaded
const HEIGHT_MAX = 460; // [px]
const PHASES = /** @type {Phase[]} */ (["searching", "following", "carrying", "mistaken"]);
const IN_WORDS = {
  searching: "searching",
  following: "following what it found",
  carrying: "carrying the right box",
  mistaken: "carrying the wrong box",
};

/** @typedef {SceneData & {search: SearchData}} SearchScene */

export class SearchMap {
  /**
   * scene: of a level, null if it has none
   * @param {HTMLElement} box
   * @param {{api: string, scene: (trial: number, level: number) => Promise<SceneData | null>}} run
   */
  constructor(box, { api, scene }) {
    this.api = api;
    this.sceneOf = scene;
    this.svg = need(box, "svg", SVGSVGElement);
    this.note = need(box, "[data-map-note]", HTMLElement);
    this.figures = need(box, "[data-map-figures]", HTMLElement);
    /** @type {Row[]} of the trial, in order */
    this.rows = [];
    /** @type {number | null} */
    this.trial = null;
    this.asked = -Infinity; // when rows were asked for [ms]
    this.moments = NONE;
    /** @type {SearchScene | null} */
    this.scene = null;
    this.sceneKey = "";
    /** @type {{trial: number, t: number, row: Row | null} | null} */
    this.shown = null;
    /** @type {{key: string, rows: Row[], scale: MapScale, steps: Step[]} | null} */
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
    const query = `columns=${TRACK_COLUMNS.join(",")}&trial=${trial}&sample=rows&max_points=${POINTS}`;
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
    this.figures.hidden = !rows.length;
    if (!shown || !rows.length) return;
    const level = Number(rows[0].level);
    this.useScene(shown.trial, level);
    if (!this.scene) return;
    const { clientWidth: width } = this.svg;
    if (!width) return;
    const size = { width, height: Math.min(width, HEIGHT_MAX) };
    const key = [this.sceneKey, rows.length, rows[rows.length - 1].t, width].join();
    if (this.ground?.key !== key) this.ground = { key, ...drawGround(this.svg, rows, this.scene, size) };
    const known = rows.filter((row) => row.t <= shown.t + SAME_S);
    const now = shown.row?.level === level ? shown.row : known[known.length - 1];
    if (now) this.drawMoment(this.scene, this.ground, known.length, now, rows);
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
    if (this.sceneKey !== key || !scene?.search) return;
    this.scene = { ...scene, search: scene.search };
    this.draw();
  }

  /**
   * @param {SearchScene} scene
   * @param {{scale: MapScale, steps: Step[]}} ground
   * @param {number} count of its steps up to the moment
   * @param {Row} now
   * @param {Row[]} rows of the level
   */
  drawMoment(scene, { scale, steps }, count, now, rows) {
    const { svg } = this;
    const before = steps.slice(0, count);
    write(svg, "seen", [...before.map(({ seen }) => seen), outline(scale, footprint(now, scene))].join(""));
    for (const phase of PHASES) {
      const lines = before.map((step) => (step.phase === phase ? step.line : ""));
      const last = before[before.length - 1];
      if (last && phaseOf(now) === phase) lines.push(`M${last.at}L${scale.text(placeOf(now))}`);
      write(svg, phase, lines.join(""));
    }
    write(svg, "view", outline(scale, footprint(now, scene)));
    for (const [name, of] of BOXES) {
      const way = before.map(({ row }) => scale.text(placeOf(row, of)));
      write(svg, `${name}-way`, `M${[...way, scale.text(placeOf(now, of))].join("L")}`);
      move(svg, name, scale.at(placeOf(now, of)));
    }
    move(svg, "vehicle", scale.at(placeOf(now)), (Number(now.yaw) * 180) / Math.PI);
    this.showFigures(scene.search, now, rows);
  }

  /**
   * What the map says, in words and numbers.
   * @param {SearchData} search
   * @param {Row} now
   * @param {Row[]} rows of the level
   */
  showFigures({ start, told, mark }, now, rows) {
    const [first] = rows;
    const stage = this.moments.stages?.find((one) => one.stage === 0 && one.level === first.level);
    const [box, decoy] = ["workpiece_", "decoy_"].map((of) => placeOf(first, of));
    const home = distance(start, placeOf(now, "workpiece_"));
    /** @type {[string, string][]} */
    const figures = [
      ["Now", IN_WORDS[phaseOf(now)]],
      ["Found after", stage ? number(stage.t - first.t, 1, "s") : "not yet"],
      [stage ? "Way until then" : "Way so far", number(wayUntil(rows, stage?.t ?? now.t), 1, "m")],
      ["Told position off by", number(distance(told, box), 2, "m")],
      ["Between the boxes", number(distance(box, decoy), 2, "m")],
      ["Box from the start", `${number(home, 2, "m")}${home <= mark ? ", within the circle" : ""}`],
    ];
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

/** @type {["box" | "decoy", string][]} */
const BOXES = [
  ["box", "workpiece_"],
  ["decoy", "decoy_"],
];

/**
 * What a row adds to the map.
 * @typedef {{row: Row, at: string, phase: Phase, line: string, seen: string}} Step
 */

/**
 * @param {SeriesAnswer} answer
 * @returns {Row[]}
 */
function rowsOf({ t, columns }) {
  return t.map((time, index) => ({
    t: time,
    ...Object.fromEntries(TRACK_COLUMNS.map((name) => [name, columns[name][index]])),
  }));
}

/**
 * Draws what stays for a level, and returns what its rows add.
 * @param {SVGSVGElement} svg
 * @param {Row[]} rows
 * @param {SearchScene} scene
 * @param {{width: number, height: number}} size [px]
 * @returns {{rows: Row[], scale: MapScale, steps: Step[]}}
 */
function drawGround(svg, rows, scene, { width, height }) {
  const { start, told, error, mark } = scene.search;
  const views = rows.map((row) => footprint(row, scene));
  const boxes = BOXES.flatMap(([, of]) => [rows[0], rows[rows.length - 1]].map((row) => placeOf(row, of)));
  const places = [...views.flat(), ...around(start, mark), ...around(told, error), ...boxes];
  const scale = new MapScale(places, { width, height, origin: start });
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.style.height = `${height}px`;
  drawGrid(need(svg, '[data-map="grid"]', SVGGElement), scale);
  circle(svg, "mark", scale.at(start), mark * scale.perMetre);
  circle(svg, "told-disc", scale.at(told), error * scale.perMetre);
  move(svg, "start", scale.at(start));
  move(svg, "told", scale.at(told));
  const steps = rows.map((row, index) => {
    const at = scale.text(placeOf(row));
    const before = index ? scale.text(placeOf(rows[index - 1])) : at;
    return { row, at, phase: phaseOf(row), line: `M${before}L${at}`, seen: outline(scale, views[index]) };
  });
  return { rows, scale, steps };
}

/**
 * @param {SVGGElement} group
 * @param {MapScale} scale
 */
function drawGrid(group, scale) {
  const { norths, easts } = scale.grid();
  const [right, bottom] = [scale.width, scale.height - EDGE_PX];
  const lines = [
    ...norths.map(({ px }) => `M${EDGE_PX} ${px}H${right}`),
    ...easts.map(({ px }) => `M${px} 0V${bottom}`),
  ];
  const path = made("path", { d: lines.join("") });
  const texts = [
    ...norths
      .filter(({ px }) => px > 20 && px < bottom - 4)
      .map(({ metres, px }) => label(metres, { x: EDGE_PX - 5, y: px + 4, "text-anchor": "end" })),
    ...easts
      .filter(({ px }) => px < right - 40)
      .map(({ metres, px }) => label(metres, { x: px, y: bottom + 16, "text-anchor": "middle" })),
  ];
  const axes = [label("N [m]", { x: 0, y: 12 }), label("E [m]", { x: right, y: bottom + 16, "text-anchor": "end" })];
  group.replaceChildren(path, ...texts, ...axes);
}

/**
 * @param {string} name
 * @param {Record<string, string | number>} attributes
 */
function made(name, attributes) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  return element;
}

/**
 * @param {string | number} text
 * @param {Record<string, string | number>} attributes
 */
function label(text, attributes) {
  const element = made("text", attributes);
  element.textContent = String(text).replace("-", "−");
  return element;
}

/**
 * @param {MapScale} scale
 * @param {Place[]} corners
 */
function outline(scale, corners) {
  return `M${corners.map((corner) => scale.text(corner)).join("L")}Z`;
}

/**
 * The corners of the square around a circle.
 * @param {Place} centre
 * @param {number} radius
 * @returns {Place[]}
 */
function around([north, east], radius) {
  return [
    [north - radius, east - radius],
    [north + radius, east + radius],
  ];
}

/**
 * @param {SVGSVGElement} svg
 * @param {string} name
 * @param {string} path
 */
function write(svg, name, path) {
  need(svg, `[data-map="${name}"]`, SVGPathElement).setAttribute("d", path);
}

/**
 * @param {SVGSVGElement} svg
 * @param {string} name
 * @param {[number, number]} at [px]
 * @param {number} [turned] [°]
 */
function move(svg, name, [x, y], turned = 0) {
  const mark = need(svg, `[data-map="${name}"]`, SVGGElement);
  mark.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)}) rotate(${turned.toFixed(1)})`);
}

/**
 * @param {SVGSVGElement} svg
 * @param {string} name
 * @param {[number, number]} centre [px]
 * @param {number} radius [px]
 */
function circle(svg, name, [x, y], radius) {
  const element = need(svg, `[data-map="${name}"]`, SVGCircleElement);
  for (const [key, value] of Object.entries({ cx: x, cy: y, r: radius })) element.setAttribute(key, value.toFixed(1));
}
