// The vehicles of all runs in one scene: the first run is followed, the others are ghosts.
import { Memory } from "../player/memory.js";
import { Rows, rowColumns } from "../player/rows.js";
import { SceneBox } from "../player/scene_box.js";

const TRAIL_S = 20; // of simulated time at speed 1

export class Ghosts {
  constructor(root, data, playhead) {
    this.playhead = playhead;
    this.box = root.querySelector("[data-scene]");
    this.note = this.box.querySelector("[data-scene-note]");
    this.runs = data.runs.map(({ api, columns }) => ({ rows: new Rows(api, rowColumns(columns)), part: null }));
    // The names in the scene have the colours of the dark theme: the water is dark in both.
    const colours = [...this.box.querySelectorAll("[data-vehicle]")].map((name) => getComputedStyle(name).color);
    const [followed, ...others] = data.runs.map(({ api }, index) => ({ api, colour: colours[index] }));
    const memory = new Memory("compare");
    memory.set("view", memory.get("view", "all"));
    this.scene = new SceneBox(this.box, followed, memory, others);
    for (const { rows } of this.runs) rows.onRows = () => this.show();
    playhead.listen(() => this.show());
  }

  // The part of each run that is compared: its trial, start and end.
  setParts(series, trial) {
    series.forEach(({ run, start_s: start, t }, index) => {
      this.runs[index].part = start === null ? null : { trial, start, length: t[t.length - 1] };
      if (!index && start === null)
        this.note.textContent = `The scene follows run ${run}, which has no telemetry here.`;
    });
    this.show();
  }

  show() {
    const [followed, ...others] = this.runs.map((run) => this.moment(run));
    if (!followed) return;
    const { trial, t } = this.playhead;
    this.scene.show({ trial, t }, followed.found, followed.trail, others);
  }

  // Where the vehicle of a run is at the playhead, and its trail; null while that is unknown.
  moment({ rows, part }) {
    if (!part) return null;
    const { speed, playing } = this.playhead;
    const { trial, start, length } = part;
    const t = start + Math.min(this.playhead.t, length);
    rows.want({ trial, t, speed, playing, following: false, newest: start + length });
    const found = rows.at(trial, t);
    return found && { found, trail: () => rows.before(trial, t, TRAIL_S * Math.max(speed, 1)) };
  }
}
