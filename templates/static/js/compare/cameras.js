// The camera of each run at the time of the playhead.
import { Camera } from "../player/camera.js";

const STEP_S = 0.05; // of telemetry: between two images there is no other one

export class Cameras {
  constructor(data, playhead) {
    this.views = data.runs.map(({ id, api }) => {
      const box = document.querySelector(`[data-view="${id}"]`);
      return { camera: new Camera(box, { api, step: STEP_S }), part: undefined, shown: "" };
    });
    this.playhead = playhead;
    playhead.listen(() => this.show());
  }

  // The part of each run that is compared: its trial, start and end.
  setParts(series, trial) {
    series.forEach(({ start_s: start, t }, index) => {
      this.views[index].part = start === null ? null : { trial, start, length: t[t.length - 1] };
    });
    this.show();
  }

  show() {
    for (const view of this.views) {
      if (view.part) this.showView(view);
      else if (view.part === null) view.camera.tell("This run has no telemetry here.");
    }
  }

  showView(view) {
    const { trial, start, length } = view.part;
    const t = start + Math.min(this.playhead.t, length);
    const key = `${trial}:${Math.floor(t / STEP_S + 1e-6)}`;
    if (key === view.shown) return;
    view.shown = key;
    view.camera.show({ trial, t, following: false }, null);
  }
}
