// The vehicle's camera at the playhead. There is one request at a time; of the images wanted in the
// meantime, only the last is loaded.
/** @import { Row } from "../server_data.d.ts" */
import { maybe, need } from "../dom.js";

const PERIOD_MS = 60; // from one image to the next at least, and as long as the last one took
const LIVE_PERIOD_MS = 400;
const VIEWER_PERIOD_MS = 20; // the more viewers a run has, the less often each asks for an image
const ZOOM = 3;

/** @typedef {{trial: number, t: number}} Moment */

export class Camera {
  /**
   * @param {ParentNode} root
   * @param {{api: string, step: number}} run
   */
  constructor(root, { api, step }) {
    this.api = api;
    this.step = step;
    this.box = need(root, "[data-camera]", HTMLElement);
    this.image = need(this.box, "img", HTMLImageElement);
    this.note = need(this.box, "[data-camera-note]", HTMLElement);
    this.truth = maybe(root, "[data-truth]", HTMLInputElement);
    this.tracked = maybe(root, "[data-tracked]", HTMLInputElement);
    this.zoom = maybe(root, "[data-zoom]", HTMLInputElement);
    this.onArm = maybe(root, "[data-on-arm]", HTMLInputElement);
    this.sonar = maybe(root, "[data-sonar]", HTMLInputElement);
    /** @type {Moment | null} */
    this.wanted = null;
    /** @type {Moment | null} */
    this.shown = null;
    /** @type {Row | null} */
    this.row = null;
    this.following = false;
    this.busy = false;
    this.viewers = 1; // of the live run
    this.truth?.addEventListener("change", () => this.again());
    this.tracked?.addEventListener("change", () => this.again());
    this.zoom?.addEventListener("change", () => this.place());
    this.onArm?.addEventListener("change", () => this.again());
    this.sonar?.addEventListener("change", () => this.again());
  }

  /**
   * Shows the last image before time `t`; `row` is the telemetry of that moment, null if unknown.
   * @param {{trial: number, t: number, following: boolean}} moment
   * @param {Row | null} row
   */
  show({ trial, t, following }, row) {
    this.row = row;
    this.following = following;
    this.place();
    this.wanted = { trial, t };
    if (!this.busy) this.load();
  }

  again() {
    if (!this.shown) return;
    this.wanted = this.shown;
    if (!this.busy) this.load();
  }

  // Enlarges the image around the target, where the tracker or else the truth has it.
  place() {
    const { image, row } = this;
    const sure = row && row.tracker_ok === 1 && Number.isFinite(row.tracked_x);
    const [x, y] = (sure ? [row.tracked_x, row.tracked_y] : [row?.target_x, row?.target_y]).map(
      (at) => at ?? Number.NaN,
    );
    const zoomed =
      Boolean(this.zoom?.checked) &&
      !this.onArm?.checked &&
      Number.isFinite(x) &&
      Number.isFinite(y) &&
      image.naturalWidth > 0;
    image.style.transform = zoomed ? `scale(${ZOOM})` : "";
    if (!zoomed) return;
    /** @type {(value: number, size: number) => number} */
    const share = (value, size) => Math.min(Math.max(((value / size) * ZOOM - 0.5) / (ZOOM - 1), 0), 1) * 100;
    image.style.transformOrigin = `${share(x, image.naturalWidth)}% ${share(y, image.naturalHeight)}%`;
  }

  /**
   * Shows a sentence instead of an image.
   * @param {string} text
   */
  tell(text) {
    this.wanted = null;
    this.note.textContent = text;
    this.note.hidden = false;
    this.image.hidden = true;
  }

  /** @param {Moment} moment */
  address({ trial, t }) {
    const truth = this.truth && !this.truth.checked ? "&truth=false" : "";
    const tracked = this.tracked && !this.tracked.checked ? "&tracked=false" : "";
    const camera = this.sonar?.checked ? "&camera=sonar" : this.onArm?.checked ? "&camera=arm" : "";
    return `${this.api}/camera.jpg?trial=${trial}${tracked}${truth}${camera}&t=${t.toFixed(2)}`;
  }

  async load() {
    this.busy = true;
    while (this.wanted) {
      this.shown = this.wanted;
      this.wanted = null;
      const begun = performance.now();
      const next = new Image();
      next.src = this.address(this.shown);
      try {
        await next.decode();
        this.image.src = next.src;
        this.image.hidden = false;
        this.note.hidden = true;
        this.place();
      } catch {
        this.note.textContent = "No image is available at this time.";
        this.note.hidden = !this.image.hidden;
      }
      const took = performance.now() - begun;
      const period = this.following
        ? Math.max(LIVE_PERIOD_MS, VIEWER_PERIOD_MS * this.viewers)
        : Math.max(PERIOD_MS, took);
      await new Promise((done) => setTimeout(done, Math.max(period - took, 0)));
    }
    this.busy = false;
  }
}
