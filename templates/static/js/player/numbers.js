// The numbers at the playhead, beside the scene.
/** @import { Row } from "../server_data.d.ts" */

import { current, heading, number } from "./formatting.js";

/** @param {Row} row */
function tracker({ tracker_ok: ok, tracker_error: error, searching }) {
  if (searching === 1) return "has no target";
  return ok === 1 ? `error ${number(error, 1, "px")}` : "lost the target";
}

/** @param {Row} row */
function detector({ searching, confidence }) {
  return searching === 1 ? "looks for the box" : number(100 * Number(confidence), 0, "% sure");
}

/**
 * How far a vehicle is from where it rests in the dock, or undefined if there is none.
 * @param {Row} row
 */
export function offSeat({ dock_ahead: ahead, dock_side: side, dock_below: below }) {
  return ahead === undefined ? undefined : Math.hypot(Number(ahead), Number(side), Number(below));
}

/** @param {Row} row */
export function along({ route_along: done, route_length: length }) {
  return `${number(done, 1, "m")} of ${number(length, 1, "m")}`;
}

/** @param {Row} row */
export function fix({ fix_age: age, fix_sigma: sigma }) {
  if (typeof age !== "number") return "none yet";
  return `${number(age, 1, "s")} old, ± ${number(sigma, 2, "m")}`;
}

/**
 * Label, a column that it needs, text.
 * @type {[string, string, (row: Row) => string][]}
 */
const SHOWN = [
  ["Tool from the grip", "reach", (row) => number(row.reach, 3, "m")],
  ["Push of the arm", "work_push_n", (row) => number(row.work_push_n, 0, "N")],
  ["Off the seat", "dock_ahead", (row) => number(offSeat(row), 3, "m")],
  ["Distance to station", "distance", (row) => number(row.distance, 3, "m")],
  ["Target from centre", "tracker_ok", (row) => number(row.distance_px, 1, "px")],
  ["Tracker", "tracker_ok", tracker],
  ["Detector", "confidence", detector],
  ["Off the route", "cross_track", (row) => number(row.cross_track, 2, "m")],
  ["Along the route", "route_along", along],
  ["Acoustic fix", "fix_age", fix],
  ["Current", "current_x", (row) => current(row.current_x, row.current_y)],
  ["Depth", "z", (row) => number(row.z, 2, "m")],
  ["Heading", "yaw", (row) => heading(row.yaw)],
];

export class Numbers {
  /**
   * columns: those that the run has; a log of a mission may lack some; stage: of a row, in words, if there are stages
   * @param {HTMLElement} list
   * @param {{name: string}[]} columns
   * @param {((row: Row) => string) | null} [stage]
   */
  constructor(list, columns, stage = null) {
    /** @type {(wanted: string) => boolean} */
    const has = (wanted) => columns.some(({ name }) => name === wanted);
    const known = SHOWN.filter(([, column]) => has(column));
    // An arm's reach or a dock's seat stands for the distance, and a route has no target that a tracker follows.
    const left = has("reach") || has("dock_ahead") ? "distance" : has("cross_track") ? "tracker_ok" : "";
    const shown = known.filter(([, column]) => column !== left);
    /** @type {typeof SHOWN} */
    this.shown = stage ? [...shown, ["Stage", "", stage]] : shown;
    this.values = this.shown.map(([label]) => {
      const pair = document.createElement("div");
      const name = document.createElement("dt");
      const value = document.createElement("dd");
      name.textContent = label;
      pair.append(name, value);
      list.append(pair);
      return value;
    });
  }

  /**
   * [[label, text], ...] of a row; null before there is one.
   * @param {Row | null} row
   * @returns {[string, string][]}
   */
  lines(row) {
    return this.shown.map(([label, , text]) => [label, row ? text(row) : "–"]);
  }

  /** @param {Row | null} row */
  show(row) {
    this.lines(row).forEach(([, text], index) => {
      const value = this.values[index];
      if (value.textContent !== text) value.textContent = text;
    });
  }
}
