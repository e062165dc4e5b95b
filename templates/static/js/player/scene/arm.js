// An arm on a vehicle: its links turn and slide with the joints of a row of telemetry; an arrow shows the
// force that it gives to its hand, and parts of the hand that touch something light up.
/**
 * @import { Group } from "three"
 * @import { ArmLink, ArmShape, Row } from "../../server_data.d.ts"
 */
import * as THREE from "../../../vendor/three/three.min.js";
import { chain, Link, placedGroup } from "./links.js";
import { ForceArrow, paint } from "./solids.js";

const TOUCH_N = 1; // from which a part of the hand feels it
const FORCE = paint(0xe03a8c);
const TOUCHED = new THREE.Color(0xe03a8c);
const UNTOUCHED = new THREE.Color(0);

class ArmPart extends Link {
  /**
   * @param {ArmLink} link
   */
  constructor(link) {
    super(link);
    this.joint = link.joint;
    this.touch = link.touch;
    /** @type {THREE.MeshLambertMaterial[]} */
    this.paints = [];
    this.drawn.traverse((mesh) => {
      if (!this.touch.length || !(mesh instanceof THREE.Mesh)) return;
      mesh.material = mesh.material.clone(); // it lights up by itself
      this.paints.push(mesh.material);
    });
  }

  /**
   * @param {Row} row
   */
  show(row) {
    const { joint } = this;
    if (joint) this.move(joint, joint.ratio * (row[`joint_${joint.column}`] ?? 0));
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
    this.links = shape.links.map((link) => new ArmPart(link));
    chain(this.group, this.links, shape.links);
    this.arrow = new ForceArrow(FORCE);
    /** @type {Group | null} */
    this.sensor = null;
    if (shape.force_sensor) {
      this.sensor = placedGroup(shape.force_sensor);
      this.sensor.add(this.arrow.group);
      this.links[shape.force_sensor.link].moved.add(this.sensor);
    }
  }

  /** @param {boolean} onBoard */
  setOnBoard(onBoard) {
    if (this.sensor) this.sensor.visible = !onBoard;
  }

  /**
   * @param {Row} row
   */
  show(row) {
    for (const link of this.links) link.show(row);
    this.arrow.showForce([row.wrist_fx ?? 0, row.wrist_fy ?? 0, row.wrist_fz ?? 0]);
  }
}
