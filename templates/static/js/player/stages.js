// How far a level got, as bands of the time line: from where a stage was reached to the next one, or to the end of
// the level. No page is needed for it.
/** @import { Moments } from "../server_data.d.ts" */
import { SAME_S } from "./rows.js";

/** @typedef {{stage: number, from: number, to: number}} Band stages from 0, or BEFORE; times in [s] */

export const BEFORE = -1; // what comes before the first stage of a level

/**
 * newest: time up to which there are rows [s]; length: most that a level takes [s], where the newest one may not be
 * known yet
 * @param {Pick<Moments, "levels" | "stages">} moments
 * @param {number} newest
 * @param {number} [length]
 * @returns {Band[]}
 */
export function bandsOf({ levels, stages = [] }, newest, length = Infinity) {
  const found = levels.flatMap(({ t: begin }, number) => {
    const end = Math.min(begin + length, levels[number + 1]?.t ?? newest, newest);
    const reached = stages.filter(({ t }) => t >= begin && t < end);
    return reached.map(({ stage, t }, index) => ({ stage, from: t, to: reached[index + 1]?.t ?? end }));
  });
  return found.filter(({ from, to }) => to > from); // of two at once, the later stage counts
}

/**
 * The same, and before the first stage of each level, or in all of it, a band of what it takes to get there.
 * @param {Pick<Moments, "levels" | "stages">} moments
 * @param {number} newest
 * @param {number} [length]
 * @returns {Band[]}
 */
export function bandsFromStart(moments, newest, length = Infinity) {
  const found = bandsOf(moments, newest, length);
  const before = moments.levels.map(({ t: from }, number) => {
    const end = Math.min(from + length, moments.levels[number + 1]?.t ?? newest, newest);
    return { stage: BEFORE, from, to: found.find((band) => band.from >= from && band.from < end)?.from ?? end };
  });
  return [...before.filter(({ from, to }) => to > from), ...found];
}

/**
 * The band at a time; undefined where no stage was reached yet.
 * @param {Band[]} bands
 * @param {number} t
 */
export const bandAt = (bands, t) => bands.find(({ from, to }) => t >= from - SAME_S && t < to - SAME_S);

/**
 * The parts of bands between two times, counted from the first of these.
 * @param {Band[]} bands
 * @param {number} start
 * @param {number} end
 * @returns {Band[]}
 */
export function within(bands, start, end) {
  const cut = bands.map(({ stage, from, to }) => ({
    stage,
    from: Math.max(from, start) - start,
    to: Math.min(to, end) - start,
  }));
  return cut.filter(({ from, to }) => to > from);
}

/**
 * The colour of a stage, as a custom property.
 * @param {number} stage
 */
export const stageColour = (stage) => `--stage-${(stage % 6) + 1}`;
