// The playhead: which trial and time is shown, and how it moves. It knows no page and no clock;
// camera, scene, charts and numbers listen to it, so they always show the same moment.

export const SPEEDS = [0.25, 0.5, 1, 2, 5, 10, 20, 60];

/**
 * What a reload resumes.
 * @typedef {{trial: number, t: number, speed: number, playing: boolean, following: boolean}} PlayheadState
 */

export class Playhead {
  /**
   * duration: of a trial [s]; live: whether rows still arrive; loop: start again at the end
   * @param {{duration: number, live?: boolean, loop?: boolean}} options
   */
  constructor({ duration, live = false, loop = false }) {
    this.duration = duration;
    this.live = live;
    this.loop = loop;
    this.trial = 0;
    this.t = 0;
    this.newest = 0;
    this.speed = 1;
    this.playing = false;
    this.following = live;
    /** @type {((playhead: Playhead, what: "time" | "mode") => void)[]} */
    this.listeners = [];
  }

  /**
   * Calls `listener(playhead, what)` at once and after every change; `what` is "time" or "mode".
   * @param {(playhead: Playhead, what: "time" | "mode") => void} listener
   */
  listen(listener) {
    this.listeners.push(listener);
    listener(this, "mode");
  }

  /** @param {"time" | "mode"} what */
  changed(what) {
    for (const listener of this.listeners) listener(this, what);
  }

  /**
   * Telemetry of the trial that is shown exists up to time `t` [s].
   * @param {number} t
   */
  available(t) {
    this.newest = Math.max(this.newest, t);
    if (this.following) this.moveTo(this.newest);
    else this.changed("time");
  }

  // No more telemetry will arrive; what plays goes on to the end.
  end() {
    this.live = this.following = false;
    this.changed("mode");
  }

  /** @param {number} trial */
  setTrial(trial) {
    if (trial === this.trial) return;
    this.trial = trial;
    this.t = this.newest = 0;
    this.changed("mode");
  }

  /** @param {number} t */
  moveTo(t) {
    this.t = Math.min(Math.max(t, 0), this.newest);
    this.changed("time");
  }

  /** @param {number} t */
  seek(t) {
    const followed = this.following;
    this.following = false;
    this.moveTo(t);
    if (followed) this.changed("mode");
  }

  play() {
    const ended = !this.live && this.t >= this.newest;
    this.playing = true;
    this.following = false;
    if (ended) this.moveTo(0);
    this.changed("mode");
  }

  pause() {
    this.playing = this.following = false;
    this.changed("mode");
  }

  toggle() {
    if (this.playing || this.following) this.pause();
    else this.play();
  }

  // Shows the newest data of a live run as they arrive.
  follow() {
    if (!this.live) return;
    this.playing = false;
    this.following = true;
    this.moveTo(this.newest);
    this.changed("mode");
  }

  /** @param {number} speed */
  setSpeed(speed) {
    this.speed = speed;
    this.changed("mode");
  }

  /**
   * Moves on by `seconds` of wall time. At the newest data of a live run it waits for more, and nobody is told
   * meanwhile: there is nothing new to draw.
   * @param {number} seconds
   */
  advance(seconds) {
    if (!this.playing) return;
    const next = this.t + seconds * this.speed;
    if (next < this.newest) this.moveTo(next);
    else if (this.live) {
      if (this.t < this.newest) this.moveTo(this.newest);
    } else if (this.loop) this.moveTo(0);
    else {
      this.playing = false;
      this.moveTo(this.newest);
      this.changed("mode");
    }
  }

  /** @returns {PlayheadState} */
  state() {
    const { trial, t, speed, playing, following } = this;
    return { trial, t, speed, playing, following };
  }

  /**
   * Continues from an earlier `state`, as far as it is valid here.
   * @param {Partial<Record<keyof PlayheadState, unknown>>} state
   */
  restore({ trial, t, speed, playing, following }) {
    if (typeof trial === "number" && Number.isInteger(trial) && trial >= 0) this.trial = trial;
    if (typeof speed === "number" && SPEEDS.includes(speed)) this.speed = speed;
    this.playing = playing === true;
    this.following = this.live && following !== false && !this.playing;
    if (typeof t === "number" && Number.isFinite(t) && !this.following) {
      this.t = Math.min(Math.max(t, 0), this.duration);
      this.newest = Math.max(this.newest, this.t); // until it is known how far the data reach
    }
    this.changed("mode");
  }

  /**
   * The data of the trial reach to `t`, which may be less than `restore` believed.
   * @param {number} t
   */
  reaches(t) {
    this.newest = t;
    if (this.following || this.t > t) this.moveTo(t);
    else this.changed("time");
  }
}
