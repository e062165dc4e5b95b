// The box of the 3-D scene on a page: loads three.js when it comes into sight, chooses the view, and says
// so where there is no WebGL.
import { paced } from "./paced.js";

const MODES = ["follow", "target", "top", "camera"];
const WATER_MAX = 40; // scenes of levels kept

export class SceneBox {
  constructor(box, data, memory) {
    Object.assign(this, { box, data, memory, scenes: new Map() });
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
    for (const button of box.querySelectorAll("[data-move]")) button.addEventListener("click", () => this.move(button.dataset.move));
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
      this.note.textContent = "This browser cannot draw 3-D graphics (WebGL 2). The camera, the numbers and the charts show the same moment.";
      this.note.hidden = false;
      return;
    }
    this.view = view;
    Object.assign(view.canvas, { tabIndex: 0 });
    view.canvas.setAttribute("role", "img");
    view.canvas.setAttribute("aria-label", "3-D scene of the vehicle above the target. Arrow keys turn the view, with Shift they move it, plus and minus zoom.");
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
    this.view?.setFog(this.fog.checked);
  }

  move(how) {
    const cameras = this.view?.cameras;
    if (!cameras) return;
    if (how === "in") cameras.zoom(0.8);
    else if (how === "out") cameras.zoom(1.25);
    else cameras.setMode(this.mode);
    this.view.request();
  }

  // found: {row, next, share} of the playhead; trail: () => the rows before it
  show(playhead, found, trail) {
    this.last = [playhead, found, trail];
    if (!this.view) return;
    const { trial, t } = playhead;
    this.useScene(trial, found.row.level ?? 0);
    const seconds = this.shownAt?.trial === trial ? Math.min(Math.max(t - this.shownAt.t, 0), 2) : 0;
    this.shownAt = { trial, t };
    this.view.show({ pose: poseBetween(found), row: found.row, trail: trail(), seconds });
  }

  // The scene of a level is requested once; until it has arrived the last one stays.
  async useScene(trial, level) {
    const key = `${trial}:${level}`;
    if (this.sceneKey === key) return;
    this.sceneKey = key;
    const query = `trial=${trial}&level=${level}`;
    if (!this.scenes.has(key)) {
      const response = await fetch(`${this.data.api}/scene.json?${query}`);
      if (!response.ok) return;
      if (this.scenes.size >= WATER_MAX) this.scenes.clear();
      this.scenes.set(key, await response.json());
    }
    if (this.sceneKey !== key) return;
    const scene = this.scenes.get(key);
    const solid = JSON.stringify([trial, scene.vehicle, scene.target, scene.seabed]);
    if (solid === this.solid) this.view.setWater(scene.water);
    else {
      this.solid = solid;
      const texture = (part) => `${this.data.api}/texture.jpg?part=${part}&${query}`;
      this.view.describe({ ...scene }, { seabed: texture("seabed"), target: texture("target") });
      this.view.setMode(this.mode);
      this.setFog();
    }
  }

  drawn({ scale }) {
    this.writePose();
    this.stage.dataset.scale = scale.toFixed(2);
    this.stage.dataset.pictures = String(Number(this.stage.dataset.pictures ?? 0) + 1);
  }

  // What the scene shows, read from its vehicle, in words.
  showPose() {
    if (!this.pose) return;
    const { position, rotation } = this.view.vehicle.group;
    const metres = (value) => value.toFixed(3).replace("-", "−");
    const heading = (((rotation.z * 180) / Math.PI) % 360 + 360) % 360;
    this.pose.textContent = `north ${metres(position.x)}, east ${metres(position.y)}, depth ${metres(position.z)} m, heading ${heading.toFixed(1)}°`;
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
