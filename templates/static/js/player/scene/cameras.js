// How one looks at the scene: around the vehicle, around the target, from above, or through the vehicle's
// camera. Mouse and touch by OrbitControls; the keys below move the view without either.
import { Matrix4, OrbitControls, PerspectiveCamera, Quaternion, Vector3 } from "../../../vendor/three/three.min.js";

export const MODES = { follow: "Follow", target: "Target", top: "Top", camera: "On board" };
const TURN = 0.12; // [rad] per key
const STEP_M = 0.25; // per key
const ZOOM = 1.15; // per key
const FIELD_OF_VIEW = 48; // [degree] vertical
const TO_SCREEN = (v) => new Vector3(v.y, -v.z, -v.x);
// From the axes of a three.js camera (x right, y up, -z ahead) to the body (x forward, y starboard, z down).
const LOOK_DOWN = new Quaternion().setFromRotationMatrix(new Matrix4().set(0, 1, 0, 0, 1, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1));

export class Cameras {
  constructor(canvas, onChange) {
    this.mode = "follow";
    this.camera = new PerspectiveCamera(FIELD_OF_VIEW, 4 / 3, 0.05, 80);
    this.camera.position.set(3.2, 1.4, 3.6);
    this.controls = new OrbitControls(this.camera, canvas);
    Object.assign(this.controls, { minDistance: 0.6, maxDistance: 25, maxPolarAngle: Math.PI * 0.55 });
    this.controls.addEventListener("change", onChange);
    this.onChange = onChange;
    this.centre = new Vector3();
    canvas.addEventListener("keydown", (event) => this.onKey(event));
    canvas.style.touchAction = "pan-y"; // one finger up or down scrolls the page
  }

  describe({ target, camera, vehicle }) {
    this.target = TO_SCREEN(new Vector3(...target.centre));
    this.optics = camera;
    const length = Math.max(...(vehicle?.hull ?? []).map(({ size }) => size[0]), 0);
    this.near = length > 1 ? 1 : 0.62; // a small vehicle is looked at from nearby
    if (this.placed) return;
    this.placed = true;
    this.setMode(this.mode);
  }

  // Keeps the view relative to the vehicle.
  follow(vehicle) {
    this.vehicle = vehicle;
    const now = TO_SCREEN(vehicle.position);
    if (this.mode === "follow" || this.mode === "top") {
      const moved = now.clone().sub(this.centre);
      this.camera.position.add(moved);
      this.controls.target.add(moved);
    }
    this.centre.copy(now);
  }

  setMode(mode) {
    this.mode = mode;
    this.controls.enabled = mode !== "camera";
    const centre = mode === "target" && this.target ? this.target : this.centre;
    const offset = mode === "top" ? new Vector3(0, 7, 0.01) : new Vector3(2.7, 1.5, 3.1).multiplyScalar(this.near ?? 1);
    this.controls.target.copy(centre);
    if (mode === "follow") this.controls.target.y -= 0.8; // towards the target
    this.camera.position.copy(centre).add(offset);
    this.resize(this.width, this.height);
  }

  resize(width, height) {
    Object.assign(this, { width, height });
    if (!width) return;
    this.camera.aspect = width / height;
    this.camera.fov = FIELD_OF_VIEW;
    if (this.mode === "camera" && this.optics) {
      // The whole image fits into the box.
      const { width: columns, height: rows, focal } = this.optics;
      const visible = Math.max(rows, columns / this.camera.aspect);
      this.camera.fov = (2 * Math.atan(visible / 2 / focal) * 180) / Math.PI;
    }
    this.camera.updateProjectionMatrix();
  }

  update() {
    if (this.mode === "camera" && this.vehicle && this.optics) {
      const { position, quaternion } = this.vehicle;
      const eye = new Vector3(...this.optics.mount).applyQuaternion(quaternion).add(position);
      this.camera.position.copy(TO_SCREEN(eye));
      const world = new Quaternion().setFromRotationMatrix(new Matrix4().set(0, 1, 0, 0, 0, 0, -1, 0, -1, 0, 0, 0, 0, 0, 0, 1));
      this.camera.quaternion.copy(world.multiply(quaternion).multiply(LOOK_DOWN));
    } else this.controls.update();
    return this.camera;
  }

  onKey(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || this.mode === "camera") return;
    const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    if (event.key in turns) {
      const [across, down] = turns[event.key];
      if (event.shiftKey) this.pan(across, down);
      else this.turn(across * TURN, down * TURN);
    } else if (event.key === "+" || event.key === "=") this.zoom(1 / ZOOM);
    else if (event.key === "-") this.zoom(ZOOM);
    else return;
    event.preventDefault();
    event.stopPropagation();
    this.onChange();
  }

  turn(across, down) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const radius = offset.length();
    const azimuth = Math.atan2(offset.x, offset.z) + across;
    const polar = Math.min(Math.max(Math.acos(offset.y / radius) + down, 0.01), this.controls.maxPolarAngle);
    offset.set(Math.sin(polar) * Math.sin(azimuth), Math.cos(polar), Math.sin(polar) * Math.cos(azimuth)).multiplyScalar(radius);
    this.camera.position.copy(this.controls.target).add(offset);
  }

  pan(across, down) {
    const right = new Vector3().setFromMatrixColumn(this.camera.matrix, 0).multiplyScalar(across * STEP_M);
    const up = new Vector3().setFromMatrixColumn(this.camera.matrix, 1).multiplyScalar(-down * STEP_M);
    for (const point of [this.camera.position, this.controls.target]) point.add(right).add(up);
  }

  zoom(factor) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const length = Math.min(Math.max(offset.length() * factor, this.controls.minDistance), this.controls.maxDistance);
    this.camera.position.copy(this.controls.target).add(offset.setLength(length));
  }
}
