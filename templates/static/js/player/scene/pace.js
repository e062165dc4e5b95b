// The resolution that the machine can keep up with: fewer pixels if pictures of a scene that moves take
// long, more again if there is time.

const SLOW_MS = 45; // longer between two pictures: fewer pixels
const FAST_MS = 24;
const PASSED_MAX_MS = 2000;
const SETTLE_PICTURES = 5; // measured before the resolution changes
const SETTLE_MS = 1000; // after a change; each costs as much as several pictures
const SCALE_MIN = 0.35;
const GROWTH = 1.35; // of the scale: what took less than FAST_MS then takes less than SLOW_MS

export class Pace {
  /** @param {number} scale */
  constructor(scale) {
    this.scale = scale;
    this.at = 0; // of the last picture [ms]
    this.mean = 30; // between two pictures [ms]
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
    const { mean } = this;
    // The time for a picture goes with its pixels, the square of the scale.
    const factor = mean > SLOW_MS ? Math.max(Math.sqrt(SLOW_MS / mean), 0.6) : mean < FAST_MS ? GROWTH : 1;
    const scale = Math.min(Math.max(this.scale * factor, SCALE_MIN), 1);
    if (Math.abs(scale - this.scale) < 0.01) return false;
    this.scale = scale;
    this.count = 0;
    this.resized = now;
    return true;
  }
}
