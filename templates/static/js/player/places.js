// Where vehicles and things are on a map, from rows of telemetry. No page is needed for it.
/** @import { Row } from "../server_data.d.ts" */

/** @typedef {[number, number]} Place north and east [m] */

/**
 * How far a vehicle went over ground up to a time [m].
 * @param {Row[]} rows
 * @param {number} t
 */
export function wayUntil(rows, t) {
  let way = 0;
  for (let index = 1; index < rows.length && rows[index].t <= t; index++)
    way += distance(placeOf(rows[index - 1]), placeOf(rows[index]));
  return way;
}

/**
 * @param {Place} one
 * @param {Place} other
 */
export const distance = ([north, east], [toNorth, toEast]) => Math.hypot(toNorth - north, toEast - east);

/**
 * Where a row has the vehicle, or what its columns begin with.
 * @param {Row} row
 * @param {string} [of]
 * @returns {Place}
 */
export const placeOf = (row, of = "") => [Number(row[`${of}x`]), Number(row[`${of}y`])];

/**
 * The rows of the level that runs at a time, up to the next one.
 * @param {Row[]} rows in order
 * @param {number} t
 */
export function levelAround(rows, t) {
  const at = rows.findLastIndex((row) => row.t <= t + SAME_S);
  const level = rows[Math.max(at, 0)]?.level;
  return rows.filter((row) => row.level === level);
}

const SAME_S = 1e-4; // times of rows are rounded
