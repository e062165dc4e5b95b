// Saves a picture of the moment, and records a clip of what plays, with the browser's own recorder.
/**
 * @import { Picture } from "./composition.js"
 * @import { Player } from "./player.js"
 */
import { compose } from "./composition.js";

/** @type {[number, number]} */
const PICTURE = [1920, 1080];
/** @type {[number, number]} */
const CLIP = [1280, 720];
const RATE = 30; // [1/s] at most
const BITS_PER_S = 5e6;
const LONGEST_MS = 300_000; // a clip is kept in memory until it is saved
// The first that the browser can write. H.264 in MP4 plays almost everywhere.
/** @type {[string, string][]} */
const KINDS = [
  ["video/mp4;codecs=avc1.42E01F", "mp4"],
  ["video/webm;codecs=vp9", "webm"],
  ["video/webm;codecs=vp8", "webm"],
  ["video/webm", "webm"],
  ["video/mp4", "mp4"],
];

/**
 * @param {[number, number]} size
 * @param {CanvasRenderingContext2DSettings} [settings]
 */
function contextOf([width, height], settings = {}) {
  const canvas = Object.assign(document.createElement("canvas"), { width, height });
  const context = canvas.getContext("2d", settings);
  if (!(context instanceof CanvasRenderingContext2D)) throw new Error("This browser cannot draw pictures.");
  return context;
}

/**
 * @param {Blob} blob
 * @param {string} name
 */
function save(blob, name) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

export class Capture {
  /**
   * @param {Player} player
   * @param {{name: string, tell: (sentence: string) => void, onRecording: (seconds: number | null) => void}} options
   */
  constructor(player, { name, tell, onRecording }) {
    this.player = player;
    this.name = name;
    this.tell = tell;
    this.onRecording = onRecording;
    /** @type {MediaRecorder | null} */
    this.recorder = null;
    player.playhead.listen((playhead) => {
      if (this.recorder && !playhead.playing && !playhead.following) this.stop();
    });
  }

  /** @returns {[string, string] | undefined} */
  get kind() {
    if (typeof MediaRecorder === "undefined" || !HTMLCanvasElement.prototype.captureStream) return undefined;
    return KINDS.find(([type]) => MediaRecorder.isTypeSupported(type));
  }

  /**
   * scene: its canvas, null without one
   * @param {HTMLCanvasElement | null} scene
   * @returns {Picture}
   */
  moment(scene) {
    const { image } = this.player.camera;
    return { scene, camera: image.hidden || !image.naturalWidth ? null : image, ...this.player.describe() };
  }

  picture() {
    const context = contextOf(PICTURE);
    const { canvas } = context;
    /** @type {(scene: HTMLCanvasElement | null) => void} */
    const draw = (scene) => compose(context, this.moment(scene));
    const { view } = this.player.scene;
    if (view?.vehicle) view.picture(PICTURE, draw);
    else draw(null);
    const name = `${this.name}-${this.player.playhead.t.toFixed(1)}s.png`;
    canvas.toBlob((blob) => blob && save(blob, name), "image/png");
    this.tell("The picture was saved.");
  }

  toggle() {
    if (this.recorder) this.stop();
    else this.record();
  }

  record() {
    const { playhead, scene } = this.player;
    const { kind } = this;
    if (!kind) {
      this.tell("This browser cannot record clips.");
      return;
    }
    const [type, ending] = kind;
    const context = contextOf(CLIP, { alpha: false });
    /** @type {(canvas: HTMLCanvasElement | null) => void} */
    const draw = (canvas) => compose(context, this.moment(canvas));
    /** @type {Blob[]} */
    const chunks = [];
    const from = playhead.t.toFixed(1);
    if (!playhead.playing && !playhead.following) playhead.play();
    this.recorder = new MediaRecorder(context.canvas.captureStream(RATE), {
      mimeType: type,
      videoBitsPerSecond: BITS_PER_S,
    });
    this.recorder.addEventListener("dataavailable", ({ data }) => chunks.push(data));
    this.recorder.addEventListener("stop", () => {
      save(new Blob(chunks, { type: type.split(";")[0] }), `${this.name}-${from}s.${ending}`);
      this.tell("The clip was saved.");
    });
    this.tell("");
    const begun = performance.now();
    const step = () => {
      if (!this.recorder) return;
      const passed = performance.now() - begun;
      this.onRecording(passed / 1000);
      if (passed > LONGEST_MS) this.stop();
      if (scene.view)
        scene.view.request(); // draws, and then `onDraw` with the canvas
      else draw(null);
      requestAnimationFrame(step);
    };
    scene.record(draw);
    draw(null);
    this.recorder.start(1000);
    step();
  }

  stop() {
    const { recorder } = this;
    this.recorder = null;
    this.player.scene.record(null);
    recorder?.stop();
    this.onRecording(null);
  }
}
