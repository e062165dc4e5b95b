// The map of a route that is followed: how far it is done, the way of the vehicle, and what it is told of its position.
/**
 * @import { Row, RouteData, Triple } from "../server_data.d.ts"
 * @import { MapKind, MapMoment } from "./level_map.js"
 * @import { Place } from "./places.js"
 * @import { Fix } from "./route_track.js"
 */
import { need } from "../dom.js";
import { current, heading, number } from "./formatting.js";
import { around, circle, discs, drawGrid, line, move, write } from "./map_drawing.js";
import { MapScale } from "./map_scale.js";
import { along, fix as fixText } from "./numbers.js";
import { placeOf } from "./places.js";
import { fixError, fixesOf, fixOf, partedAt, piecesOf, ROUTE_COLUMNS } from "./route_track.js";

const STILL_M_S = 0.005; // a current that is slower has no direction
const SAME_S = 0.01; // times of one fix are rounded
const CORNER_PX = 26; // of the arrow of the current from the upper right corner
const DEGREES = 180 / Math.PI;
/** @type {(point: Triple) => Place} */
const above = ([north, east]) => [north, east];

/** @typedef {{scale: MapScale, ways: Place[], fixes: Fix[]}} Ground what stays for a level, and what its rows add */

/** @type {MapKind<RouteData, Ground>} */
export const ROUTE = {
  columns: ["level", "x", "y", "yaw", "current_x", "current_y", ...ROUTE_COLUMNS],
  of: ({ route }) => route ?? null,
  ground: drawGround,
  moment(svg, ground, route, moment) {
    drawMoment(svg, ground, route, moment);
    return figuresOf(route, moment);
  },
};

/**
 * @param {SVGSVGElement} svg
 * @param {Row[]} rows
 * @param {RouteData} route
 * @param {{width: number, height: number}} size [px]
 * @returns {Ground}
 */
function drawGround(svg, rows, { points, told_error: off, error, pipe }, size) {
  const ways = rows.map((row) => placeOf(row));
  const [start] = ways;
  /** @type {Place} */
  const told = [start[0] + off[0], start[1] + off[1]];
  const fixes = fixesOf(rows);
  const places = [...points.map(above), ...ways, ...fixes.map(({ at }) => at), ...around(told, error)];
  const scale = new MapScale(places, { ...size, origin: start });
  drawGrid(need(svg, '[data-map="grid"]', SVGGElement), scale);
  circle(svg, "told-disc", scale.at(told), error * scale.perMetre);
  move(svg, "told", scale.at(told));
  move(svg, "start", scale.at(start));
  const pieces = pipe ? piecesOf(pipe) : { bare: [], covered: [] };
  for (const [part, drawn] of Object.entries(pieces)) {
    write(svg, part, drawn.map((piece) => line(scale, piece.map(above))).join(""));
  }
  return { scale, ways, fixes };
}

/**
 * @param {SVGSVGElement} svg
 * @param {Ground} ground
 * @param {RouteData} route
 * @param {MapMoment} moment
 */
function drawMoment(svg, { scale, ways, fixes }, { points }, { count, now }) {
  const [done, rest] = partedAt(points, Number(now.route_along));
  write(svg, "done", line(scale, done.map(above)));
  write(svg, "rest", line(scale, rest.map(above)));
  write(svg, "way", line(scale, [...ways.slice(0, count), placeOf(now)]));
  const fix = fixOf(now);
  const before = fixes.filter(({ t }) => fix && t < fix.t - SAME_S);
  write(svg, "fixes", discs(scale, before));
  write(svg, "fix", fix ? discs(scale, [fix]) : "");
  move(svg, "due", scale.at(placeOf(now, "route_")));
  move(svg, "vehicle", scale.at(placeOf(now)), Number(now.yaw) * DEGREES);
  const [north, east] = placeOf(now, "current_");
  need(svg, '[data-map="current"]', SVGGElement).toggleAttribute("hidden", Math.hypot(north, east) < STILL_M_S);
  move(svg, "current", [scale.width - CORNER_PX, CORNER_PX], Math.atan2(east, north) * DEGREES);
}

/**
 * @param {RouteData} route
 * @param {MapMoment} moment
 * @returns {[string, string][]}
 */
function figuresOf({ boat, told_error: off }, { rows, now }) {
  const fix = fixOf(now);
  const [north, east] = [boat[0] - Number(now.x), boat[1] - Number(now.y)];
  return [
    ["Off the route", number(now.cross_track, 2, "m")],
    ["Along the route", along(now)],
    ["Last fix", fixText(now)],
    ["It was off by", fix ? number(fixError(fix, rows), 2, "m") : "–"],
    ["Told start off by", number(Math.hypot(...off), 2, "m")],
    ["Current", current(now.current_x, now.current_y)],
    ["Boat", `${number(Math.hypot(north, east), 0, "m")} away at ${heading(Math.atan2(east, north))}`],
  ];
}
