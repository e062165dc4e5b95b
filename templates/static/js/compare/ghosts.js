// The vehicles of all runs in one scene: the first run is followed, the others are ghosts.
/**
 * @import { CompareData, ComparedSeries } from "../server_data.d.ts"
 * @import { Playhead } from "../player/playhead.js"
 * @import { Shown } from "../player/scene_box.js"
 * @import { Part } from "./cameras.js"
 */
import { all, need } from "../dom.js";
import { Memory } from "../player/memory.js";
import { Rows, rowColumns } from "../player/rows.js";
import { SceneBox } from "../player/scene_box.js";

const TRAIL_S = 20; // of simulated time at speed 1

export class Ghosts {
  /**
   * @param {HTMLElement} root
   * @param {CompareData} data
   * @param {Playhead} playhead
   */
  constructor(root, data, playhead) {
    this.playhead = playhead;
    this.box = need(root, "[data-scene]", HTMLElement);
    this.note = need(this.box, "[data-scene-note]", HTMLElement);
    /** @type {{rows: Rows, part: Part | null}[]} */
    this.runs = data.runs.map(({ api, columns }) => ({ rows: new Rows(api, rowColumns(columns)), part: null }));
    // The names in the scene have the colours of the dark theme: the water is dark in both.
    const colours = all(this.box, "[data-vehicle]", HTMLElement).map((name) => getComputedStyle(name).color);
    const [followed, ...others] = data.runs.map(({ api }, index) => ({ api, colour: colours[index] }));
    const memory = new Memory("compare");
    memory.set("view", memory.get("view", "all"));
    this.scene = new SceneBox(this.box, followed, memory, others);
    for (const { rows } of this.runs) rows.onRows = () => this.show();
    playhead.listen(() => this.show());
  }

  /**
   * The part of each run that is compared: its trial, start and end.
   * @param {ComparedSeries[]} series
   * @param {number} trial
   */
  setParts(series, trial) {
    series.forEach(({ run, start_s: start, t }, index) => {
      this.runs[index].part = start === null ? null : { trial, start, length: t[t.length - 1] };
      const lacks = !index && start === null;
      if (lacks) this.note.textContent = `The scene follows run ${run}, which has no telemetry here.`;
    });
    this.show();
  }

  show() {
    const [followed, ...others] = this.runs.map((run) => this.moment(run));
    if (!followed) return;
    const { trial, t } = this.playhead;
    this.scene.show({ trial, t }, followed.instant, followed.trail, others);
  }

  /**
   * Where the vehicle of a run is at the playhead, and its trail; null while that is unknown.
   * @param {{rows: Rows, part: Part | null}} run
   * @returns {Shown | null}
   */
  moment({ rows, part }) {
    if (!part) return null;
    const { speed, playing } = this.playhead;
    const { trial, start, length } = part;
    const t = start + Math.min(this.playhead.t, length);
    rows.want({ trial, t, speed, playing, following: false, newest: start + length });
    const instant = rows.at(trial, t);
    return instant && { instant, trail: () => rows.before(trial, t, TRAIL_S * Math.max(speed, 1)) };
  }
}
