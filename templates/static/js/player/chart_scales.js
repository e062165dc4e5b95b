// The vertical scales of a chart: linear, or logarithmic for distances.

const DISTANCES = ["distance", "distance_px", "tracker_error"]; // columns that are never negative
const DECADES_MAX = 4; // shown below the largest value

export function isDistance({ columns }) {
  return columns.every((name) => DISTANCES.includes(name));
}

// Both leave room above the lines for the labels of the levels.
function linearRange(_plot, min, max) {
  if (min === null || max === null) return [0, 1];
  const span = Math.max(max - min, 1e-6);
  const base = min >= 0 && min < 0.5 * max ? 0 : min - 0.08 * span;
  return [base, max + 0.28 * span];
}

function logarithmicRange(_plot, min, max) {
  if (min === null || max === null || max <= 0) return [0.1, 10];
  const lowest = max / 10 ** DECADES_MAX;
  const base = 10 ** Math.floor(Math.log10(Math.max(min, lowest)));
  return [base, max * (max / base) ** 0.28];
}

export function yScale(logarithmic) {
  return logarithmic ? { distr: 3, log: 10, range: logarithmicRange } : { range: linearRange };
}

// Of the lines of a logarithmic grid, those of the decades.
function decades(_plot, ticks) {
  return ticks.map((tick) => (Math.abs(Math.log10(tick) - Math.round(Math.log10(tick))) < 1e-6 ? tick : null));
}

const tickText = (tick) => (tick === null ? "" : String(Number(tick.toPrecision(6))));

// axis: what both kinds share
export function yAxis(axis, logarithmic) {
  const filters = logarithmic ? { filter: decades, grid: { ...axis.grid, filter: decades } } : {};
  return { ...axis, ...filters, size: 56, values: (_plot, ticks) => ticks.map(tickText) };
}

// Zero has no place on a logarithmic axis.
export function drawable(values, logarithmic) {
  return logarithmic ? values.map((value) => (value > 0 ? value : null)) : values;
}
