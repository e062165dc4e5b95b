// The player bar: play and pause, the slider, speed, and jumps. It works by keyboard alone.
/**
 * @import { Moments, Row } from "../server_data.d.ts"
 * @import { FullScreen } from "./full_screen.js"
 * @import { Playhead } from "./playhead.js"
 */
import { around, maybe, need } from "../dom.js";
import { clockText } from "./formatting.js";

const STEP_S = 1;
const LEAP_S = 10;
const TYPING = "input, select, textarea, summary, dialog[open], [contenteditable], .table-wrap, .log";
const LOST = "The target was never lost.";
/** @type {Record<string, string>} */
const NEVER = {
  error: "No data yet.",
  "first-loss": LOST,
  "next-loss": LOST,
  touch: "The vehicle never touched anything.",
  stage: "No stage was reached.",
  completed: "The route was not completed.",
};

/**
 * @typedef {object} BarOptions
 * @property {number} levelLength [s]
 * @property {(row: Row) => string} levelText what the level of a row is called
 * @property {() => Promise<Moments | null>} moments of the trial
 * @property {number} step [s]
 * @property {FullScreen} fullScreen
 * @property {Record<string, () => void>} keys beside its own
 */

export class Bar {
  /**
   * @param {HTMLElement} root
   * @param {Playhead} playhead
   * @param {BarOptions} options
   */
  constructor(root, playhead, { levelLength, levelText, moments, step, fullScreen, keys }) {
    this.playhead = playhead;
    this.levelLength = levelLength;
    this.levelText = levelText;
    this.moments = moments;
    this.step = step;
    this.fullScreen = fullScreen;
    this.keys = keys;
    this.slider = need(root, "[data-time]", HTMLInputElement);
    this.playButton = need(root, "[data-play]", HTMLButtonElement);
    this.playLabel = need(this.playButton, "[data-label]", HTMLElement);
    this.follow = maybe(root, "[data-follow]", HTMLButtonElement);
    this.speed = need(root, "[data-speed]", HTMLSelectElement);
    this.jumps = need(root, "[data-jump]", HTMLSelectElement);
    this.clock = need(root, "[data-clock]", HTMLElement);
    this.note = need(root, "[data-jump-note]", HTMLElement);
    this.slider.max = String(playhead.duration);
    this.slider.step = String(step);
    this.slider.addEventListener("input", () => playhead.seek(Number(this.slider.value)));
    this.playButton.addEventListener("click", () => playhead.toggle());
    this.follow?.addEventListener("click", () => playhead.follow());
    this.speed.addEventListener("change", () => playhead.setSpeed(Number(this.speed.value)));
    this.jumps.addEventListener("change", () => this.jump(this.jumps));
    document.addEventListener("keydown", (event) => this.onKey(event));
  }

  /**
   * @param {Playhead} playhead
   * @param {Row | null} row
   */
  show({ t, newest, playing, following, live, speed }, row) {
    this.slider.value = String(t);
    const text = this.timeText(t, row);
    this.slider.setAttribute("aria-valuetext", text);
    this.clock.textContent = text;
    for (const control of [this.playButton, this.slider, this.jumps]) control.disabled = newest <= 0;
    const moving = playing || following;
    const button = this.playButton;
    if (button.dataset.moving !== String(moving)) {
      button.dataset.moving = String(moving);
      this.playLabel.textContent = moving ? "Pause" : "Play";
    }
    if (this.follow) {
      this.follow.hidden = !live;
      this.follow.setAttribute("aria-pressed", String(following));
    }
    this.speed.value = String(speed);
  }

  /**
   * @param {number} t
   * @param {Row | null} row
   */
  timeText(t, row) {
    const level = row ? this.levelText(row) : "";
    return `${clockText(t)}${level ? `, ${level}` : ""}`;
  }

  /** @param {string} sentence */
  tell(sentence) {
    this.note.textContent = sentence;
  }

  /** @param {HTMLSelectElement} select */
  async jump(select) {
    const wanted = select.value;
    const never = select.selectedOptions[0]?.dataset.never ?? NEVER[wanted];
    select.value = "";
    const { t } = this.playhead;
    const length = this.levelLength;
    this.tell("");
    if (wanted === "next-level") this.playhead.seek((Math.floor(t / length + 1e-6) + 1) * length);
    else if (wanted === "previous-level") this.playhead.seek(Math.max(Math.ceil(t / length - 1e-6) - 1, 0) * length);
    else {
      const moments = await this.moments();
      const losses = moments?.losses ?? [];
      const touches = moments?.touches ?? [];
      /** @type {(times: number[]) => number | undefined} */
      const after = (times) => times.find((time) => time > t + this.step / 2) ?? times[0];
      /** @type {Record<string, number | undefined>} */
      const targets = {
        error: moments?.largest_error?.t,
        "next-loss": after(losses),
        "first-loss": losses[0],
        touch: after(touches),
        completed: after(moments?.completed ?? []),
        stage: after((moments?.stages ?? []).map((reached) => reached.t)),
      };
      const target = targets[wanted];
      if (target !== undefined) this.playhead.seek(target);
      else this.tell(never);
    }
  }

  /** @param {KeyboardEvent} event */
  onKey(event) {
    const { target, key, ctrlKey, metaKey, altKey } = event;
    if (ctrlKey || metaKey || altKey || around(target, TYPING, Element)) return;
    const { playhead } = this;
    const inControl = around(target, "button, a, canvas", Element);
    /** @type {(seconds: number) => void} */
    const seek = (seconds) => playhead.seek(playhead.t + seconds);
    /** @type {Record<string, () => void>} */
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
