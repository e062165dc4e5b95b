// The vehicle's picture: the newest while the run goes on, any time and any speed afterwards. One
// request at a time; a wish that came meanwhile replaces the one before it.

const LIVE_PAUSE_MS = 400; // between two pictures of a running run

export class Camera {
  constructor(data, onTime) {
    this.data = data;
    this.onTime = onTime;
    const box = document.querySelector("[data-camera]");
    this.image = box.querySelector("img");
    this.note = box.querySelector("[data-camera-note]");
    this.slider = document.querySelector("[data-time]");
    this.button = document.querySelector("[data-play]");
    this.speed = document.querySelector("[data-speed]");
    this.clock = document.querySelector("[data-camera-time]");
    this.slider.max = String(data.trial_s);
    this.slider.step = String(data.tick_s);
    this.trial = 0;
    this.newest = 0;
    this.t = 0;
    this.wish = null;
    this.busy = false;
    this.following = data.live;
    this.playing = false;
    this.slider.addEventListener("input", () => {
      this.following = false;
      this.seek(Number(this.slider.value));
    });
    this.button.addEventListener("click", () => this.toggle());
  }

  // Telemetry reaches up to `t` of a trial.
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
    if (this.t >= this.newest - this.data.tick_s) this.t = 0;
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
    const level = Math.min(Math.floor(t / this.data.level_s), this.data.levels.length - 1);
    const named = this.data.names.length ? `level ${level}: ${this.data.names[level]}` : `${label.toLowerCase()} ${this.data.levels[level]} ${unit}`;
    this.clock.textContent = `${t.toFixed(1)} s, ${named}`.trimEnd();
    this.onTime(t);
    this.wish = { trial: this.trial, t };
    if (!this.busy) this.load();
  }

  async load() {
    this.busy = true;
    while (this.wish) {
      const { trial, t } = this.wish;
      this.wish = null;
      const next = new Image();
      next.src = `${this.data.api}/camera.jpg?trial=${trial}&t=${t.toFixed(2)}`;
      try {
        await next.decode();
        this.image.src = next.src;
        this.image.hidden = false;
        this.note.hidden = true;
      } catch {
        this.note.textContent = "There is no picture of this time.";
        this.note.hidden = !this.image.hidden;
      }
      if (this.following) await new Promise((done) => setTimeout(done, LIVE_PAUSE_MS));
    }
    this.busy = false;
  }
}
