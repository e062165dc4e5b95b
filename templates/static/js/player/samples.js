// Telemetry as charts have it: times in increasing order, and of each column as many values. No page is
// needed for it.

/**
 * @typedef {object} Samples
 * @property {number[]} t [s]
 * @property {Record<string, (number | null)[]>} values of each column, as long as `t`
 */

const SAME_S = 1e-6;
const END_S = 1; // so long after its last row a run still has its last values
const WHOLE_ROWS = 200; // the newest ones are never thinned out

/** @returns {Samples} */
export function noSamples() {
  return { t: [], values: {} };
}

/**
 * The index of the last time up to `t`; 0 before the first, -1 if there are none.
 * @param {number[]} times [s]
 * @param {number} t [s]
 * @param {number} tolerance [s]
 */
export function lastUntil(times, t, tolerance = SAME_S) {
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= t + tolerance) low = middle;
    else high = middle - 1;
  }
  return Math.min(low, times.length - 1);
}

/**
 * The value of a column at or before time `t`; null after the end.
 * @param {Samples} samples
 * @param {string} column
 * @param {number} t [s]
 */
export function valueAt({ t: times, values }, column, t) {
  if (!times.length || t > times[times.length - 1] + END_S) return null;
  return values[column]?.[lastUntil(times, t)] ?? null;
}

/**
 * Appends rows of the event stream in place; those that are replayed are there already.
 * @param {Samples} samples
 * @param {string[]} wanted columns, null where the rows lack them
 * @param {string[]} columns of the rows
 * @param {(number | null)[][]} rows
 */
export function appendRows({ t, values }, wanted, columns, rows) {
  const at = columns.indexOf("t");
  for (const row of rows) {
    const time = Number(row[at]);
    if (t.length && time <= t[t.length - 1]) continue;
    t.push(time);
    for (const name of wanted) {
      const index = columns.indexOf(name);
      values[name] ??= new Array(t.length - 1).fill(null);
      values[name].push(index < 0 ? null : row[index]);
    }
  }
}

/**
 * Every second sample, and the newest ones.
 * @param {Samples} samples
 * @returns {Samples}
 */
export function thinned({ t, values }) {
  /** @type {<T>(all: T[]) => T[]} */
  const kept = (all) => all.filter((_value, index) => index % 2 === 0 || index > t.length - WHOLE_ROWS);
  const columns = Object.entries(values).map(([name, column]) => [name, kept(column)]);
  return { t: kept(t), values: Object.fromEntries(columns) };
}

/**
 * The level that ran at a position of the trial; null if that is not known yet. Benchmarks may draw
 * the order of the levels, so it is read from the telemetry.
 * @param {Samples} samples
 * @param {number} position 0 for the first level of the trial
 * @param {number} length of a level [s]
 */
export function levelAt({ t, values }, position, length) {
  // The middle of a level, since points between two levels may be extremes of both.
  const from = t.findIndex((time) => time >= (position + 0.1) * length);
  if (from < 0 || t[from] >= (position + 1) * length) return null;
  return values.level?.[from] ?? null;
}
