// The map of a search: what the camera has seen, where the vehicle was and is, and where the boxes are.
/**
 * @import { Row, SceneData, SearchData } from "../server_data.d.ts"
 * @import { MapKind, MapMoment } from "./level_map.js"
 * @import { Phase } from "./search_track.js"
 */
import { need } from "../dom.js";
import { number } from "./formatting.js";
import { around, circle, drawGrid, move, outline, write } from "./map_drawing.js";
import { MapScale } from "./map_scale.js";
import { distance, placeOf, wayUntil } from "./places.js";
import { footprint, phaseOf, TRACK_COLUMNS } from "./search_track.js";

const PHASES = /** @type {Phase[]} */ (["searching", "following", "carrying", "mistaken"]);
const IN_WORDS = {
  searching: "searching",
  following: "following what it found",
  carrying: "carrying the right box",
  mistaken: "carrying the wrong box",
};
/** @type {["box" | "decoy", string][]} */
const BOXES = [
  ["box", "workpiece_"],
  ["decoy", "decoy_"],
];

/** @typedef {SceneData & {search: SearchData}} SearchScene */

/**
 * What a row adds to the map.
 * @typedef {{row: Row, at: string, phase: Phase, line: string, seen: string}} Step
 */

/** @typedef {{scale: MapScale, steps: Step[]}} Ground what stays for a level, and what its rows add */

/** @type {MapKind<SearchScene, Ground>} */
export const SEARCH = {
  columns: TRACK_COLUMNS,
  of: (scene) => (scene.search ? { ...scene, search: scene.search } : null),
  ground: drawGround,
  moment(svg, ground, scene, moment) {
    drawMoment(svg, ground, scene, moment);
    return figuresOf(scene.search, moment);
  },
};

/**
 * @param {SVGSVGElement} svg
 * @param {Row[]} rows
 * @param {SearchScene} scene
 * @param {{width: number, height: number}} size [px]
 * @returns {Ground}
 */
function drawGround(svg, rows, scene, size) {
  const { start, told, error, mark } = scene.search;
  const views = rows.map((row) => footprint(row, scene));
  const boxes = BOXES.flatMap(([, of]) => [rows[0], rows[rows.length - 1]].map((row) => placeOf(row, of)));
  const places = [...views.flat(), ...around(start, mark), ...around(told, error), ...boxes];
  const scale = new MapScale(places, { ...size, origin: start });
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
  return { scale, steps };
}

/**
 * @param {SVGSVGElement} svg
 * @param {Ground} ground
 * @param {SearchScene} scene
 * @param {MapMoment} moment
 */
function drawMoment(svg, { scale, steps }, scene, { count, now }) {
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
}

/**
 * @param {SearchData} search
 * @param {MapMoment} moment
 * @returns {[string, string][]}
 */
function figuresOf({ start, told, mark }, { rows, now, moments }) {
  const [first] = rows;
  const stage = moments.stages?.find((one) => one.stage === 0 && one.level === first.level);
  const [box, decoy] = ["workpiece_", "decoy_"].map((of) => placeOf(first, of));
  const home = distance(start, placeOf(now, "workpiece_"));
  return [
    ["Now", IN_WORDS[phaseOf(now)]],
    ["Found after", stage ? number(stage.t - first.t, 1, "s") : "not yet"],
    [stage ? "Way until then" : "Way so far", number(wayUntil(rows, stage?.t ?? now.t), 1, "m")],
    ["Told position off by", number(distance(told, box), 2, "m")],
    ["Between the boxes", number(distance(box, decoy), 2, "m")],
    ["Box from the start", `${number(home, 2, "m")}${home <= mark ? ", within the circle" : ""}`],
  ];
}
