// What is drawn of a route that is followed: the part that is done, and the acoustic fixes on the way. No page is
// needed for it.
/**
 * @import { PipeData, Row, Triple } from "../server_data.d.ts"
 * @import { Place } from "./places.js"
 */
import { distance, placeOf } from "./places.js";

/** The columns that it takes, beside where the vehicle is. */
export const ROUTE_COLUMNS = [
  ...["route_x", "route_y", "route_z", "route_along", "route_length", "cross_track"],
  ...["fix_x", "fix_y", "fix_z", "fix_age", "fix_sigma"],
];

/**
 * The two parts of a route that meet at a distance from its start along it, [done, to come].
 * @param {Triple[]} points
 * @param {number} along [m]
 * @returns {[Triple[], Triple[]]}
 */
export function partedAt(points, along) {
  let left = along;
  for (let index = 0; index + 1 < points.length; index++) {
    const [from, to] = [points[index], points[index + 1]];
    const length = Math.hypot(...from.map((value, axis) => to[axis] - value));
    if (left < length) {
      const share = Math.max(left, 0) / length;
      const [x, y, z] = from.map((value, axis) => value + share * (to[axis] - value));
      return [
        [...points.slice(0, index + 1), [x, y, z]],
        [[x, y, z], ...points.slice(index + 1)],
      ];
    }
    left -= length;
  }
  return [points, points.slice(-1)];
}

/**
 * The pieces of a pipe that are above the sand, and those that are covered.
 * @param {PipeData} pipe
 * @returns {{bare: Triple[][], covered: Triple[][]}}
 */
export function piecesOf({ axis, seabed, covered }) {
  /** @type {Triple[]} */
  let rest = axis.map(([north, east]) => [north, east, seabed]);
  let passed = 0;
  /** @type {{bare: Triple[][], covered: Triple[][]}} */
  const pieces = { bare: [], covered: [] };
  for (const [from, to] of covered) {
    const [before, after] = partedAt(rest, from - passed);
    const [under, beyond] = partedAt(after, to - from);
    pieces.bare.push(before);
    pieces.covered.push(under);
    [rest, passed] = [beyond, to];
  }
  pieces.bare.push(rest);
  return pieces;
}

/**
 * A position that the acoustic system has reported: where, how exactly, and when it was measured.
 * @typedef {{at: Place, sigma: number, t: number}} Fix
 */

/**
 * The fix that a row knows; null before the first.
 * @param {Row} row
 * @returns {Fix | null}
 */
export function fixOf(row) {
  const { fix_x: north, fix_y: east, fix_age: age, fix_sigma: sigma } = row;
  if (typeof north !== "number" || typeof east !== "number") return null;
  return { at: [north, east], sigma: Number(sigma), t: row.t - Number(age) };
}

/**
 * All fixes that rows of a level know, each once and in order.
 * @param {Row[]} rows
 * @returns {Fix[]}
 */
export function fixesOf(rows) {
  /** @type {Fix[]} */
  const fixes = [];
  for (const row of rows) {
    const fix = fixOf(row);
    const last = fixes[fixes.length - 1];
    if (fix && (!last || distance(fix.at, last.at) > 0)) fixes.push(fix);
  }
  return fixes;
}

/**
 * How far a fix is from where the vehicle was when it was measured [m].
 * @param {Fix} fix
 * @param {Row[]} rows of the level
 */
export function fixError({ at, t }, rows) {
  const nearest = rows.reduce((best, row) => (Math.abs(row.t - t) < Math.abs(best.t - t) ? row : best));
  return distance(at, placeOf(nearest));
}
