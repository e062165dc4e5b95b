// The resolution that the machine can keep up with: fewer pixels if pictures of a scene that moves take
// long, more again if there is time.

const SLOW_MS = 45;
const FAST_MS = 24;
const SLACK = 1.5;
const PASSED_MAX_MS = 2000;
const SETTLE_PICTURES = 5; // measured before the resolution changes
const SETTLE_MS = 1000; // after a change; each costs as much as several pictures
const SCALE_MIN = 0.35;
const GROWTH = 1.35; // of the scale: what took less than FAST_MS then takes less than SLOW_MS

export class Pace {
  /**
   * every: no more often than after so many ms are pictures drawn, and with no more pixels than at first; 0: as
   * often as the screen shows one
   * @param {number} scale
   * @param {number} [every]
   */
  constructor(scale, every = 0) {
    this.scale = scale;
    this.most = every ? scale : 1;
    this.slow = Math.max(SLOW_MS, SLACK * every); // longer between two pictures: fewer pixels
    this.fast = every ? (1 + SLACK) * 0.5 * every : FAST_MS; // shorter: more
    this.at = 0; // of the last picture [ms]
    this.mean = every || 30; // between two pictures [ms]
    this.count = 0; // of pictures since the last change
    this.moved = false;
    this.resized = 0;
  }

  /**
   * A picture is drawn at `now` [ms]; returns whether the scale has changed.
   * @param {number} now
   * @param {boolean} moves
   */
  drawn(now, moves) {
    const passed = Math.min(now - this.at, PASSED_MAX_MS);
    const measures = moves && this.moved;
    this.at = now;
    this.moved = moves;
    if (!measures) return false;
    this.mean += (passed - this.mean) / SETTLE_PICTURES;
    this.count += 1;
    if (this.count < SETTLE_PICTURES || now - this.resized < SETTLE_MS) return false;
    const { mean, slow, fast, most } = this;
    // The time for a picture goes with its pixels, the square of the scale.
    const factor = mean > slow ? Math.max(Math.sqrt(slow / mean), 0.6) : mean < fast ? GROWTH : 1;
    const scale = Math.min(Math.max(this.scale * factor, SCALE_MIN), most);
    if (Math.abs(scale - this.scale) < 0.01) return false;
    this.scale = scale;
    this.count = 0;
    this.resized = now;
    return true;
  }
}
