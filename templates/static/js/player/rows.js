// Whole rows of telemetry around the playhead, from the series API in windows that are as long as
// the replay is fast: whatever the speed, a second of watching costs about twenty rows.
/** @import { Between, Row, SeriesAnswer } from "../server_data.d.ts" */
import { ROUTE_COLUMNS } from "./route_track.js";
import { lastUntil } from "./samples.js";

export const WINDOW_ROWS = 401;
const WINDOW_S = 20; // at speed 1, with every row of 0.05 s
const WINDOWS_MAX = 16; // kept
const LIVE_ROWS = 600; // of the newest ones that arrived
export const SAME_S = 1e-4; // times of rows are rounded
const ALWAYS = [
  ...["level", "x", "y", "z", "roll", "pitch", "yaw", "current_x", "current_y", "current_z"],
  ...["target_x", "target_y", "tracked_x", "tracked_y", "tracker_ok", "tracker_error", "distance", "distance_px"],
  ...ROUTE_COLUMNS,
];
const DOCK = /^searching$|^dock_(ahead|side|below)$/;
const NUMBERED = /^(thrust|joint|touch)_\d+$|^(wrist|work)_f[xyz]$/; // of thrusters and an arm
const WORK = /^workpiece_(x|y|z|roll|pitch|yaw|joint)$|^tool_[xyz]$|^reach$|^work_(arm|push)_n$/;
const SEARCH = /^(searching|confidence)$|^decoy_(x|y|z|roll|pitch|yaw)$|^(work|decoy)_(arm|hull|rest)_n$/;

/**
 * The columns that scene, camera and numbers use, of those that the run has: [{name}, ...].
 * @param {{name: string}[]} columns
 * @returns {string[]}
 */
export function rowColumns(columns) {
  const names = columns.map(({ name }) => name);
  const kinds = [
    NUMBERED,
    WORK,
    ...(names.includes("decoy_x") ? [SEARCH] : []),
    ...(names.includes("dock_x") ? [DOCK] : []),
  ];
  return names.filter((name) => kinds.some((kind) => kind.test(name)) || ALWAYS.includes(name));
}

/**
 * A part of a trial, with the rows that the API has chosen of it.
 * @typedef {{trial: number, from: number, until: number, length: number} & SeriesAnswer} Window
 */

export class Rows {
  /**
   * @param {string} api
   * @param {string[]} columns
   */
  constructor(api, columns) {
    this.api = api;
    this.columns = columns;
    /** @type {Map<string, Window>} */
    this.windows = new Map();
    /** @type {Set<string>} */
    this.pending = new Set();
    this.recent = nothing(0);
    this.onRows = () => {};
  }

  clear() {
    this.windows.clear();
    this.recent = nothing(0);
  }

  /**
   * Adds rows of the event stream, which names their columns.
   * @param {number} trial
   * @param {string[]} columns
   * @param {(number | null)[][]} rows
   */
  append(trial, columns, rows) {
    if (trial !== this.recent.trial) this.recent = nothing(trial);
    const { t, rows: kept } = this.recent;
    for (const row of rows) {
      const values = rowFrom(columns, row);
      if (t.length && values.t <= t[t.length - 1]) continue;
      t.push(values.t);
      kept.push(values);
    }
    if (t.length > 2 * LIVE_ROWS) {
      t.splice(0, t.length - LIVE_ROWS);
      kept.splice(0, kept.length - LIVE_ROWS);
    }
  }

  /**
   * Requests what is missing around the playhead; `onRows` is called when it has arrived.
   * @param {{trial: number, t: number, speed: number, playing: boolean, following: boolean, newest: number}} playhead
   */
  want({ trial, t, speed, playing, following, newest }) {
    if (following) return;
    const length = WINDOW_S * (playing ? Math.max(speed, 1) : 1);
    const index = Math.floor((t + SAME_S) / length);
    this.load(trial, index, length, newest);
    const share = t / length - index;
    if (playing && share > 0.4) this.load(trial, index + 1, length, newest);
    if (share < 0.5 && index > 0) this.load(trial, index - 1, length, newest);
  }

  /**
   * @param {number} trial
   * @param {number} index
   * @param {number} length
   * @param {number} newest
   */
  async load(trial, index, length, newest) {
    const from = index * length;
    const key = `${trial}:${length}:${index}`;
    const known = this.windows.get(key);
    const complete = known && (known.until >= from + length - SAME_S || known.until >= newest - SAME_S);
    if (from > newest || complete || this.pending.has(key)) return;
    this.pending.add(key);
    try {
      const range = `&sample=rows&max_points=${WINDOW_ROWS}&start=${from}&stop=${from + length}`;
      const response = await fetch(`${this.api}/series.json?columns=${this.columns.join(",")}&trial=${trial}${range}`);
      if (!response.ok) return;
      /** @type {SeriesAnswer} */
      const { t, columns } = await response.json();
      this.windows.delete(key); // the order of a Map is that of insertion: the oldest goes first
      if (t.length)
        this.windows.set(key, { trial, from, until: Math.max(newest, t[t.length - 1]), length, t, columns });
      while (this.windows.size > WINDOWS_MAX) this.windows.delete(this.windows.keys().next().value ?? "");
      this.onRows();
    } finally {
      this.pending.delete(key);
    }
  }

  /**
   * The finest window with a row at or before time `t`.
   * @param {number} trial
   * @param {number} t
   */
  windowAt(trial, t) {
    /** @type {Window | null} */
    let best = null;
    for (const span of this.windows.values()) {
      const holds = span.trial === trial && span.from <= t + SAME_S && t <= span.from + span.length + SAME_S;
      if (holds && span.t[0] <= t + SAME_S && (!best || span.length < best.length)) best = span;
    }
    return best;
  }

  /**
   * The row at or before time `t`, and where `t` lies between it and the next: {row, next, share}.
   * Null while it has not arrived.
   * @param {number} trial
   * @param {number} t
   * @returns {Between | null}
   */
  at(trial, t) {
    const span = this.windowAt(trial, t);
    if (span) return between(span.t, t, (index) => this.rowOf(span, index));
    const { recent } = this;
    if (recent.trial !== trial || !recent.t.length || recent.t[0] > t) return null;
    return between(recent.t, t, (index) => recent.rows[index]);
  }

  /**
   * @param {Window} span
   * @param {number} index
   * @returns {Row}
   */
  rowOf(span, index) {
    /** @type {Row} */
    const row = { t: span.t[index] };
    for (const name of this.columns) row[name] = span.columns[name][index];
    return row;
  }

  /**
   * Positions {t, x, y, z} of the same level up to time `t`, over at most `length` [s], oldest first.
   * @param {number} trial
   * @param {number} t
   * @param {number} length
   * @returns {Row[]}
   */
  before(trial, t, length) {
    /** @type {Row[]} */
    const rows = [];
    const spans = [...this.windows.values()].filter(
      (one) => one.trial === trial && one.from <= t && one.from + one.length > t - length,
    );
    const finest = Math.min(...spans.map((one) => one.length));
    for (const one of spans.filter((window) => window.length === finest).sort((a, b) => a.from - b.from)) {
      one.t.forEach((time, index) => {
        const isNew = !rows.length || time > rows[rows.length - 1].t;
        if (!isNew || time > t + SAME_S || time <= t - length) return;
        const { x, y, z, level } = one.columns;
        rows.push({ t: time, x: x[index], y: y[index], z: z[index], level: level[index] });
      });
    }
    const all =
      rows.length || this.recent.trial !== trial ? rows : this.recent.rows.filter((row) => row.t <= t + SAME_S);
    const level = all.length ? all[all.length - 1].level : null;
    return all.filter((row) => row.level === level);
  }
}

/**
 * @param {number} trial
 * @returns {{trial: number, t: number[], rows: Row[]}}
 */
function nothing(trial) {
  return { trial, t: [], rows: [] };
}

/**
 * @param {string[]} columns
 * @param {(number | null)[]} values
 * @returns {Row}
 */
function rowFrom(columns, values) {
  return { t: 0, ...Object.fromEntries(columns.map((name, at) => [name, values[at]])) };
}

/**
 * @param {number[]} times
 * @param {number} t
 * @param {(index: number) => Row} rowAt
 * @returns {Between}
 */
function between(times, t, rowAt) {
  const low = lastUntil(times, t, SAME_S);
  const row = rowAt(low);
  const next = low + 1 < times.length ? rowAt(low + 1) : row;
  const step = next.t - row.t;
  const sameLevel = next.level === row.level;
  return {
    row,
    next: sameLevel ? next : row,
    share: step > 0 && sameLevel ? Math.min(Math.max((t - row.t) / step, 0), 1) : 0,
  };
}
