// The box of the 3-D scene on a page: loads three.js when it comes into sight, chooses the view, and says
// so where there is no WebGL.
import { paced } from "./paced.js";

const MODES = ["all", "follow", "target", "top", "camera", "free"];
const WATER_MAX = 40; // scenes of levels kept

export class SceneBox {
  // data: {api, colour} of the run that is followed; ghosts: the same of other runs that are shown with it
  constructor(box, data, memory, ghosts = []) {
    Object.assign(this, { box, data, memory, ghosts, scenes: new Map(), onDraw: () => {} });
    this.stage = box.querySelector("[data-stage]");
    this.note = box.querySelector("[data-scene-note]");
    this.pose = box.querySelector("[data-pose]");
    this.writePose = paced(() => this.showPose());
    this.radios = [...box.querySelectorAll('input[name="view"]')];
    this.fog = box.querySelector("[data-fog]");
    const mode = memory.get("view", "follow");
    this.mode = MODES.includes(mode) ? mode : "follow";
    for (const radio of this.radios) {
      radio.checked = radio.value === this.mode;
      radio.addEventListener("change", () => this.setMode(radio.value));
    }
    if (this.fog) {
      this.fog.checked = memory.get("fog", true);
      this.fog.addEventListener("change", () => this.setFog());
    }
    for (const button of box.querySelectorAll("[data-move]"))
      button.addEventListener("click", () => this.move(button.dataset.move));
    const sight = new IntersectionObserver((entries) => {
      if (!entries.some((entry) => entry.isIntersecting)) return;
      sight.disconnect();
      this.load();
    });
    sight.observe(box);
  }

  async load() {
    const scene = await import("./scene/view.js").catch(() => null);
    const { canDraw, software } = scene?.graphics() ?? { canDraw: false };
    document.documentElement.classList.toggle("software-rendering", Boolean(software));
    let view = null;
    if (canDraw) {
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
    Object.assign(view.canvas, { tabIndex: 0 });
    view.canvas.setAttribute("role", "img");
    view.canvas.setAttribute(
      "aria-label",
      "3-D scene of the vehicle above the target. Arrow keys turn the view, with Shift they move it, " +
        "plus and minus zoom. In the free view W, A, S, D, Q and E fly.",
    );
    if (this.last) this.show(...this.last);
  }

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

  move(how) {
    const cameras = this.view?.cameras;
    if (!cameras) return;
    if (how === "in") cameras.zoom(0.8);
    else if (how === "out") cameras.zoom(1.25);
    else {
      cameras.place();
      if (this.view.last) this.view.show(this.view.last, 0);
    }
    this.view.request();
  }

  // found: {row, next, share} of the playhead; trail: () => the rows before it; ghosts: of each other run
  // {found, trail}, or null where it has no telemetry
  show(playhead, found, trail, ghosts = []) {
    this.last = [playhead, found, trail, ghosts];
    if (!this.view) return;
    const { trial, t } = playhead;
    this.useScene(trial, found.row.level ?? 0);
    const seconds = this.shownAt?.trial === trial ? Math.min(Math.max(t - this.shownAt.t, 0), 2) : 0;
    this.shownAt = { trial, t };
    const moments = [{ found, trail }, ...ghosts];
    this.view.show(
      moments.map(
        (moment) => moment && { pose: poseBetween(moment.found), row: moment.found.row, trail: moment.trail() },
      ),
      seconds,
    );
  }

  // The scene of a level is requested once; until it has arrived the last one stays.
  async useScene(trial, level) {
    const key = `${trial}:${level}`;
    if (this.sceneKey === key) return;
    this.sceneKey = key;
    const query = `trial=${trial}&level=${level}`;
    const scene = await this.fetchScene(this.data.api, query);
    if (this.sceneKey !== key || !scene) return;
    this.waterKey = key;
    const solid = JSON.stringify([trial, scene.vehicle, scene.target, scene.seabed]);
    if (solid === this.solid) {
      this.view.setWater(scene.water, scene.light);
      return;
    }
    const others = await Promise.all(this.ghosts.map(({ api }) => this.fetchScene(api, `trial=${trial}&level=0`)));
    if (this.sceneKey !== key) return;
    this.solid = solid;
    const vehicles = [this.data, ...this.ghosts].map(({ colour }, index) => ({
      colour,
      shape: (index ? others[index - 1] : scene)?.vehicle ?? null,
    }));
    const texture = (part) => `${this.data.api}/texture.jpg?part=${part}&${query}`;
    this.view.describe({ ...scene, vehicles }, { seabed: texture("seabed"), target: texture("target") });
    this.view.setMode(this.mode);
    this.setFog();
  }

  async fetchScene(api, query) {
    const address = `${api}/scene.json?${query}`;
    if (!this.scenes.has(address)) {
      const response = await fetch(address);
      if (!response.ok) return null;
      if (this.scenes.size >= WATER_MAX) this.scenes.clear();
      this.scenes.set(address, await response.json());
    }
    return this.scenes.get(address);
  }

  // A key for each view, in their order on the page.
  get keys() {
    return Object.fromEntries(this.radios.map((radio, index) => [String(index + 1), () => radio.click()]));
  }

  drawn({ canvas, pace: { scale } }) {
    this.onDraw(canvas);
    this.writePose();
    this.stage.dataset.water = this.waterKey;
    this.stage.dataset.scale = scale.toFixed(2);
    this.stage.dataset.pictures = String(Number(this.stage.dataset.pictures ?? 0) + 1);
  }

  // What the scene shows, read from its vehicle, in words.
  showPose() {
    if (!this.pose) return;
    const { position, rotation } = this.view.vehicle.group;
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

// Between two rows: positions linearly, angles along the shorter way.
function poseBetween({ row, next, share }) {
  const pose = {};
  for (const name of ["x", "y", "z"]) pose[name] = row[name] + share * (next[name] - row[name]);
  for (const name of ["roll", "pitch", "yaw"]) {
    const turn = Math.atan2(Math.sin(next[name] - row[name]), Math.cos(next[name] - row[name]));
    pose[name] = row[name] + share * turn;
  }
  return pose;
}
