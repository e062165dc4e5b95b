// Where target or route was lost, where the hull first touched something, where levels change, stages were reached and
// routes completed: on the time line, and for the charts. Of a live run they are asked for again from time to time.
/**
 * @import { Moments } from "../server_data.d.ts"
 * @import { StageStrip } from "./stage_strip.js"
 */
import { need } from "../dom.js";

const AGAIN_MS = 30_000; // each request reads the whole trial
const STAGES_AGAIN_MS = 5_000; // a level takes seconds, and one waits for its next stage
/** @type {Moments} */
export const NONE = { levels: [], losses: [], touches: [], largest_error: null };

export class Marks {
  /**
   * strip: the element above which they are drawn; legend: of the charts; duration: of the strip [s]; level: length of
   * one [s]; stages: where they are shown, null if there are none
   * @param {HTMLElement} strip
   * @param {HTMLElement} legend
   * @param {{api: string, duration: number, level: number, stages: StageStrip | null}} run
   */
  constructor(strip, legend, { api, duration, level, stages }) {
    this.strip = strip;
    this.legend = legend;
    this.api = api;
    this.duration = duration;
    this.moments = NONE;
    this.level = level;
    this.stages = stages;
    this.again = stages ? STAGES_AGAIN_MS : AGAIN_MS;
    this.newest = 0; // of the rows [s]
    /** @type {number | null} */
    this.trial = null;
    this.asked = -Infinity;
    /** @type {(moments: Moments) => void} */
    this.onChange = () => {};
  }

  /**
   * Returns the moments of a trial as they are now; null if they could not be read.
   * @param {number} trial
   * @returns {Promise<Moments | null>}
   */
  async load(trial) {
    this.asked = performance.now();
    this.trial = trial;
    const response = await fetch(`${this.api}/moments.json?trial=${trial}`);
    if (!response.ok || trial !== this.trial) return null;
    this.moments = await response.json();
    this.draw();
    this.onChange(this.moments);
    return this.moments;
  }

  /**
   * Loads them if the trial is another one, or if a live run has gone on.
   * @param {{trial: number, live: boolean, newest: number}} playhead
   */
  want({ trial, live, newest }) {
    this.newest = newest;
    this.stages?.show(this.bands());
    if (!newest) return;
    const old = live && performance.now() - this.asked > this.again;
    if (trial !== this.trial || old) this.load(trial);
  }

  clear() {
    this.moments = NONE;
    this.trial = null;
    this.draw();
    this.onChange(NONE);
  }

  draw() {
    const { levels, losses, touches, completed = [] } = this.moments;
    this.stages?.show(this.bands());
    /** @type {(kind: string) => (t: number) => HTMLElement} */
    const mark = (kind) => (t) => {
      const made = document.createElement("i");
      made.className = kind;
      made.style.left = `${(100 * t) / this.duration}%`;
      return made;
    };
    const changes = levels.map(({ t }) => t).filter((t) => t > 0);
    this.strip.replaceChildren(
      ...changes.map(mark("change")),
      ...losses.map(mark("loss")),
      ...touches.map(mark("touch")),
      ...completed.map(mark("completed")),
    );
    const kinds = Object.entries({ loss: losses, touch: touches, completed });
    this.legend.hidden = kinds.every(([, times]) => !times.length);
    for (const [kind, times] of kinds) need(this.legend, `.${kind}`, HTMLElement).hidden = !times.length;
  }

  bands() {
    return this.stages?.bands(this.moments, this.newest, this.level) ?? [];
  }
}
