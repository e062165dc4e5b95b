// Links of arms and things: each has its place on its parent, and may turn or slide on an axis.
/** @import { Placed, Solid, Triple } from "../../server_data.d.ts" */
import * as THREE from "../../../vendor/three/three.min.js";
import { groupOf } from "./solids.js";

/**
 * @param {Placed} placed
 * @returns {THREE.Group}
 */
export function placedGroup({ place, turn: [roll, pitch, yaw] }) {
  const group = new THREE.Group();
  group.position.set(...place);
  group.rotation.set(roll, pitch, yaw, "ZYX");
  return group;
}

/** @typedef {{kind: "revolute" | "prismatic", axis: Triple}} Axis */

export class Link {
  /**
   * @param {Placed & {solids: Solid[]}} link
   */
  constructor(link) {
    this.group = placedGroup(link);
    this.moved = new THREE.Group();
    this.drawn = groupOf(link.solids);
    this.moved.add(this.drawn);
    this.group.add(this.moved);
  }

  /**
   * at: coordinate of the joint [rad or m]
   * @param {Axis} joint
   * @param {number} at
   */
  move({ kind, axis }, at) {
    const along = new THREE.Vector3(...axis).normalize();
    if (kind === "revolute") this.moved.quaternion.setFromAxisAngle(along, at);
    else this.moved.position.copy(along).multiplyScalar(at);
  }
}

/**
 * Hangs each link on its parent, and those without one on a group.
 * @param {THREE.Group} group
 * @param {Link[]} links
 * @param {{parent: number | null}[]} shapes
 */
export function chain(group, links, shapes) {
  for (const [index, { parent }] of shapes.entries()) {
    (parent === null ? group : links[parent].moved).add(links[index].group);
  }
}
