// How far each run got in the part that is compared: one row of bands for each.
/**
 * @import { CompareData, ComparedSeries, Moments } from "../server_data.d.ts"
 * @import { Playhead } from "../player/playhead.js"
 */
import { maybe } from "../dom.js";
import { StageStrip } from "../player/stage_strip.js";
import { within } from "../player/stages.js";

export class ComparedStages {
  /**
   * onMoments: called with those of a run
   * @param {CompareData} data
   * @param {Playhead} playhead
   * @param {(index: number, moments: Moments) => void} onMoments
   */
  constructor(data, playhead, onMoments) {
    this.data = data;
    this.onMoments = onMoments;
    const onSeek = (/** @type {number} */ t) => playhead.seek(t);
    this.strips = data.runs.map(({ id, stages, before }) => {
      const strip = maybe(document, `[data-stages="${id}"]`, HTMLElement);
      return strip && new StageStrip(strip, { labels: stages, before, duration: data.trial_s, onSeek });
    });
    this.asked = 0;
  }

  /**
   * The part of each run that is compared.
   * @param {ComparedSeries[]} series
   * @param {number} trial
   * @param {number} longest of the parts [s]
   */
  async setParts(series, trial, longest) {
    const asked = ++this.asked;
    await Promise.all(
      series.map(async ({ start_s: start, t }, index) => {
        const strip = this.strips[index];
        if (!strip) return;
        const moments = start === null ? null : await this.moments(index, trial);
        if (asked !== this.asked) return;
        if (moments) this.onMoments(index, moments);
        strip.duration = longest;
        const end = (start ?? 0) + (t[t.length - 1] ?? 0);
        strip.show(moments ? within(strip.bands(moments, end), start ?? 0, end) : []);
      }),
    );
  }

  /**
   * @param {number} index of the run
   * @param {number} trial
   * @returns {Promise<Moments | null>}
   */
  async moments(index, trial) {
    const response = await fetch(`${this.data.runs[index].api}/moments.json?trial=${trial}`);
    return response.ok ? response.json() : null;
  }
}
