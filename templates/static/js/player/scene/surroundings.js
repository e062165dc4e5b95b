// What surrounds the vehicle, in the world frame north, east, down: seabed, target, water.
/**
 * @import { ColorRepresentation } from "three"
 * @import { SceneData, SearchData, TargetShape, Triple } from "../../server_data.d.ts"
 * @import { Water } from "./water.js"
 */
import * as THREE from "../../../vendor/three/three.min.js";

const GROUND_M = 120; // side of the seabed that is drawn
const PARTICLES = 260;
// Irrational steps that spread points evenly in three dimensions.
const SPREAD = [0.8191725134, 0.6710436067, 0.5497004779];
const CLOUD_M = 7; // side of the box that the drifting particles fill, around the vehicle
const CURRENT_ARROW = 2; // [m] per m/s
const MARK = 0x7ef0c0; // colour of where a box is to be brought
const MARK_LINE_M = 0.04;
const MARK_SIDES = 64;
const ABOVE_M = 0.004; // of what is drawn on the seabed

/**
 * @param {string} address
 * @param {() => void} ready
 */
function textured(address, ready) {
  const texture = new THREE.TextureLoader().load(address, ready);
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.flipY = false;
  return texture;
}

/**
 * Columns of the texture lie along north, rows along east, as in the vehicle's camera.
 * @param {SceneData["seabed"]} ground
 * @param {string} address
 * @param {() => void} ready
 * @param {Water} water
 */
export function seabed({ depth, tile }, address, ready, water) {
  const texture = textured(address, ready);
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.minFilter = THREE.LinearMipmapNearestFilter;
  const half = GROUND_M / 2;
  const corners = [
    [-half, -half],
    [half, -half],
    [half, half],
    [-half, half],
  ];
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute(
    "position",
    new THREE.BufferAttribute(new Float32Array(corners.flatMap(([n, e]) => [n, e, depth])), 3),
  );
  geometry.setAttribute(
    "uv",
    new THREE.BufferAttribute(new Float32Array(corners.flatMap(([n, e]) => [n / tile, e / tile])), 2),
  );
  geometry.setIndex([0, 1, 2, 0, 2, 3]);
  return new THREE.Mesh(geometry, water.seen(new THREE.MeshBasicMaterial({ map: texture, side: THREE.DoubleSide })));
}

/**
 * The letters are upright for a vehicle with the target's heading.
 * @param {TargetShape} shape
 * @param {string} address
 * @param {() => void} ready
 * @param {Water} water
 */
export function target({ centre, size, heading }, address, ready, water) {
  const [length, width, height] = size;
  const group = new THREE.Group();
  group.position.set(...centre);
  group.rotation.z = heading;
  const sides = water.seen(new THREE.MeshLambertMaterial({ color: 0x1b1f22 }));
  group.add(new THREE.Mesh(new THREE.BoxGeometry(width, length, height), sides));
  // Body axes: x forward is up as one reads the letters, y starboard is to the right.
  const [up, right, z] = [width / 2, length / 2, -height / 2 - 0.002];
  /** @type {Triple[]} */
  const corners = [
    [up, -right, z],
    [up, right, z],
    [-up, right, z],
    [-up, -right, z],
  ];
  group.add(lettering(corners, address, ready, water));
  return group;
}

/**
 * A picture on a rectangle, whose corners are given as one reads: from the upper left to the lower left.
 * @param {Triple[]} corners
 * @param {string} address
 * @param {() => void} ready
 * @param {Water} water
 */
export function lettering(corners, address, ready, water) {
  const top = new THREE.BufferGeometry();
  top.setAttribute("position", new THREE.BufferAttribute(new Float32Array(corners.flat()), 3));
  top.setAttribute("uv", new THREE.BufferAttribute(new Float32Array([0, 0, 1, 0, 1, 1, 0, 1]), 2));
  top.setIndex([0, 1, 2, 0, 2, 3]);
  const material = new THREE.MeshBasicMaterial({ map: textured(address, ready), side: THREE.DoubleSide });
  return new THREE.Mesh(top, water.seen(material));
}

/**
 * The circle on the seabed that the box is to be brought to, in colours that can be seen in any water.
 * @param {SearchData} search
 * @param {number} depth
 */
export function startMark({ start, mark }, depth) {
  const points = Array.from({ length: MARK_SIDES + 1 }, (_, index) => {
    const angle = (2 * Math.PI * index) / MARK_SIDES;
    return [mark - MARK_LINE_M, mark].flatMap((radius) => [radius * Math.cos(angle), radius * Math.sin(angle), 0]);
  });
  const ring = new THREE.BufferGeometry();
  ring.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points.flat()), 3));
  ring.setIndex(
    Array.from({ length: MARK_SIDES }, (_, index) => [0, 1, 3, 0, 3, 2].map((corner) => 2 * index + corner)).flat(),
  );
  const paint = new THREE.MeshBasicMaterial({ color: MARK, side: THREE.DoubleSide });
  const mesh = new THREE.Mesh(ring, paint);
  mesh.position.set(...start, depth - ABOVE_M);
  return mesh;
}

export class CurrentArrow {
  constructor() {
    const paint = new THREE.MeshBasicMaterial({ color: 0x58d6ff });
    this.group = new THREE.Group();
    this.shaft = new THREE.Mesh(new THREE.CylinderGeometry(0.025, 0.025, 1, 10), paint);
    this.head = new THREE.Mesh(new THREE.ConeGeometry(0.08, 0.2, 14), paint);
    this.group.add(this.shaft, this.head);
  }

  /**
   * current: [north, east, down] m/s; at: where it starts
   * @param {Triple} current
   * @param {THREE.Vector3} at
   */
  show(current, at) {
    const direction = new THREE.Vector3(...current);
    const length = direction.length() * CURRENT_ARROW;
    this.group.visible = length > 0.01;
    if (!this.group.visible) return;
    this.group.position.copy(at);
    this.group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), direction.normalize());
    this.shaft.scale.y = length;
    this.shaft.position.y = length / 2;
    this.head.position.y = length + 0.1;
  }
}

// Particles that drift with the current through a box around the vehicle.
export class Particles {
  /**
   * @param {number} depth
   * @param {Water} water
   */
  constructor(depth, water) {
    this.depth = depth;
    this.drift = new THREE.Vector3();
    this.start = Array.from(
      { length: 3 * PARTICLES },
      (_, index) => CLOUD_M * ((Math.floor(index / 3) * SPREAD[index % 3]) % 1),
    );
    this.geometry = new THREE.BufferGeometry();
    this.positions = new THREE.BufferAttribute(new Float32Array(3 * PARTICLES), 3).setUsage(THREE.DynamicDrawUsage);
    this.geometry.setAttribute("position", this.positions);
    const paint = new THREE.PointsMaterial({ color: 0xd8f0f2, size: 0.035, transparent: true, opacity: 0.75 });
    this.points = new THREE.Points(this.geometry, water.seen(paint));
    this.points.frustumCulled = false;
  }

  /**
   * @param {Triple} current
   * @param {THREE.Vector3} centre
   * @param {number} seconds
   */
  show(current, centre, seconds) {
    this.drift.addScaledVector(new THREE.Vector3(...current), seconds);
    const low = [centre.x - CLOUD_M / 2, centre.y - CLOUD_M / 2, this.depth - CLOUD_M];
    const drift = this.drift.toArray();
    const values = this.positions.array;
    for (let index = 0; index < values.length; index += 1) {
      const axis = index % 3;
      const place = this.start[index] + drift[axis] - low[axis];
      values[index] = low[axis] + (((place % CLOUD_M) + CLOUD_M) % CLOUD_M);
    }
    this.positions.needsUpdate = true;
  }
}

// A line through points that change.
export class Trace {
  /**
   * @param {ColorRepresentation} color
   * @param {number} points
   * @param {{segments?: boolean, opacity?: number}} [options]
   */
  constructor(color, points, { segments = false, opacity = 1 } = {}) {
    this.positions = new THREE.BufferAttribute(new Float32Array(3 * points), 3).setUsage(THREE.DynamicDrawUsage);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", this.positions);
    const paint = new THREE.LineBasicMaterial({ color, transparent: opacity < 1, opacity });
    this.line = segments ? new THREE.LineSegments(geometry, paint) : new THREE.Line(geometry, paint);
    this.line.frustumCulled = false;
    this.points = points;
  }

  /**
   * points: [[north, east, down], ...]; of more than there is room for, every n-th
   * @param {Triple[]} points
   */
  show(points) {
    const every = Math.max(Math.ceil(points.length / this.points), 1);
    const kept = points.filter((_, index) => index % every === (points.length - 1) % every);
    for (const [index, point] of kept.entries()) this.positions.setXYZ(index, ...point);
    this.positions.needsUpdate = true;
    this.line.geometry.setDrawRange(0, kept.length);
  }
}
