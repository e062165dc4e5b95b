// The map of each run's level at the time of the playhead.
/**
 * @import { CompareData, ComparedSeries, Moments, SceneData } from "../server_data.d.ts"
 * @import { Playhead } from "../player/playhead.js"
 * @import { Part } from "./cameras.js"
 */
import { mapIn } from "../player/level_map.js";

export class ComparedMaps {
  /**
   * @param {CompareData} data
   * @param {Playhead} playhead
   */
  constructor(data, playhead) {
    this.playhead = playhead;
    /** @type {{map: ReturnType<typeof mapIn>, part: Part | null}[]} */
    this.runs = data.runs.map(({ id, api }) => ({
      map: mapIn(document, `run-${id}`, { api, scene: sceneFrom(api) }),
      part: null,
    }));
    playhead.listen(() => this.show());
  }

  /**
   * The part of each run that is compared: its trial, start and end.
   * @param {ComparedSeries[]} series
   * @param {number} trial
   */
  setParts(series, trial) {
    series.forEach(({ start_s: start, t }, index) => {
      this.runs[index].part = start === null ? null : { trial, start, length: t[t.length - 1] };
    });
    this.show();
  }

  /**
   * @param {number} index of the run
   * @param {Moments} moments
   */
  setMoments(index, moments) {
    this.runs[index].map?.setMoments(moments);
  }

  show() {
    for (const { map, part } of this.runs)
      if (part) map?.show({ trial: part.trial, t: part.start + Math.min(this.playhead.t, part.length) });
      else map?.hide("This run has no telemetry here.");
  }
}

/**
 * @param {string} api
 * @returns {(trial: number, level: number) => Promise<SceneData | null>}
 */
function sceneFrom(api) {
  return async (trial, level) => {
    const response = await fetch(`${api}/scene.json?trial=${trial}&level=${level}`);
    return response.ok ? response.json() : null;
  };
}
