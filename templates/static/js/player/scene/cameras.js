// How one looks at the scene: around the vehicle, around the target, at a whole route, from above, through the
// vehicle's camera, from so far away that all vehicles are in the picture, or flying freely. Mouse and touch by
// OrbitControls; the keys below move the view without either.
/**
 * @import { Object3D } from "three"
 * @import { Optics, SceneData, Triple, VehicleShape } from "../../server_data.d.ts"
 */
import { Matrix4, OrbitControls, PerspectiveCamera, Quaternion, Vector3 } from "../../../vendor/three/three.min.js";

const TURN = 0.12; // [rad] per key
const STEP_M = 0.25; // per key
const ZOOM = 1.15; // per key
const FLY_M_S = 1.6;
const FAST = 4; // times as fast with Shift
const FLY_STEP_S = 0.12; // of flight for a key that is only touched
/**
 * right, up and ahead for each key that flies
 * @type {Record<string, Triple>}
 */
const FLY = { w: [0, 0, 1], s: [0, 0, -1], a: [-1, 0, 0], d: [1, 0, 0], e: [0, 1, 0], q: [0, -1, 0] };
const FIELD_OF_VIEW = 48; // [degree] vertical
const ABOVE_ROUTE = new Vector3(0.5, 1, 0.75); // whence one first looks at a route, y up
const FRAME_M = 0.8; // around the vehicles that are all in the picture
/** @type {(place: Vector3) => Vector3} */
const TO_SCREEN = (v) => new Vector3(v.y, -v.z, -v.x);
// From the axes of a three.js camera (x right, y up, -z ahead) to the body (x forward, y starboard, z down).
const LOOK_DOWN = new Quaternion().setFromRotationMatrix(
  new Matrix4().set(0, 1, 0, 0, 1, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1),
);

export class Cameras {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {() => void} onChange
   */
  constructor(canvas, onChange) {
    this.mode = "follow";
    this.camera = new PerspectiveCamera(FIELD_OF_VIEW, 4 / 3, 0.05, 80);
    this.camera.position.set(3.2, 1.4, 3.6);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", onChange);
    this.onChange = onChange;
    this.centre = new Vector3();
    this.canvas = canvas;
    /** @type {Set<string>} keys that are held */
    this.flying = new Set();
    this.fast = false;
    /** @type {number | undefined} when the view was last flown [ms] */
    this.flown = undefined;
    this.placed = false;
    this.near = 1;
    this.width = this.height = 0;
    /** @type {Object3D | null} */
    this.vehicle = null;
    /** @type {Optics | null} */
    this.optics = null;
    this.target = new Vector3();
    this.described = false;
    /** @type {Vector3[]} points of a route that is followed */
    this.route = [];
    canvas.addEventListener("keydown", (event) => this.onKey(event));
    canvas.addEventListener("keyup", (event) => this.flying.delete(event.key.toLowerCase()));
    canvas.addEventListener("blur", () => this.flying.clear());
  }

  /**
   * @param {Pick<SceneData, "target" | "route" | "camera"> & {vehicles: {shape: VehicleShape | null}[]}} description
   */
  describe({ target, route, camera, vehicles }) {
    if (target) this.target = TO_SCREEN(new Vector3(...target.centre));
    this.described = target !== null && !route; // nobody looks at what lies below a route
    this.optics = camera;
    const length = Math.max(...(vehicles[0].shape?.hull ?? []).map(({ size }) => size[0]), 0);
    this.near = length > 1 ? 1 : 0.62; // a small vehicle is looked at from nearby
    if (!this.placed) this.setMode(this.mode);
  }

  /**
   * Brings another route into the picture, seen from where one looked at the last one.
   * @param {Triple[]} points
   */
  setRoute(points) {
    this.route = points.map((point) => new Vector3(...point));
    if (this.mode === "route" && this.route.length) this.frameAll(this.route.map(TO_SCREEN));
  }

  /**
   * Keeps the view relative to the vehicle.
   * @param {Object3D} vehicle
   */
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

  /**
   * Keeps the view relative to a target that moves.
   * @param {Triple} place
   */
  aimAt(place) {
    const now = TO_SCREEN(new Vector3(...place));
    if (this.mode === "target" && this.placed) {
      const moved = now.clone().sub(this.target);
      this.camera.position.add(moved);
      this.controls.target.add(moved);
    }
    this.target.copy(now);
  }

  /**
   * Brings the target and vehicles at these positions into the picture.
   * @param {Vector3[]} positions
   */
  frame(positions) {
    const points = positions.map(TO_SCREEN);
    if (this.described) points.push(this.target);
    this.frameAll(points);
  }

  /**
   * Moves back or closer, without turning, until all points are in the picture.
   * @param {Vector3[]} points in the frame of the screen
   */
  frameAll(points) {
    const low = points.reduce((corner, point) => corner.clone().min(point));
    const high = points.reduce((corner, point) => corner.clone().max(point));
    const centre = low.add(high).multiplyScalar(0.5);
    const back = this.camera.position.clone().sub(this.controls.target).normalize();
    const right = new Vector3(0, 1, 0).cross(back).normalize();
    const up = back.clone().cross(right);
    const tangent = Math.tan((this.camera.fov * Math.PI) / 360);
    const away = points.map((point) => {
      const from = point.clone().sub(centre);
      const across = (Math.abs(from.dot(right)) + FRAME_M) / this.camera.aspect;
      return from.dot(back) + Math.max(across, Math.abs(from.dot(up)) + FRAME_M) / tangent;
    });
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).addScaledVector(back, Math.max(...away));
  }

  /**
   * Flying starts from where one looks now.
   * @param {string} mode
   */
  setMode(mode) {
    const stays = mode === "free" && this.placed && this.mode !== "camera";
    const free = mode === "free";
    this.mode = mode;
    this.flying.clear();
    Object.assign(this.controls, {
      enabled: mode !== "camera",
      enableZoom: mode !== "all",
      minDistance: free ? 0.2 : 0.6,
      maxDistance: free || mode === "all" || mode === "route" ? 60 : 25,
      maxPolarAngle: Math.PI * (free ? 0.95 : 0.55),
    });
    // OrbitControls takes every touch; otherwise one finger up or down scrolls the page.
    this.canvas.style.touchAction = free ? "none" : "pan-y";
    if (!stays) this.place();
    this.placed = Boolean(this.vehicle);
    this.resize(this.width, this.height);
  }

  // Takes the view that the mode begins with.
  place() {
    const { mode } = this;
    const centre = mode === "target" && this.described ? this.target : this.centre;
    const offset = mode === "top" ? new Vector3(0, 7, 0.01) : new Vector3(2.7, 1.5, 3.1).multiplyScalar(this.near);
    this.controls.target.copy(centre);
    if (mode === "follow") this.controls.target.y -= 0.8; // towards the target
    this.camera.position.copy(centre).add(offset);
    if (mode !== "route" || !this.route.length) return;
    this.camera.position.copy(centre).add(ABOVE_ROUTE);
    this.frameAll(this.route.map(TO_SCREEN));
  }

  /**
   * @param {number} width
   * @param {number} height
   */
  resize(width, height) {
    this.width = width;
    this.height = height;
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
      const world = new Quaternion().setFromRotationMatrix(
        new Matrix4().set(0, 1, 0, 0, 0, 0, -1, 0, -1, 0, 0, 0, 0, 0, 0, 1),
      );
      this.camera.quaternion.copy(world.multiply(quaternion).multiply(LOOK_DOWN));
    } else {
      this.fly();
      this.controls.update();
    }
    return this.camera;
  }

  // Moves on by the keys that are held.
  fly() {
    const now = performance.now();
    const seconds = Math.min((now - (this.flown ?? now)) / 1000, 0.2);
    this.flown = this.flying.size ? now : undefined;
    for (const key of this.flying) this.move(FLY[key], seconds * FLY_M_S * (this.fast ? FAST : 1));
    if (this.flying.size) this.onChange();
  }

  /** @param {KeyboardEvent} event */
  onKey(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || this.mode === "camera") return;
    if (this.mode === "free" && this.onFlyKey(event)) return;
    /** @type {Record<string, [number, number]>} */
    const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    if (event.key in turns) {
      const [across, down] = turns[event.key];
      if (event.shiftKey) this.move([across, -down, 0], STEP_M);
      else if (this.mode === "free") this.look(across * TURN, down * TURN);
      else this.turn(across * TURN, down * TURN);
    } else if (event.key === "+" || event.key === "=") this.zoom(1 / ZOOM);
    else if (event.key === "-") this.zoom(ZOOM);
    else return;
    event.preventDefault();
    event.stopPropagation();
    this.onChange();
  }

  /**
   * @param {number} across
   * @param {number} down
   */
  turn(across, down) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const radius = offset.length();
    const azimuth = Math.atan2(offset.x, offset.z) + across;
    const polar = Math.min(Math.max(Math.acos(offset.y / radius) + down, 0.01), this.controls.maxPolarAngle);
    offset
      .set(Math.sin(polar) * Math.sin(azimuth), Math.cos(polar), Math.sin(polar) * Math.cos(azimuth))
      .multiplyScalar(radius);
    this.camera.position.copy(this.controls.target).add(offset);
  }

  /**
   * Turns the view about the eye.
   * @param {number} across
   * @param {number} down
   */
  look(across, down) {
    const { position } = this.camera;
    const { target } = this.controls;
    const ahead = target.clone().sub(position);
    const length = ahead.length();
    const azimuth = Math.atan2(ahead.x, ahead.z) - across;
    const rise = Math.min(Math.max(Math.asin(ahead.y / length) - down, -1.5), 1.5);
    target
      .set(Math.cos(rise) * Math.sin(azimuth), Math.sin(rise), Math.cos(rise) * Math.cos(azimuth))
      .multiplyScalar(length)
      .add(position);
  }

  /**
   * Moves the eye and what it looks at to the right, up and ahead.
   * @param {Triple} direction
   * @param {number} metres
   */
  move([right, up, ahead], metres) {
    const step = new Vector3();
    const axis = new Vector3();
    for (const [column, share] of [right, up, -ahead].entries()) {
      step.addScaledVector(axis.setFromMatrixColumn(this.camera.matrix, column), share * metres);
    }
    for (const point of [this.camera.position, this.controls.target]) point.add(step);
  }

  /** @param {KeyboardEvent} event */
  onFlyKey(event) {
    const key = event.key.toLowerCase();
    if (!(key in FLY)) return false;
    if (!event.repeat) this.move(FLY[key], FLY_STEP_S * FLY_M_S);
    this.fast = event.shiftKey;
    this.flying.add(key);
    event.preventDefault();
    event.stopPropagation();
    this.onChange();
    return true;
  }

  /** @param {number} factor */
  zoom(factor) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const length = Math.min(Math.max(offset.length() * factor, this.controls.minDistance), this.controls.maxDistance);
    this.camera.position.copy(this.controls.target).add(offset.setLength(length));
  }
}
