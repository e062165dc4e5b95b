// The vertical scales of a chart: linear, or logarithmic for distances.
/** @import uPlot from "uplot" */

const DISTANCES = ["distance", "distance_px", "tracker_error"]; // columns that are never negative
const ROOM = 0.28;
const DECADES_MAX = 4; // shown below the largest value

/** @param {{columns: string[]}} chart */
export function isDistance({ columns }) {
  return columns.every((name) => DISTANCES.includes(name));
}

/**
 * Both leave room above the lines for the labels of the levels, as a share of the range.
 * @param {number | null} min
 * @param {number | null} max
 * @param {number} [room]
 * @returns {[number, number]}
 */
export function linearRange(min, max, room = ROOM) {
  if (min === null || max === null) return [0, 1];
  const span = Math.max(max - min, 1e-6);
  const base = min >= 0 && min < 0.5 * max ? 0 : min - 0.08 * span;
  return [base, max + room * span];
}

/**
 * @param {number | null} min
 * @param {number | null} max
 * @returns {[number, number]}
 */
export function logarithmicRange(min, max) {
  if (min === null || max === null || max <= 0) return [0.1, 10];
  const lowest = max / 10 ** DECADES_MAX;
  const base = 10 ** Math.floor(Math.log10(Math.max(min, lowest)));
  return [base, max * (max / base) ** ROOM];
}

/**
 * @param {boolean} logarithmic
 * @returns {uPlot.Scale}
 */
export function yScale(logarithmic) {
  return logarithmic
    ? { distr: 3, log: 10, range: (_plot, min, max) => logarithmicRange(min, max) }
    : { range: (_plot, min, max) => linearRange(min, max) };
}

/**
 * Of the lines of a logarithmic grid, those of the decades; null for the others.
 * @param {number[]} ticks
 */
export function decades(ticks) {
  return ticks.map((tick) => (Math.abs(Math.log10(tick) - Math.round(Math.log10(tick))) < 1e-6 ? tick : null));
}

/** @type {(tick: number | null) => string} */
export const tickText = (tick) => (tick === null ? "" : String(Number(tick.toPrecision(6))));

/**
 * axis: what both kinds share
 * @param {uPlot.Axis} axis
 * @param {boolean} logarithmic
 * @returns {uPlot.Axis}
 */
export function yAxis(axis, logarithmic) {
  /** @type {uPlot.Axis.Filter} */
  const filter = (_plot, ticks) => decades(ticks);
  const filters = logarithmic ? { filter, grid: { ...axis.grid, filter } } : {};
  return { ...axis, ...filters, size: 56, values: (_plot, ticks) => ticks.map(tickText) };
}

/**
 * Zero has no place on a logarithmic axis.
 * @param {(number | null)[]} values
 * @param {boolean} logarithmic
 */
export function drawable(values, logarithmic) {
  return logarithmic ? values.map((value) => (value !== null && value > 0 ? value : null)) : values;
}
