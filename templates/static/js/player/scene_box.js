// The box of the 3-D scene on a page: loads three.js when it comes into sight, chooses the view, and says
// so where there is no WebGL.
/**
 * @import { Between, Row, SceneData, SceneSource } from "../server_data.d.ts"
 * @import { Memory } from "./memory.js"
 * @import { SceneView } from "./scene/view.js"
 */
import { all, maybe, need } from "../dom.js";
import { paced } from "./paced.js";

const MODES = ["all", "follow", "target", "route", "top", "camera", "free"];
const WATER_MAX = 40; // scenes of levels kept

/** @typedef {{instant: Between, trail: () => Row[]}} Shown what a scene shows of a run, and the rows before */

export class SceneBox {
  /**
   * data: {api, colour} of the run that is followed; ghosts: the same of other runs that are shown with it
   * @param {HTMLElement} box
   * @param {SceneSource} data
   * @param {Pick<Memory, "get" | "set">} memory
   * @param {SceneSource[]} [ghosts]
   */
  constructor(box, data, memory, ghosts = []) {
    this.box = box;
    this.data = data;
    this.memory = memory;
    this.ghosts = ghosts;
    /** @type {Map<string, SceneData>} */
    this.scenes = new Map();
    this.sceneKey = this.waterKey = this.solid = "";
    /** @type {SceneView | null} */
    this.view = null;
    this.software = false; // whether pictures are drawn by the processor
    /** @type {(canvas: HTMLCanvasElement) => void} */
    this.onDraw = () => {};
    /** @type {[{trial: number, t: number}, Between, () => Row[], (Shown | null)[]] | null} */
    this.last = null;
    /** @type {{trial: number, t: number} | null} */
    this.shownAt = null;
    this.stage = need(box, "[data-stage]", HTMLElement);
    this.note = maybe(box, "[data-scene-note]", HTMLElement);
    this.pose = maybe(box, "[data-pose]", HTMLElement);
    this.writePose = paced(() => this.showPose());
    this.radios = all(box, 'input[name="view"]', HTMLInputElement);
    this.fog = maybe(box, "[data-fog]", HTMLInputElement);
    // A route is more than what is around the vehicle.
    const first = this.radios.some(({ value }) => value === "route") ? "route" : "follow";
    const mode = memory.get("view", first);
    this.mode = MODES.includes(mode) ? mode : first;
    for (const radio of this.radios) {
      radio.checked = radio.value === this.mode;
      radio.addEventListener("change", () => this.setMode(radio.value));
    }
    if (this.fog) {
      this.fog.checked = memory.get("fog", true);
      this.fog.addEventListener("change", () => this.setFog());
    }
    for (const button of all(box, "[data-move]", HTMLElement)) {
      button.addEventListener("click", () => this.move(button.dataset.move));
    }
    this.inSight = this.recorded = false;
    // Loading begins when the box comes into sight. A promise from the start, since other observers
    // of the box may be called before the one below.
    /** @type {Promise<void>} */
    this.loaded = new Promise((/** @type {(value?: unknown) => void} */ done) => {
      new IntersectionObserver((entries) => {
        this.inSight = entries[entries.length - 1].isIntersecting;
        if (this.inSight) done();
        this.watch();
      }).observe(box);
    }).then(() => this.load());
  }

  watch() {
    this.view?.setWatched(this.inSight || this.recorded);
  }

  /**
   * Calls `draw` with each picture, also out of sight; null ends it.
   * @param {((canvas: HTMLCanvasElement) => void) | null} draw
   */
  record(draw) {
    this.recorded = draw !== null;
    this.onDraw = draw ?? (() => {});
    this.watch();
  }

  async load() {
    const scene = await import("./scene/view.js").catch(() => null);
    const { canDraw, software } = scene?.graphics() ?? { canDraw: false, software: false };
    this.software = software;
    document.documentElement.classList.toggle("software-rendering", software);
    let view = null;
    if (scene && canDraw) {
      try {
        view = new scene.SceneView(this.stage, { software, onDraw: (drawn) => this.drawn(drawn) });
      } catch {
        // The browser has WebGL but the graphics driver refuses.
      }
    }
    if (!view) {
      this.box.classList.add("without-webgl");
      if (!this.note) return; // the picture stays
      this.note.textContent =
        "This browser cannot draw 3-D graphics (WebGL 2). The camera, the numbers and the charts show the same moment.";
      this.note.hidden = false;
      return;
    }
    this.view = view;
    this.watch();
    Object.assign(view.canvas, { tabIndex: 0 });
    view.canvas.setAttribute("role", "img");
    view.canvas.setAttribute(
      "aria-label",
      "3-D scene of the vehicle and what is below it. Arrow keys turn the view, with Shift they move it, " +
        "plus and minus zoom. In the free view W, A, S, D, Q and E fly.",
    );
    if (this.last) this.show(...this.last);
  }

  /** @param {string} mode */
  setMode(mode) {
    this.mode = mode;
    this.memory.set("view", mode);
    this.view?.setMode(mode);
  }

  setFog() {
    if (!this.fog) return;
    this.memory.set("fog", this.fog.checked);
    this.view?.setTurbid(this.fog.checked);
  }

  /** @param {string | undefined} how */
  move(how) {
    const { view } = this;
    if (!view) return;
    if (how === "in") view.cameras.zoom(0.8);
    else if (how === "out") view.cameras.zoom(1.25);
    else {
      view.cameras.place();
      if (view.last) view.show(view.last, 0);
    }
    view.request();
  }

  /**
   * instant: {row, next, share} of the playhead; trail: () => the rows before it; ghosts: of each other run
   * {instant, trail}, or null where it has no telemetry
   * @param {{trial: number, t: number}} playhead
   * @param {Between} instant
   * @param {() => Row[]} trail
   * @param {(Shown | null)[]} [ghosts]
   */
  show(playhead, instant, trail, ghosts = []) {
    this.last = [playhead, instant, trail, ghosts];
    if (!this.view) return;
    const { trial, t } = playhead;
    this.useScene(this.view, trial, instant.row.level ?? 0);
    const { shownAt } = this;
    const seconds = shownAt?.trial === trial ? Math.min(Math.max(t - shownAt.t, 0), 2) : 0;
    this.shownAt = { trial, t };
    const moments = [{ instant, trail }, ...ghosts];
    this.view.show(
      moments.map(
        (moment) =>
          moment && {
            pose: poseBetween(moment.instant),
            work: poseOf(moment.instant, "workpiece_"),
            decoy: poseOf(moment.instant, "decoy_"),
            row: moment.instant.row,
            trail: moment.trail(),
          },
      ),
      seconds,
    );
    if (!this.view.watched) this.writePose(); // a screen reader reads it wherever the page is scrolled to
  }

  /**
   * The scene of a level is requested once; until it has arrived the last one stays.
   * @param {SceneView} view
   * @param {number} trial
   * @param {number} level
   */
  async useScene(view, trial, level) {
    const key = `${trial}:${level}`;
    if (this.sceneKey === key) return;
    this.sceneKey = key;
    const scene = await this.sceneOf(trial, level);
    if (this.sceneKey !== key || !scene) return;
    this.waterKey = key;
    const bottom = scene.seabed.painted ? level : null;
    const standing = scene.target && { ...scene.target, path: undefined }; // its path is another in each level
    const solid = JSON.stringify([trial, scene.vehicle, standing, scene.workpiece, scene.seabed, bottom]);
    if (solid === this.solid) {
      view.setWater(scene.water, scene.light);
      view.setRoute(scene.route);
      view.setTarget(scene.target);
      return;
    }
    const others = await Promise.all(this.ghosts.map(({ api }) => this.fetchScene(api, queryOf(trial, 0))));
    if (this.sceneKey !== key) return;
    this.solid = solid;
    const vehicles = [scene, ...others].map((shown, index) => ({
      colour: (index ? this.ghosts[index - 1] : this.data).colour,
      shape: shown?.vehicle ?? null,
      work: shown?.workpiece,
    }));
    /** @type {(part: string) => string} */
    const texture = (part) => `${this.data.api}/texture.jpg?part=${part}&${queryOf(trial, level)}`;
    const [seabed, target, decoy] = ["seabed", "target", "decoy"].map(texture);
    view.describe({ ...scene, vehicles }, { seabed, target, decoy });
    view.setMode(this.mode);
    this.setFog();
  }

  /**
   * What stands in the water of a level; null if that could not be read.
   * @param {number} trial
   * @param {number} level
   */
  sceneOf(trial, level) {
    return this.fetchScene(this.data.api, queryOf(trial, level));
  }

  /**
   * @param {string} api
   * @param {string} query
   * @returns {Promise<SceneData | null>}
   */
  async fetchScene(api, query) {
    const address = `${api}/scene.json?${query}`;
    const known = this.scenes.get(address);
    if (known) return known;
    const response = await fetch(address);
    if (!response.ok) return null;
    if (this.scenes.size >= WATER_MAX) this.scenes.clear();
    /** @type {SceneData} */
    const scene = await response.json();
    this.scenes.set(address, scene);
    return scene;
  }

  // A key for each view, in their order on the page.
  get keys() {
    return Object.fromEntries(this.radios.map((radio, index) => [String(index + 1), () => radio.click()]));
  }

  /** @param {SceneView} view */
  drawn({ canvas, pace: { scale } }) {
    this.onDraw(canvas);
    this.writePose();
    this.stage.dataset.water = this.waterKey;
    this.stage.dataset.scale = scale.toFixed(2);
    this.stage.dataset.pictures = String(Number(this.stage.dataset.pictures ?? 0) + 1);
  }

  // What the scene shows, read from its vehicle, in words.
  showPose() {
    const vehicle = this.view?.vehicle;
    if (!this.pose || !vehicle) return;
    const { position, rotation } = vehicle.group;
    /** @type {(value: number) => string} */
    const metres = (value) => value.toFixed(3).replace("-", "−");
    const heading = ((((rotation.z * 180) / Math.PI) % 360) + 360) % 360;
    this.pose.textContent = [
      `north ${metres(position.x)}`,
      `east ${metres(position.y)}`,
      `depth ${metres(position.z)} m`,
      `heading ${heading.toFixed(1)}°`,
    ].join(", ");
  }
}

/**
 * @param {number} trial
 * @param {number} level
 */
const queryOf = (trial, level) => `trial=${trial}&level=${level}`;

/**
 * The pose of a thing, null where a run has none.
 * @param {Between} instant
 * @param {string} of how the names of its columns begin
 */
const poseOf = (instant, of) => (typeof instant.row[`${of}x`] === "number" ? poseBetween(instant, of) : null);

/**
 * Between two rows: positions linearly, angles along the shorter way; of: how the names of its columns begin.
 * @param {Between} between
 * @param {string} [of]
 */
export function poseBetween({ row, next, share }, of = "") {
  /** @type {(name: string) => [number, number]} */
  const both = (name) => [Number(row[of + name]), Number(next[of + name])];
  /** @type {(name: string) => number} */
  const along = (name) => {
    const [from, to] = both(name);
    return from + share * (to - from);
  };
  /** @type {(name: string) => number} */
  const turned = (name) => {
    const [from, to] = both(name);
    return from + share * Math.atan2(Math.sin(to - from), Math.cos(to - from));
  };
  return {
    x: along("x"),
    y: along("y"),
    z: along("z"),
    roll: turned("roll"),
    pitch: turned("pitch"),
    yaw: turned("yaw"),
  };
}
