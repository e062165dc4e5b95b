// What an arm works on: things in the world, one of whose links moves with the columns of the workpiece. Where
// the hand touches it, a mark and an arrow show where and how hard.
/**
 * @import { Material, Object3D } from "three"
 * @import { Row, Triple, WorkLink, WorkShape } from "../../server_data.d.ts"
 * @import { SceneMoment } from "./actor.js"
 * @import { Aim } from "./sight.js"
 * @import { Water } from "./water.js"
 */
import * as THREE from "../../../vendor/three/three.min.js";
import { chain, Link, placedGroup } from "./links.js";
import { ForceArrow, paint, part } from "./solids.js";
import { lettering } from "./surroundings.js";
import { repaint } from "./vehicle.js";

// In front of the hand, which would hide arrow and mark.
const IN_FRONT = { depthTest: false, transparent: true };
const PUSH = paint(0x8ee04a, { emissive: 0x3c6a14, ...IN_FRONT });
const MARK_M = 0.022;
const LETTERS_M = 0.002; // above the box

class Part extends Link {
  /**
   * @param {WorkLink} link
   */
  constructor(link) {
    super(link);
    this.joint = link.joint;
    this.isDecoy = link.joint?.kind === "free" && link.joint.of === "decoy";
  }

  /**
   * @param {SceneMoment} moment
   */
  show({ row, work, decoy }) {
    const { joint, moved } = this;
    if (!joint) return;
    if (joint.kind !== "free") {
      this.move(joint, joint.ratio * (row.workpiece_joint ?? 0));
      return;
    }
    const pose = this.isDecoy ? decoy : work;
    if (!pose) return;
    moved.position.set(pose.x, pose.y, pose.z);
    moved.rotation.set(pose.roll, pose.pitch, pose.yaw, "ZYX");
  }
}

export class Work {
  /**
   * shape: of scene.json; letters, decoy: addresses of the pictures of what is written on it and on what looks like it;
   * colour: CSS, where several runs are shown; a ghost is only what moves
   * @param {WorkShape} shape
   * @param {{letters: string, decoy: string, ready: () => void, water: Water, colour?: string, ghost: boolean}} options
   */
  constructor(shape, { letters, decoy, ready, water, colour, ghost }) {
    this.group = new THREE.Group();
    this.face = shape.face;
    this.parts = shape.things.map((thing) => {
      const parts = thing.links.map((link) => new Part(link));
      const placed = placedGroup(thing);
      chain(placed, parts, thing.links);
      this.group.add(placed);
      for (const { joint, moved } of parts) if (joint?.kind === "free") this.group.add(moved);
      return parts;
    });
    for (const { drawn, joint, isDecoy } of this.parts.flat()) {
      if (ghost && !joint) drawn.visible = false;
      // The box of a run has its colour, what looks like it keeps its own.
      if (ghost || (colour && !isDecoy)) repaint(drawn, colour, ghost);
      else {
        soak(drawn, water);
        write(drawn, (corners) => lettering(corners, isDecoy ? decoy : letters, ready, water));
      }
    }
    this.contact = new Contact();
  }

  /**
   * @param {SceneMoment | null} moment
   */
  show(moment) {
    this.group.visible = moment !== null;
    this.contact.show(moment?.row ?? null);
    if (!moment) return;
    for (const one of this.parts.flat()) one.show(moment);
    this.group.updateMatrixWorld(true);
  }

  /**
   * Where its face is in the world: north, east, down.
   * @returns {Aim}
   */
  aim() {
    const { link, corners } = this.face;
    const moved = link && this.parts[link[0]][link[1]].moved;
    const toWorld = moved ? this.group.matrixWorld.clone().invert().multiply(moved.matrixWorld) : new THREE.Matrix4();
    const outline = corners.map((corner) => new THREE.Vector3(...corner).applyMatrix4(toWorld));
    const centre = outline.reduce((sum, corner) => sum.add(corner), new THREE.Vector3()).divideScalar(outline.length);
    return { centre: centre.toArray(), outline: outline.map((corner) => corner.toArray()) };
  }
}

/**
 * Water lies before it as before the target.
 * @param {Object3D} group
 * @param {Water} water
 */
function soak(group, water) {
  /** @type {Set<Material>} */
  const paints = new Set();
  group.traverse((mesh) => mesh instanceof THREE.Mesh && paints.add(mesh.material));
  for (const one of paints) water.seen(one);
}

/**
 * Puts letters onto the upper sides of boxes that have some.
 * @param {Object3D} group
 * @param {(corners: Triple[]) => Object3D} made
 */
function write(group, made) {
  /** @type {Object3D[]} */
  const lettered = [];
  group.traverse((mesh) => mesh.userData.lettered && lettered.push(mesh));
  for (const mesh of lettered) {
    const [x, y, z] = mesh.userData.lettered.map((/** @type {number} */ side) => side / 2);
    const top = -z - LETTERS_M;
    mesh.add(
      made([
        [-x, -y, top],
        [x, -y, top],
        [x, y, top],
        [-x, y, top],
      ]),
    );
  }
}

// A mark at the tool while the arm touches the workpiece, and the force that it gives.
class Contact {
  constructor() {
    this.group = new THREE.Group();
    this.arrow = new ForceArrow(PUSH);
    const light = new THREE.MeshBasicMaterial({ color: 0xfff27a, ...IN_FRONT });
    this.mark = part(new THREE.SphereGeometry(MARK_M, 12, 8), light);
    for (const mesh of [this.arrow.shaft, this.arrow.head]) mesh.renderOrder = 1;
    this.mark.renderOrder = 2;
    this.group.add(this.arrow.group, this.mark);
  }

  /**
   * @param {Row | null} row
   */
  show(row) {
    this.group.visible = row !== null && (row.work_arm_n ?? 0) > 0;
    if (!row || !this.group.visible) return;
    this.group.position.set(row.tool_x ?? 0, row.tool_y ?? 0, row.tool_z ?? 0);
    this.arrow.showForce([row.work_fx ?? 0, row.work_fy ?? 0, row.work_fz ?? 0]);
  }
}
