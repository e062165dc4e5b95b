// How long a run still takes, and how that is written. It may count down, but must not jump: what was
// expected before counts most, and what is measured corrects it bit by bit.

const WARM_UP_S = 3; // until then the pace of a run says nothing
const TRUST_PER_S = 0.03; // how fast the measured pace gets its weight

/** @param {number} seconds */
export function duration(seconds) {
  if (seconds < 9.95) return `${seconds.toFixed(1)} s`;
  if (seconds < 59.5) return `${Math.round(seconds)} s`;
  const minutes = Math.floor(Math.round(seconds) / 60);
  const rest = Math.round(seconds) % 60;
  if (minutes < 60) return rest ? `${minutes} min ${rest} s` : `${minutes} min`;
  return minutes % 60 ? `${Math.floor(minutes / 60)} h ${minutes % 60} min` : `${Math.floor(minutes / 60)} h`;
}

/**
 * As precisely as an estimate deserves.
 * @param {number} seconds
 */
export function about(seconds) {
  if (seconds < 55) return `${Math.max(5, 5 * Math.round(seconds / 5))} s`;
  const minutes = Math.max(1, Math.round(seconds / 60));
  return duration(60 * (minutes < 60 ? minutes : 5 * Math.round(minutes / 5)));
}

export class Estimate {
  /**
   * left: what the server expects [s], NaN if it does not know
   * @param {number} [left]
   */
  constructor(left = NaN) {
    this.left = left;
    /** @type {{progress: number, now: number} | null} */
    this.first = null;
    /** @type {number | null} */
    this.last = null;
  }

  /**
   * Takes the progress (0 to 1) at a time [s] into account; returns the time left [s], NaN if unknown.
   * @param {number} progress
   * @param {number} now
   */
  update(progress, now) {
    this.first ??= { progress, now };
    const passed = this.last === null ? 0 : now - this.last;
    this.last = now;
    this.left = Math.max(this.left - passed, 0);
    const watched = now - this.first.now;
    const gained = progress - this.first.progress;
    if (watched < WARM_UP_S || gained <= 0) return this.left;
    const measured = (watched * (1 - progress)) / gained;
    if (Number.isNaN(this.left)) this.left = measured;
    else this.left += Math.min(TRUST_PER_S * passed, 1) * (measured - this.left);
    return this.left;
  }
}
