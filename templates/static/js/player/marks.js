// Where the target was lost, where the hull first touched something, and where levels change: on the time line,
// and for the charts. Of a live run they are asked for again from time to time.

const AGAIN_MS = 30_000; // each request reads the whole trial
const NONE = { levels: [], losses: [], touches: [], largest_error: null };

export class Marks {
  // strip: the element above which they are drawn; legend: of the charts; duration: of the strip [s]
  constructor(strip, legend, { api, duration }) {
    Object.assign(this, {
      strip,
      legend,
      api,
      duration,
      found: NONE,
      trial: null,
      level: null,
      asked: -Infinity,
      onChange: () => {},
    });
  }

  // Returns the moments of a trial as they are now; null if they could not be read.
  async load(trial) {
    this.asked = performance.now();
    this.trial = trial;
    const response = await fetch(`${this.api}/moments.json?trial=${trial}`);
    if (!response.ok || trial !== this.trial) return null;
    this.found = await response.json();
    this.draw();
    this.onChange(this.found);
    return this.found;
  }

  // Loads them if the trial is another one, or if a live run has gone on.
  want({ trial, live, newest }) {
    if (!newest) return;
    const old = live && performance.now() - this.asked > AGAIN_MS;
    if (trial !== this.trial || old) this.load(trial);
  }

  clear() {
    Object.assign(this, { found: NONE, trial: null });
    this.draw();
    this.onChange(NONE);
  }

  draw() {
    const { levels, losses, touches } = this.found;
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
    );
    this.legend.hidden = !losses.length && !touches.length;
    this.legend.querySelector(".loss").hidden = !losses.length;
    this.legend.querySelector(".touch").hidden = !touches.length;
  }
}
