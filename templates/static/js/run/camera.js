// The camera image: follows a live run, and replays any time at any speed. There is one request at a
// time; of the images requested in the meantime, only the last is loaded.

const LIVE_INTERVAL_MS = 400; // minimum time between two images of a live run
const VIEWER_INTERVAL_MS = 20; // the more viewers a run has, the less often each asks for an image

export class Camera {
  constructor(data, onTime, levelAt) {
    this.data = data;
    this.onTime = onTime;
    this.levelAt = levelAt;
    const box = document.querySelector("[data-camera]");
    this.image = box.querySelector("img");
    this.note = box.querySelector("[data-camera-note]");
    this.slider = document.querySelector("[data-time]");
    this.button = document.querySelector("[data-play]");
    this.speed = document.querySelector("[data-speed]");
    this.clock = document.querySelector("[data-camera-time]");
    this.slider.max = String(data.trial_s);
    this.slider.step = String(data.step_s);
    this.trial = 0;
    this.newest = 0;
    this.t = 0;
    this.pending = null;
    this.busy = false;
    this.following = data.live;
    this.playing = false;
    this.viewers = 1;
    this.slider.addEventListener("input", () => {
      this.following = false;
      this.seek(Number(this.slider.value));
    });
    this.button.addEventListener("click", () => this.toggle());
  }

  // Called when telemetry of a trial is available up to time `t`.
  available(trial, t) {
    if (trial !== this.trial) this.t = 0;
    this.trial = trial;
    this.newest = t;
    this.slider.disabled = this.button.disabled = false;
    if (this.following) this.show(t);
    else if (this.image.hidden) this.show(this.t);
  }

  ended() {
    this.following = false;
  }

  seek(t) {
    this.following = false;
    this.show(Math.min(t, this.newest));
  }

  toggle() {
    this.playing = !this.playing;
    this.following = false;
    this.button.setAttribute("aria-pressed", String(this.playing));
    this.button.querySelector("[data-label]").textContent = this.playing ? "Pause" : "Play";
    if (!this.playing) return;
    if (this.t >= this.newest - this.data.step_s) this.t = 0;
    this.before = performance.now();
    requestAnimationFrame((now) => this.advance(now));
  }

  advance(now) {
    if (!this.playing) return;
    const passed = (now - this.before) / 1000;
    this.before = now;
    this.show(Math.min(this.t + passed * Number(this.speed.value), this.newest));
    if (this.t >= this.newest) this.toggle();
    else requestAnimationFrame((next) => this.advance(next));
  }

  show(t) {
    this.t = t;
    this.slider.value = String(t);
    this.slider.setAttribute("aria-valuetext", `${t.toFixed(1)} seconds`);
    const { label, unit } = this.data.level;
    const level = this.levelAt(Math.floor(t / this.data.level_s + 1e-9));
    let levelText = "";
    if (level !== null) levelText = this.data.names.length ? `, level ${level}: ${this.data.names[level]}` : `, ${label.toLowerCase()} ${this.data.levels[level]} ${unit}`;
    this.clock.textContent = `${t.toFixed(1)} s${levelText}`.trimEnd();
    this.onTime(t);
    this.pending = { trial: this.trial, t };
    if (!this.busy) this.load();
  }

  async load() {
    this.busy = true;
    while (this.pending) {
      const { trial, t } = this.pending;
      this.pending = null;
      const next = new Image();
      next.src = `${this.data.api}/camera.jpg?trial=${trial}&t=${t.toFixed(2)}`;
      try {
        await next.decode();
        this.image.src = next.src;
        this.image.hidden = false;
        this.note.hidden = true;
      } catch {
        this.note.textContent = "No image is available at this time.";
        this.note.hidden = !this.image.hidden;
      }
      const interval = Math.max(LIVE_INTERVAL_MS, VIEWER_INTERVAL_MS * this.viewers);
      if (this.following) await new Promise((done) => setTimeout(done, interval));
    }
    this.busy = false;
  }
}
