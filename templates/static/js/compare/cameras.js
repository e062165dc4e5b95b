// The camera of each run at the time of the playhead.
/**
 * @import { CompareData, ComparedSeries } from "../server_data.d.ts"
 * @import { Playhead } from "../player/playhead.js"
 */
import { need } from "../dom.js";
import { Camera } from "../player/camera.js";

const STEP_S = 0.05; // of telemetry: between two images there is no other one

/** @typedef {{trial: number, start: number, length: number}} Part of a run that is compared */

export class Cameras {
  /**
   * @param {CompareData} data
   * @param {Playhead} playhead
   */
  constructor(data, playhead) {
    /** @type {{camera: Camera, part: Part | null | undefined, shown: string}[]} undefined until it is known */
    this.views = data.runs.map(({ id, api }) => {
      const box = need(document, `[data-view="${id}"]`, HTMLElement);
      return { camera: new Camera(box, { api, step: STEP_S }), part: undefined, shown: "" };
    });
    this.playhead = playhead;
    playhead.listen(() => this.show());
  }

  /**
   * The part of each run that is compared: its trial, start and end.
   * @param {ComparedSeries[]} series
   * @param {number} trial
   */
  setParts(series, trial) {
    series.forEach(({ start_s: start, t }, index) => {
      this.views[index].part = start === null ? null : { trial, start, length: t[t.length - 1] };
    });
    this.show();
  }

  show() {
    for (const view of this.views) {
      if (view.part) this.showView(view, view.part);
      else if (view.part === null) view.camera.tell("This run has no telemetry here.");
    }
  }

  /**
   * @param {{camera: Camera, shown: string}} view
   * @param {Part} part
   */
  showView(view, { trial, start, length }) {
    const t = start + Math.min(this.playhead.t, length);
    const key = `${trial}:${Math.floor(t / STEP_S + 1e-6)}`;
    if (key === view.shown) return;
    view.shown = key;
    view.camera.show({ trial, t, following: false }, null);
  }
}
