// The 3-D scene of one run, or of several as ghosts. The world group is in the frame of the telemetry
// (north, east, down); outside of it, y is up. It draws only when something has changed.
/**
 * @import { Camera } from "three"
 * @import { LightData, RouteData, Row, SceneData, TargetShape, Triple } from "../../server_data.d.ts"
 * @import { VehicleShape, WaterData, WorkShape } from "../../server_data.d.ts"
 * @import { SceneMoment } from "./actor.js"
 * @import { Aim } from "./sight.js"
 * @import { ForceArrow } from "./solids.js"
 * @import { Vehicle } from "./vehicle.js"
 */
import * as THREE from "../../../vendor/three/three.min.js";
import { offSeat } from "../numbers.js";
import { Actor } from "./actor.js";
import { Cameras } from "./cameras.js";
import { Course } from "./course.js";
import { Label } from "./label.js";
import { LampCone } from "./lamp.js";
import { Pace } from "./pace.js";
import { Pointer } from "./pointer.js";
import { Shadow } from "./shadow.js";
import { aimAt, Sight } from "./sight.js";
import { CurrentArrow, Particles, seabed, startMark, target } from "./surroundings.js";
import { Water } from "./water.js";
import { Work } from "./work.js";

const LABELLED_N = 1; // of an arrow that has its newtons beside it
const REST_MS = 500; // without a new picture until the last one is drawn with all pixels
// Without a graphics card: pictures of what moves by itself take a core or two if nothing limits them.
const SCALE_OF_SOFTWARE = 0.5;
const EVERY_MS = 80;
const SCALE_OF_SHADOW = 0.4; // more than this to draw one while the scene moves
const PIXELS_MAX = 2; // per CSS pixel
/** @type {Triple} */
const SUN = [0.17, 0.33, 1]; // north, east, down: where the light goes
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

/**
 * scene.json, with the vehicles of which the first is followed.
 * @typedef {SceneData & {vehicles: {shape: VehicleShape | null, work?: WorkShape, colour?: string}[]}} Description
 */

export class SceneView {
  /**
   * @param {HTMLElement} box
   * @param {{software: boolean, onDraw: (view: SceneView) => void}} options
   */
  constructor(box, { software, onDraw }) {
    this.box = box;
    this.onDraw = onDraw;
    const antialias = !software && devicePixelRatio < 2;
    this.renderer = new THREE.WebGLRenderer({ antialias, stencil: true, powerPreference: "low-power" });
    this.canvas = this.renderer.domElement;
    this.scene = new THREE.Scene();
    this.world = new THREE.Group();
    this.world.matrixAutoUpdate = false;
    this.world.matrix.copy(TO_SCREEN);
    const sun = new THREE.DirectionalLight(0xffffff, 1.6);
    sun.position
      .set(...SUN)
      .negate()
      .applyMatrix4(TO_SCREEN);
    this.scene.add(this.world, new THREE.HemisphereLight(0xd7f3ff, 0x6b6048, 1.5), sun);
    this.water = new Water();
    this.scene.background = this.water.colour;
    this.cameras = new Cameras(this.canvas, () => this.request());
    this.current = new CurrentArrow();
    this.sight = new Sight();
    const [station, vehicle, boat] = ["station", "vehicle", "boat"].map((name) => new Pointer(box, name));
    this.pointers = { station, vehicle, boat };
    this.labels = { wrist: new Label(box, "wrist"), push: new Label(box, "push") };
    this.outside = new THREE.Group(); // what is not to be seen from on board
    /** @type {Actor[]} */
    this.actors = [];
    /** @type {(Work | null)[]} what the arm of each works on */
    this.works = [];
    /** @type {Aim | null} where the target is now */
    this.aim = null;
    /** @type {Description | null} */
    this.description = null;
    /** @type {(SceneMoment | null)[] | null} what is shown */
    this.last = null;
    /** @type {Particles | null} */
    this.particles = null;
    /** @type {Shadow | null} */
    this.shadow = null;
    /** @type {LampCone | null} */
    this.lamp = null;
    /** @type {Course | null} */
    this.course = null;
    /** @type {THREE.Group | null} */
    this.target = null;
    this.clearance = 0; // of the current's arrow above the vehicle [m]
    this.requested = false;
    this.watched = true; // by somebody, or by a recorder
    this.stale = false; // was to be drawn, but nobody watches
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.rest = undefined;
    this.every = software ? EVERY_MS : 0;
    this.drawnAt = 0; // [ms]
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.waiting = undefined;
    this.pace = software ? new Pace(SCALE_OF_SOFTWARE, EVERY_MS) : new Pace(1);
    this.moved = this.sharp = false;
    this.renderer.debug.checkShaderErrors = false; // asking for them waits for the compilation
    new ResizeObserver(() => this.resize()).observe(box);
    box.append(this.canvas);
    this.resize();
  }

  /**
   * description: {target, seabed, camera, water} of scene.json and `vehicles`: [{shape, colour}, ...], of which
   * the first is followed; textures: addresses of the pictures of the seabed, the target and what looks like it
   * @param {Description} description
   * @param {{seabed: string, target: string, decoy: string}} textures
   */
  describe(description, textures) {
    this.description = description;
    this.world.clear();
    const ready = () => this.request();
    this.actors = description.vehicles.map((vehicle, index) => new Actor(vehicle, { ghost: index > 0 }));
    const [{ shape }] = description.vehicles;
    const [followed, ...ghosts] = this.actors.map(({ group }) => group);
    const heights = (shape?.hull ?? []).map(({ centre, size }) => size[2] / 2 - centre[2]);
    this.clearance = Math.max(0.1, ...heights) + 0.3;
    const { camera, light, water } = description;
    const { depth } = description.seabed;
    this.water.clear();
    this.water.set(water, light);
    this.works = description.vehicles.map(({ work, colour }, index) => {
      const letters = { letters: textures.target, decoy: textures.decoy };
      const options = { ...letters, ready, water: this.water, colour, ghost: index > 0 };
      return work ? new Work(work, options) : null;
    });
    this.aim = description.route || !description.target ? null : aimAt(description.target);
    this.target =
      description.target && !this.works[0] ? target(description.target, textures.target, ready, this.water) : null;
    this.particles = new Particles(depth, this.water);
    const { vehicle } = this.actors[0];
    this.shadow = new Shadow(vehicle.hull, depth, SUN, this.water);
    this.lamp = light.lamp > 0 ? new LampCone(light, camera.mount, depth) : null;
    if (this.lamp) vehicle.group.add(this.lamp.mesh);
    this.world.add(
      seabed(description.seabed, textures.seabed, ready, this.water),
      ...(this.target ? [this.target] : []),
      ...(description.search ? [startMark(description.search, depth)] : []),
      ...this.works.flatMap((work) => work?.group ?? []),
      this.particles.points,
      this.outside,
      followed,
      ...ghosts,
    );
    this.outside.clear();
    this.outside.add(this.shadow.mesh, this.current.group, this.sight.group);
    if (this.works[0]) this.outside.add(this.works[0].contact.group);
    this.cameras.describe(description);
    this.setRoute(description.route);
    if (this.last) this.show(this.last, 0);
    else this.request();
  }

  /**
   * Water and light of another level.
   * @param {WaterData} water
   * @param {LightData} light
   */
  setWater(water, light) {
    if (this.description) Object.assign(this.description, { water, light });
    this.water.set(water, light);
    this.request();
  }

  /**
   * The target of another level, which may have another path.
   * @param {TargetShape | null} target
   */
  setTarget(target) {
    if (this.description) this.description.target = target;
    if (this.last) this.show(this.last, 0);
  }

  /**
   * Puts a target that moves by itself where it is at a row.
   * @param {Description} description
   * @param {Row} row
   */
  moveTarget(description, row) {
    const shape = description.target;
    if (!shape?.path || !this.target) return;
    const { start, period, places } = shape.path;
    const image = Math.round((row.t - start) / period);
    const [north, east, heading] = places[Math.min(Math.max(image, 0), places.length - 1)];
    /** @type {Triple} */
    const centre = [north, east, shape.centre[2]];
    this.target.position.set(...centre);
    this.target.rotation.z = heading;
    this.aim = aimAt({ ...shape, centre, heading });
    this.cameras.aimAt(this.aim.centre);
  }

  /**
   * The route of a level, if one is followed.
   * @param {RouteData | undefined} route
   */
  setRoute(route) {
    const { description, course } = this;
    if (course) {
      this.world.remove(course.group);
      this.outside.remove(course.outside);
    }
    if (!description) return;
    this.course = route ? new Course(route, description.seabed.depth) : null;
    description.route = route;
    this.cameras.setRoute(route ? route.points : []);
    if (!this.course) return;
    this.world.add(this.course.group);
    this.outside.add(this.course.outside);
    if (this.last) this.show(this.last, 0);
  }

  /**
   * The vehicle that is followed; undefined before the first `describe`.
   * @returns {Vehicle | undefined}
   */
  get vehicle() {
    return this.actors[0]?.vehicle;
  }

  /**
   * moments: of each vehicle {pose: interpolated, row: as recorded, trail: rows before}, null without telemetry;
   * seconds: simulated, since the last picture
   * @param {(SceneMoment | null)[]} moments
   * @param {number} seconds
   */
  show(moments, seconds) {
    this.last = moments;
    this.moved = seconds > 0;
    if (this.moved && this.sharp) this.setSharp(false);
    const { vehicle, description } = this;
    if (!vehicle || !description) return;
    const moved = STILL.matches ? 0 : seconds;
    for (const [index, actor] of this.actors.entries()) {
      actor.show(moments[index] ?? null, moved);
      this.works[index]?.show(moments[index] ?? null);
    }
    const [work] = this.works;
    this.aim = work && moments[0] ? work.aim() : this.aim;
    if (work && this.aim) this.cameras.aimAt(this.aim.centre);
    if (moments[0]) this.moveTarget(description, moments[0].row);
    if (moments[0]) this.showAround(vehicle, description, moments[0].row, moved);
    const shown = this.actors.filter(({ group }) => group.visible);
    if (this.cameras.mode === "all") this.cameras.frame(shown.map((actor) => actor.vehicle.group.position));
    this.requestInTime();
  }

  /**
   * What goes with the vehicle that is followed.
   * @param {Vehicle} vehicle
   * @param {Description} description
   * @param {Row} row
   * @param {number} seconds
   */
  showAround(vehicle, description, row, seconds) {
    const { group } = vehicle;
    const { position } = group;
    /** @type {Triple} */
    const current = [row.current_x ?? 0, row.current_y ?? 0, row.current_z ?? 0];
    this.current.show(current, new THREE.Vector3(position.x, position.y, position.z - this.clearance));
    this.particles?.show(current, position, seconds);
    group.updateMatrix();
    this.sight.show(group, description, this.aim);
    this.course?.show(position, row);
    this.shadow?.show(group);
    this.lamp?.show(group);
    this.water.lookFrom(group, description.camera.mount, TO_SCREEN);
    this.cameras.follow(group);
  }

  /** @param {string} mode */
  setMode(mode) {
    const onBoard = mode === "camera";
    this.outside.visible = !onBoard;
    this.actors[0]?.setOnBoard(onBoard);
    if (this.lamp) this.lamp.mesh.visible = !onBoard;
    this.cameras.setMode(mode);
    if (this.last) this.show(this.last, 0);
    this.request();
  }

  /** @param {boolean} turbid */
  setTurbid(turbid) {
    this.water.setTurbid(turbid);
    this.request();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.box;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, PIXELS_MAX) * (this.sharp ? 1 : this.pace.scale));
    this.renderer.setSize(width, height, false);
    this.cameras.resize(width, height);
    this.request();
  }

  /**
   * Draws only while it is watched, and at once what has changed meanwhile.
   * @param {boolean} watched
   */
  setWatched(watched) {
    this.watched = watched;
    this.pace.moved = false; // the pause is not the time that a picture takes
    if (watched && this.stale) this.request();
  }

  request() {
    this.stale = !this.watched;
    if (this.requested || this.stale) return;
    this.requested = true;
    clearTimeout(this.waiting);
    this.waiting = undefined;
    requestAnimationFrame((now) => this.draw(now));
  }

  // A picture at once, unless it is the next one of what moves by itself.
  requestInTime() {
    const wait = this.moved ? this.drawnAt + this.every - performance.now() : 0;
    if (wait <= 0) this.request();
    else if (this.waiting === undefined) this.waiting = setTimeout(() => this.request(), wait);
  }

  /** @param {number} now */
  draw(now) {
    this.requested = false;
    const { vehicle, description } = this;
    if (!vehicle || !description) return;
    if (this.pace.drawn(now, this.moved)) this.resize();
    const camera = this.cameras.update();
    // Rather pixels than a shadow.
    if (this.shadow) this.shadow.mesh.visible = this.sharp || this.pace.scale > SCALE_OF_SHADOW;
    this.renderer.render(this.scene, camera);
    this.drawnAt = now;
    this.point(vehicle, camera);
    this.label(vehicle, camera);
    this.onDraw(this);
    clearTimeout(this.rest);
    if (!this.sharp && this.pace.scale < 1) this.rest = setTimeout(() => this.setSharp(true), REST_MS);
  }

  /**
   * Arrows to what is out of sight: station or boat, and the vehicle if one looks elsewhere.
   * @param {Vehicle} followed
   * @param {Camera} camera
   */
  point(followed, camera) {
    const { station, vehicle, boat } = this.pointers;
    /** @type {(place: Triple) => THREE.Vector3} */
    const place = ([x, y, z]) => new THREE.Vector3(x, y, z).applyMatrix4(TO_SCREEN);
    const row = this.last?.[0]?.row;
    const docks = row?.dock_ahead !== undefined;
    const distance = docks ? offSeat(row) : this.works[0] ? row?.reach : row?.distance;
    const away = typeof distance === "number" ? `${distance.toFixed(1)} m` : "";
    station.name = docks ? "dock" : this.works[0] ? "workpiece" : "station";
    if (this.aim) station.show(camera, place(this.aim.centre), away);
    else station.hide();
    const route = this.description?.route;
    if (route) {
      const off = followed.group.position.distanceTo(new THREE.Vector3(...route.boat));
      boat.show(camera, place(route.boat), `${off.toFixed(0)} m`);
    } else boat.hide();
    if (this.cameras.mode === "camera") vehicle.hide();
    else vehicle.show(camera, place(followed.group.position.toArray()), "");
  }

  /**
   * The newtons of the arrows at the hand.
   * @param {Vehicle} followed
   * @param {Camera} camera
   */
  label(followed, camera) {
    const contact = this.works[0]?.contact;
    /** @type {[Label, ForceArrow | undefined, boolean][]} */
    const labelled = [
      [this.labels.wrist, followed.arm?.arrow, true],
      [this.labels.push, contact?.arrow, contact?.group.visible ?? false],
    ];
    for (const [label, arrow, shown] of labelled) {
      const visible = arrow && shown && arrow.group.visible && arrow.newtons >= LABELLED_N;
      if (!visible || this.cameras.mode === "camera") label.hide();
      else label.show(camera, arrow.tip(), `${arrow.newtons.toFixed(0)} N`);
    }
  }

  /**
   * Draws a picture of its own size, which `use` takes from the canvas at once.
   * @param {[number, number]} size
   * @param {(canvas: HTMLCanvasElement) => void} use
   */
  picture([width, height], use) {
    this.renderer.setPixelRatio(1);
    this.renderer.setSize(width, height, false);
    this.cameras.resize(width, height);
    this.renderer.render(this.scene, this.cameras.update());
    use(this.canvas);
    this.resize();
  }

  /**
   * A picture that stays has all pixels, however long it takes.
   * @param {boolean} sharp
   */
  setSharp(sharp) {
    this.sharp = sharp;
    this.resize();
  }
}
