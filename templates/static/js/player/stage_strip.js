// The stages of a trial above the slider of the player: what a band means is said where one points at it or taps it.
/**
 * @import { Moments } from "../server_data.d.ts"
 * @import { Band } from "./stages.js"
 */
import { clockText } from "./formatting.js";
import { bandsFromStart, bandsOf, stageColour } from "./stages.js";

const SAID_MS = 4000; // after a tap

export class StageStrip {
  /**
   * labels: of the stages; before: what comes before the first one, if it is shown; duration: of the strip [s]
   * @param {HTMLElement} strip
   * @param {{labels: string[], before?: string | null, duration: number, onSeek: (t: number) => void}} options
   */
  constructor(strip, { labels, before = null, duration, onSeek }) {
    this.strip = strip;
    this.labels = labels;
    this.before = before;
    this.duration = duration;
    this.onSeek = onSeek;
    this.shown = ""; // in short, so that the same bands are not made again under a finger
    this.note = document.createElement("span");
    this.note.className = "stage-note";
    this.note.hidden = true;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.timer = undefined;
    strip.addEventListener("pointerleave", ({ pointerType }) => {
      if (pointerType === "mouse") this.hush();
    });
  }

  /**
   * The bands of a trial; see `bandsOf`.
   * @param {Pick<Moments, "levels" | "stages">} moments
   * @param {number} newest
   * @param {number} [length]
   * @returns {Band[]}
   */
  bands(moments, newest, length) {
    return (this.before ? bandsFromStart : bandsOf)(moments, newest, length);
  }

  /** @param {Band[]} bands */
  show(bands) {
    const shown = JSON.stringify([this.duration, bands]);
    if (shown === this.shown) return;
    this.shown = shown;
    this.strip.replaceChildren(...bands.map((band) => this.made(band)), this.note);
  }

  /** @param {Band} band */
  made(band) {
    const { stage, from, to } = band;
    const made = document.createElement("i");
    made.dataset.stage = String(stage);
    made.style.background = `var(${stageColour(stage)})`;
    made.style.left = `${(100 * from) / this.duration}%`;
    made.style.width = `${(100 * (to - from)) / this.duration}%`;
    made.addEventListener("pointerenter", () => this.say(band));
    made.addEventListener("click", () => {
      this.say(band);
      this.onSeek(from);
    });
    return made;
  }

  /** @param {Band} band */
  say({ stage, from, to }) {
    this.note.textContent = `${this.labels[stage] ?? this.before}: ${clockText(from)}`;
    this.note.hidden = false;
    const middle = (from + to) / 2 / this.duration;
    // Within the strip, whose ends it would else pass.
    this.note.style.left = `${100 * middle}%`;
    this.note.style.transform = `translateX(${-100 * middle}%)`;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.hush(), SAID_MS);
  }

  hush() {
    this.note.hidden = true;
  }
}
