// The 3-D scene of a run. The world group is in the frame of the telemetry (north, east, down); outside
// of it, y is up. It draws only when something has changed, at a resolution that the machine can keep up with.
import * as THREE from "../../../vendor/three/three.min.js";
import { Cameras } from "./cameras.js";
import { CurrentArrow, Particles, seabed, target, Trace } from "./surroundings.js";
import { Vehicle } from "./vehicle.js";

const TRAIL_POINTS = 500;
const SLOW_MS = 45; // longer between two pictures: fewer pixels
const FAST_MS = 24;
const PASSED_MAX_MS = 2000;
const SETTLE_PICTURES = 5; // measured before the resolution changes
const SETTLE_MS = 3000; // after a change; each costs as much as several pictures
const REST_MS = 500; // without a new picture until the last one is drawn with all pixels
const SCALE_MIN = 0.35;
const SCALE_OF_SOFTWARE = 0.5; // at first, without a graphics card
const PIXELS_MAX = 2; // per CSS pixel
const STILL = matchMedia("(prefers-reduced-motion: reduce)");
// North, east, down in a frame whose x is east, y up and z south.
const TO_SCREEN = new THREE.Matrix4().set(0, 1, 0, 0, 0, 0, -1, 0, -1, 0, 0, 0, 0, 0, 0, 1);

// Whether there is WebGL 2, and whether it is computed without a graphics card.
export function graphics() {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return { canDraw: false, software: false };
  const details = gl.getExtension("WEBGL_debug_renderer_info");
  const name = gl.getParameter(details ? details.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
  return { canDraw: true, software: /swiftshader|llvmpipe|software|basic render/i.test(name) };
}

export class SceneView {
  constructor(box, { software, onDraw }) {
    this.box = box;
    this.onDraw = onDraw;
    const antialias = !software && devicePixelRatio < 2;
    this.renderer = new THREE.WebGLRenderer({ antialias, powerPreference: "low-power" });
    this.canvas = this.renderer.domElement;
    this.scene = new THREE.Scene();
    this.world = new THREE.Group();
    this.world.matrixAutoUpdate = false;
    this.world.matrix.copy(TO_SCREEN);
    const sun = new THREE.DirectionalLight(0xffffff, 1.6);
    sun.position.set(-2, 6, 1);
    this.scene.add(this.world, new THREE.HemisphereLight(0xd7f3ff, 0x6b6048, 1.5), sun);
    this.scene.background = new THREE.Color(0x0b3d4f);
    this.scene.fog = new THREE.FogExp2(0x0b3d4f, 0.05);
    this.cameras = new Cameras(this.canvas, () => this.request());
    this.current = new CurrentArrow();
    this.trail = new Trace(0xffe08a, TRAIL_POINTS);
    this.frustum = new Trace(0x9fe8ff, 16, { segments: true, opacity: 0.7 });
    this.sight = new Trace(0xff5fa2, 2);
    this.fog = true;
    this.scale = software ? SCALE_OF_SOFTWARE : 1;
    this.moved = this.sharp = false;
    this.drawn = { at: 0, mean: 30, count: 0, moved: false, resized: 0 };
    this.renderer.debug.checkShaderErrors = false; // asking for them waits for the compilation
    new ResizeObserver(() => this.resize()).observe(box);
    box.append(this.canvas);
    this.resize();
  }

  // description: of scene.json; textures: addresses of the seabed's and the target's picture
  describe(description, textures) {
    this.description = description;
    this.world.clear();
    const ready = () => this.request();
    const { depth } = description.seabed;
    this.vehicle = new Vehicle(description.vehicle);
    const heights = (description.vehicle?.hull ?? []).map(({ centre, size }) => size[2] / 2 - centre[2]);
    this.clearance = Math.max(0.1, ...heights) + 0.3; // of the current's arrow above the vehicle
    this.target = target(description.target, textures.target, ready);
    this.particles = new Particles(depth);
    this.world.add(
      seabed(description.seabed, textures.seabed, ready), this.target, this.vehicle.group, this.current.group,
      this.particles.points, this.trail.line, this.frustum.line, this.sight.line,
    );
    this.cameras.describe(description);
    const veil = description.water.veil.map((share) => Math.min(0.15 + share, 1));
    this.water = new THREE.Color().setRGB(...veil, THREE.SRGBColorSpace);
    this.scene.background = this.scene.fog.color = this.water;
    if (this.last) this.show(this.last);
    else this.request();
  }

  // The water of another level.
  setWater(water) {
    this.description.water = water;
    this.water.setRGB(...water.veil.map((share) => Math.min(0.15 + share, 1)), THREE.SRGBColorSpace);
    this.request();
  }

  // pose: interpolated; row: as recorded; trail: rows before; seconds: simulated, since the last picture
  show({ pose, row, trail, seconds }) {
    this.last = { pose, row, trail, seconds: 0 };
    this.moved = seconds > 0;
    if (this.moved && this.sharp) this.setSharp(false);
    if (!this.vehicle) return;
    const moved = STILL.matches ? 0 : seconds;
    const current = ["current_x", "current_y", "current_z"].map((name) => row[name] ?? 0);
    this.vehicle.show(pose, row, moved);
    const { position } = this.vehicle.group;
    this.current.show(current, new THREE.Vector3(position.x, position.y, position.z - this.clearance));
    this.particles.show(current, position, moved);
    this.trail.show([...trail.map(({ x, y, z }) => [x, y, z]), position.toArray()]);
    this.showSight();
    this.cameras.follow(this.vehicle.group);
    this.request();
  }

  // The camera's field of view down to the seabed, and the line from the camera to the target.
  showSight() {
    const { mount, focal, width, height } = this.description.camera;
    const { group } = this.vehicle;
    group.updateMatrix();
    const eye = new THREE.Vector3(...mount).applyMatrix4(group.matrix);
    const { depth } = this.description.seabed;
    // Image right is starboard (y), image down is aft (-x), the optical axis is down (z).
    const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([u, v]) => {
      const ray = new THREE.Vector3((-v * height) / 2 / focal, (u * width) / 2 / focal, 1).applyQuaternion(group.quaternion);
      const reach = ray.z > 0.05 ? Math.min((depth - eye.z) / ray.z, 12) : 12;
      return eye.clone().addScaledVector(ray, Math.max(reach, 0)).toArray();
    });
    const lines = corners.flatMap((corner, index) => [eye.toArray(), corner, corner, corners[(index + 1) % 4]]);
    this.frustum.show(lines);
    this.sight.show([eye.toArray(), this.target.position.toArray()]);
  }

  setMode(mode) {
    const onBoard = mode === "camera";
    for (const { line } of [this.trail, this.frustum, this.sight]) line.visible = !onBoard;
    if (this.vehicle) this.vehicle.group.visible = !onBoard;
    this.current.group.visible = !onBoard;
    this.cameras.setMode(mode);
    if (this.last) this.show(this.last);
    this.request();
  }

  setFog(fog) {
    this.fog = fog;
    this.request();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.box;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, PIXELS_MAX) * (this.sharp ? 1 : this.scale));
    this.renderer.setSize(width, height, false);
    this.cameras.resize(width, height);
    this.request();
  }

  request() {
    if (this.requested) return;
    this.requested = true;
    requestAnimationFrame((now) => this.draw(now));
  }

  draw(now) {
    this.requested = false;
    if (!this.vehicle) return;
    this.adapt(now);
    const camera = this.cameras.update();
    this.scene.fog.density = this.density(camera);
    this.renderer.render(this.scene, camera);
    this.onDraw(this);
    clearTimeout(this.rest);
    if (!this.sharp && this.scale < 1) this.rest = setTimeout(() => this.setSharp(true), REST_MS);
  }

  // A picture that stays has all pixels, however long it takes.
  setSharp(sharp) {
    this.sharp = sharp;
    this.resize();
  }

  // From outside the fog is thinned, so that vehicle and target can be seen in any water.
  density(camera) {
    if (!this.fog) return 0.02;
    const [, green] = this.description.water.attenuation;
    const distance = camera.position.distanceTo(this.vehicle.group.position.clone().applyMatrix4(TO_SCREEN));
    return this.cameras.mode === "camera" ? green : Math.min(green, 0.5 / Math.max(distance, 0.5));
  }

  // Fewer pixels if pictures of a scene that moves take long, more again if there is time.
  adapt(now) {
    const { drawn } = this;
    const passed = Math.min(now - drawn.at, PASSED_MAX_MS);
    const moves = this.moved && drawn.moved;
    Object.assign(drawn, { at: now, moved: this.moved });
    if (!moves) return;
    drawn.mean += (passed - drawn.mean) / SETTLE_PICTURES;
    drawn.count += 1;
    if (drawn.count < SETTLE_PICTURES || now - drawn.resized < SETTLE_MS) return;
    const { mean } = drawn;
    // The time for a picture goes with its pixels, the square of the scale.
    const factor = mean > SLOW_MS ? Math.max(Math.sqrt(SLOW_MS / mean), 0.6) : mean < FAST_MS ? 1.1 : 1;
    const scale = Math.min(Math.max(this.scale * factor, SCALE_MIN), 1);
    if (Math.abs(scale - this.scale) < 0.01) return;
    Object.assign(drawn, { count: 0, resized: now });
    this.scale = scale;
    this.resize();
  }
}
