// An arm on a vehicle: its links turn and slide with the joints of a row of telemetry; an arrow shows the
// force that it gives to its hand, and parts of the hand that touch something light up.
/** @import { ArmLink, ArmShape, Placed, Row } from "../../server_data.d.ts" */
import * as THREE from "../../../vendor/three/three.min.js";
import { Arrow, groupOf, paint } from "./solids.js";

const ARROW_M_N = 0.01; // of the force's arrow
const TOUCH_N = 1; // from which a part of the hand feels it
const FORCE = paint(0xe03a8c);
const TOUCHED = new THREE.Color(0xe03a8c);
const UNTOUCHED = new THREE.Color(0);
const UP = new THREE.Vector3(0, 1, 0); // along which arrows point

/**
 * @param {Placed} placed
 * @returns {THREE.Group}
 */
function placedGroup({ place, turn: [roll, pitch, yaw] }) {
  const group = new THREE.Group();
  group.position.set(...place);
  group.rotation.set(roll, pitch, yaw, "ZYX");
  return group;
}

class Link {
  /**
   * @param {ArmLink} link
   */
  constructor(link) {
    const { joint, solids, touch } = link;
    this.joint = joint;
    this.touch = touch;
    this.axis = new THREE.Vector3(...(joint?.axis ?? [0, 0, 1])).normalize();
    this.group = placedGroup(link);
    this.moved = new THREE.Group();
    this.group.add(this.moved);
    const drawn = groupOf(solids);
    /** @type {THREE.MeshLambertMaterial[]} */
    this.paints = [];
    drawn.traverse((mesh) => {
      if (!touch.length || !(mesh instanceof THREE.Mesh)) return;
      mesh.material = mesh.material.clone(); // it lights up by itself
      this.paints.push(mesh.material);
    });
    this.moved.add(drawn);
  }

  /**
   * @param {Row} row
   */
  show(row) {
    const { joint, moved } = this;
    if (joint) {
      const at = joint.ratio * (row[`joint_${joint.column}`] ?? 0);
      if (joint.kind === "revolute") moved.quaternion.setFromAxisAngle(this.axis, at);
      else moved.position.copy(this.axis).multiplyScalar(at);
    }
    const touched = this.touch.some((number) => (row[`touch_${number}`] ?? 0) > TOUCH_N);
    for (const one of this.paints) one.emissive = touched ? TOUCHED : UNTOUCHED;
  }
}

export class Arm {
  /**
   * shape: of scene.json
   * @param {ArmShape} shape
   */
  constructor(shape) {
    this.group = placedGroup(shape);
    this.links = shape.links.map((link) => new Link(link));
    for (const [index, { parent }] of shape.links.entries()) {
      (parent === null ? this.group : this.links[parent].moved).add(this.links[index].group);
    }
    this.arrow = new Arrow(FORCE);
    if (shape.force_sensor) {
      const sensor = placedGroup(shape.force_sensor);
      sensor.add(this.arrow.group);
      this.links[shape.force_sensor.link].moved.add(sensor);
    }
  }

  /**
   * @param {Row} row
   */
  show(row) {
    for (const link of this.links) link.show(row);
    const force = new THREE.Vector3(row.wrist_fx ?? 0, row.wrist_fy ?? 0, row.wrist_fz ?? 0);
    const newtons = force.length();
    this.arrow.show(newtons * ARROW_M_N);
    if (newtons > 0) this.arrow.group.quaternion.setFromUnitVectors(UP, force.divideScalar(newtons));
  }
}
