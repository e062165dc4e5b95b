// The playhead: which trial and time is shown, and how it moves. It knows no page and no clock;
// camera, scene, charts and numbers listen to it, so they always show the same moment.

export const SPEEDS = [0.25, 0.5, 1, 2, 5, 10, 20, 60];

export class Playhead {
  // duration: of a trial [s]; live: whether rows still arrive; loop: start again at the end
  constructor({ duration, live = false, loop = false }) {
    Object.assign(this, { duration, live, loop, trial: 0, t: 0, newest: 0, speed: 1, playing: false, following: live });
    this.listeners = [];
  }

  // Calls `listener(playhead, what)` at once and after every change; `what` is "time" or "mode".
  listen(listener) {
    this.listeners.push(listener);
    listener(this, "mode");
  }

  changed(what) {
    for (const listener of this.listeners) listener(this, what);
  }

  // Telemetry of the trial that is shown exists up to time `t` [s].
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

  setTrial(trial) {
    if (trial === this.trial) return;
    Object.assign(this, { trial, t: 0, newest: 0 });
    this.changed("mode");
  }

  moveTo(t) {
    this.t = Math.min(Math.max(t, 0), this.newest);
    this.changed("time");
  }

  seek(t) {
    const followed = this.following;
    this.following = false;
    this.moveTo(t);
    if (followed) this.changed("mode");
  }

  play() {
    const ended = !this.live && this.t >= this.newest;
    Object.assign(this, { playing: true, following: false });
    if (ended) this.moveTo(0);
    this.changed("mode");
  }

  pause() {
    Object.assign(this, { playing: false, following: false });
    this.changed("mode");
  }

  toggle() {
    if (this.playing || this.following) this.pause();
    else this.play();
  }

  // Shows the newest data of a live run as they arrive.
  follow() {
    if (!this.live) return;
    Object.assign(this, { playing: false, following: true });
    this.moveTo(this.newest);
    this.changed("mode");
  }

  setSpeed(speed) {
    this.speed = speed;
    this.changed("mode");
  }

  // Moves on by `seconds` of wall time. At the newest data of a live run it waits for more.
  advance(seconds) {
    if (!this.playing) return;
    const next = this.t + seconds * this.speed;
    if (next < this.newest) this.moveTo(next);
    else if (this.live) this.moveTo(this.newest);
    else if (this.loop) this.moveTo(0);
    else {
      this.playing = false;
      this.moveTo(this.newest);
      this.changed("mode");
    }
  }

  state() {
    const { trial, t, speed, playing, following } = this;
    return { trial, t, speed, playing, following };
  }

  // Continues from an earlier `state`, as far as it is valid here.
  restore({ trial, t, speed, playing, following }) {
    if (Number.isInteger(trial) && trial >= 0) this.trial = trial;
    if (SPEEDS.includes(speed)) this.speed = speed;
    this.playing = playing === true;
    this.following = this.live && following !== false && !this.playing;
    if (Number.isFinite(t) && !this.following) {
      this.t = Math.min(Math.max(t, 0), this.duration);
      this.newest = Math.max(this.newest, this.t); // until it is known how far the data reach
    }
    this.changed("mode");
  }

  // The data of the trial reach to `t`, which may be less than `restore` believed.
  reaches(t) {
    this.newest = t;
    if (this.following || this.t > t) this.moveTo(t);
    else this.changed("time");
  }
}
