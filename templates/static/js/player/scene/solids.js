// Solids of vehicles and arms, in the axes of what they belong to.
/**
 * @import { ColorRepresentation, Material, MeshLambertMaterialParameters } from "three"
 * @import { Solid, Triple } from "../../server_data.d.ts"
 */
import * as THREE from "../../../vendor/three/three.min.js";

/** @type {(color: ColorRepresentation, options?: MeshLambertMaterialParameters) => THREE.MeshLambertMaterial} */
export const paint = (color, options = {}) => new THREE.MeshLambertMaterial({ color, ...options });

/**
 * @param {THREE.BufferGeometry} geometry
 * @param {Material} material
 * @param {Triple} [place]
 */
export function part(geometry, material, [x, y, z] = [0, 0, 0]) {
  const mesh = new THREE.Mesh(geometry, material);
  mesh.position.set(x, y, z);
  return mesh;
}

/** @type {Record<Solid["shape"], (size: Triple) => THREE.BufferGeometry>} */
const GEOMETRIES = {
  box: ([x, y, z]) => new THREE.BoxGeometry(x, y, z),
  cylinder: ([x, y]) => new THREE.CylinderGeometry(y / 2, y / 2, x, 18),
  capsule: ([x, y]) => new THREE.CapsuleGeometry(y / 2, x - y, 6, 18),
  sphere: ([x]) => new THREE.SphereGeometry(x / 2, 16, 10),
};
const LENGTHWISE = ["cylinder", "capsule"]; // along the x axis

/**
 * solids: of scene.json
 * @param {Solid[]} solids
 */
export function groupOf(solids) {
  const group = new THREE.Group();
  /** @type {Map<string, Material>} */
  const paints = new Map();
  for (const { shape, size, centre, colour, livery, lettered } of solids) {
    const known = paints.get(colour) ?? paint(colour);
    paints.set(colour, known);
    const mesh = part(GEOMETRIES[shape](size), known, centre);
    if (LENGTHWISE.includes(shape)) mesh.rotation.z = Math.PI / 2;
    mesh.userData.livery = livery;
    if (lettered) mesh.userData.lettered = size;
    group.add(mesh);
  }
  return group;
}

// An arrow along y, from the origin.
export class Arrow {
  /**
   * @param {Material} material
   */
  constructor(material) {
    this.shaft = part(new THREE.CylinderGeometry(0.013, 0.013, 1, 8), material);
    this.head = part(new THREE.ConeGeometry(0.042, 0.11, 12), material);
    this.group = new THREE.Group();
    this.group.add(this.shaft, this.head);
  }

  /**
   * @param {number} length
   */
  show(length) {
    this.group.visible = length > 0.02;
    this.shaft.scale.y = Math.max(length, 0.01);
    this.shaft.position.y = length / 2;
    this.head.position.y = length + 0.05;
  }
}

const ARROW_M_N = 0.01;
const UP = new THREE.Vector3(0, 1, 0); // along which arrows point

// An arrow that is longer for a larger force.
export class ForceArrow extends Arrow {
  /**
   * @param {Material} material
   */
  constructor(material) {
    super(material);
    this.newtons = 0;
  }

  /**
   * force: in the axes of what the arrow is attached to [N]
   * @param {Triple} force
   */
  showForce(force) {
    const along = new THREE.Vector3(...force);
    this.newtons = along.length();
    this.show(this.newtons * ARROW_M_N);
    if (this.newtons > 0) this.group.quaternion.setFromUnitVectors(UP, along.divideScalar(this.newtons));
  }

  // Where its tip is, in the frame of the screen.
  tip() {
    return this.head.localToWorld(new THREE.Vector3(0, 0.08, 0));
  }
}
