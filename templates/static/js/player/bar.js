// The player bar: play and pause, the slider, speed, and jumps. It works by keyboard alone.
import { clockText } from "./formatting.js";

const STEP_S = 1;
const LEAP_S = 10;
const LOST = "The target was never lost.";
const NEVER = {
  error: "No data yet.",
  "first-loss": LOST,
  "next-loss": LOST,
  touch: "The vehicle never touched anything.",
};

export class Bar {
  // levelText: row -> what the level is called; moments: () -> promise of moments.json;
  // keys: {key: action} beside its own
  constructor(root, playhead, { levelLength, levelText, moments, step, fullScreen, keys }) {
    Object.assign(this, { root, playhead, levelLength, levelText, moments, step, fullScreen, keys });
    const parts = new Map();
    this.part = (name) => parts.get(name) ?? parts.set(name, root.querySelector(`[data-${name}]`)).get(name);
    this.slider = this.part("time");
    this.slider.max = String(playhead.duration);
    this.slider.step = String(step);
    this.slider.addEventListener("input", () => playhead.seek(Number(this.slider.value)));
    this.part("play").addEventListener("click", () => playhead.toggle());
    this.part("follow")?.addEventListener("click", () => playhead.follow());
    this.part("speed").addEventListener("change", (event) => playhead.setSpeed(Number(event.target.value)));
    this.part("jump").addEventListener("change", (event) => this.jump(event.target));
    document.addEventListener("keydown", (event) => this.onKey(event));
  }

  show({ t, newest, playing, following, live, speed }, row) {
    this.slider.value = String(t);
    const text = this.timeText(t, row);
    this.slider.setAttribute("aria-valuetext", text);
    this.part("clock").textContent = text;
    const enabled = newest > 0;
    for (const name of ["play", "time", "jump"]) this.part(name).disabled = !enabled;
    const moving = playing || following;
    const button = this.part("play");
    if (button.dataset.moving !== String(moving)) {
      button.dataset.moving = String(moving);
      button.querySelector("[data-label]").textContent = moving ? "Pause" : "Play";
    }
    const follow = this.part("follow");
    if (follow) {
      follow.hidden = !live;
      follow.setAttribute("aria-pressed", String(following));
    }
    this.part("speed").value = String(speed);
  }

  timeText(t, row) {
    const level = row ? this.levelText(row) : "";
    return `${clockText(t)}${level ? `, ${level}` : ""}`;
  }

  tell(sentence) {
    this.part("jump-note").textContent = sentence;
  }

  async jump(select) {
    const wanted = select.value;
    select.value = "";
    const { t } = this.playhead;
    const length = this.levelLength;
    this.tell("");
    if (wanted === "next-level") this.playhead.seek((Math.floor(t / length + 1e-6) + 1) * length);
    else if (wanted === "previous-level") this.playhead.seek(Math.max(Math.ceil(t / length - 1e-6) - 1, 0) * length);
    else {
      const found = await this.moments();
      const losses = found?.losses ?? [];
      const touches = found?.touches ?? [];
      const after = (times) => times.find((time) => time > t + this.step / 2) ?? times[0];
      const targets = {
        error: found?.largest_error?.t,
        "next-loss": after(losses),
        "first-loss": losses[0],
        touch: after(touches),
      };
      const target = targets[wanted];
      if (Number.isFinite(target)) this.playhead.seek(target);
      else this.tell(NEVER[wanted]);
    }
  }

  onKey(event) {
    const { target, key, ctrlKey, metaKey, altKey } = event;
    if (
      ctrlKey ||
      metaKey ||
      altKey ||
      target.closest("input, select, textarea, summary, dialog[open], [contenteditable], .table-wrap, .log")
    )
      return;
    const { playhead } = this;
    const inControl = target.closest("button, a, canvas");
    const seek = (seconds) => playhead.seek(playhead.t + seconds);
    const actions = {
      " ": () => playhead.toggle(),
      k: () => playhead.toggle(),
      f: () => this.fullScreen.toggle(),
      j: () => seek(-LEAP_S),
      l: () => seek(LEAP_S),
      ",": () => seek(-this.step),
      ".": () => seek(this.step),
      ArrowLeft: () => seek(-STEP_S),
      ArrowRight: () => seek(STEP_S),
      Home: () => playhead.seek(0),
      End: () => playhead.seek(playhead.newest),
      ...this.keys,
    };
    if (!(key in actions) || (inControl && (key === " " || key.startsWith("Arrow")))) return;
    event.preventDefault();
    actions[key]();
  }
}
