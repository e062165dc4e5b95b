// The vehicles from simple solids in the body frame: x forward, y starboard, z down. Solids and thrusters
// are those of the vehicle's own data (sim/vehicles).
/**
 * @import { Object3D } from "three"
 * @import { Row, VehicleShape } from "../../server_data.d.ts"
 */
import * as THREE from "../../../vendor/three/three.min.js";
import { Arm } from "./arm.js";
import { Arrow, groupOf, paint, part } from "./solids.js";

const ARROW_M = 0.9; // of full thrust
const BLADES = 3;
const TURN = 26; // [rad] per second of simulated time at full thrust; eyes cannot follow more
const SPIN_MAX = 0.7; // [rad] per picture, so that blades do not seem to stand still

const PAINT = { dark: paint(0x20262b), white: paint(0xe9f0f2), arrow: paint(0xff7a1a) };

// A camera that moves without a vehicle.
function lone() {
  const camera = part(new THREE.CylinderGeometry(0.07, 0.07, 0.16, 16), PAINT.dark);
  camera.rotation.x = Math.PI / 2;
  return camera;
}

class Thruster {
  /**
   * @param {VehicleShape["thrusters"][number]} thruster
   * @param {number} radius
   */
  constructor({ position, direction }, radius) {
    this.group = new THREE.Group();
    this.group.position.set(...position);
    this.group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...direction));
    const nozzle = new THREE.CylinderGeometry(radius, radius * 0.92, radius * 0.8, 20, 1, true);
    this.group.add(part(nozzle, paint(0x2b3238, { side: THREE.DoubleSide })));
    this.group.add(part(new THREE.CylinderGeometry(radius * 0.3, radius * 0.3, radius * 1.3, 10), PAINT.dark));
    this.blades = new THREE.Group();
    for (let number = 0; number < BLADES; number += 1) {
      const blade = part(new THREE.BoxGeometry(radius * 0.85, radius * 0.06, radius * 0.42), PAINT.white, [
        radius * 0.5,
        0,
        0,
      ]);
      blade.rotation.x = 0.6;
      const arm = new THREE.Group();
      arm.rotation.y = (2 * Math.PI * number) / BLADES;
      arm.add(blade);
      this.blades.add(arm);
    }
    this.group.add(this.blades);
    this.arrow = new Arrow(PAINT.arrow);
    this.group.add(this.arrow.group);
  }

  /**
   * share: of full thrust, -1 to 1; seconds: of simulated time since the last picture
   * @param {number} share
   * @param {number} seconds
   */
  show(share, seconds) {
    const turn = Math.sign(share) * Math.sqrt(Math.abs(share)) * TURN * seconds;
    this.blades.rotation.y += Math.min(Math.max(turn, -SPIN_MAX), SPIN_MAX);
    this.arrow.show(Math.abs(share) * ARROW_M);
    this.arrow.group.scale.y = Math.sign(share) || 1;
  }
}

const GHOST_OPACITY = 0.55;

/**
 * A ghost is of one translucent paint, so that the vehicles behind it can be seen.
 * @param {Object3D} group
 * @param {string | undefined} colour
 * @param {boolean} ghost
 */
export function repaint(group, colour, ghost) {
  const shine = { emissive: colour ?? 0, emissiveIntensity: 0.6 }; // so that dark water leaves the colour
  const own = paint(colour ?? 0xbfd3dc, { ...shine, ...(ghost ? { transparent: true, opacity: GHOST_OPACITY } : {}) });
  group.traverse((mesh) => {
    if (mesh instanceof THREE.Mesh && (ghost || mesh.userData.livery)) mesh.material = own;
  });
}

/**
 * In the world: [m], [rad].
 * @typedef {{x: number, y: number, z: number, roll: number, pitch: number, yaw: number}} Pose
 */

export class Vehicle {
  /**
   * shape: of scene.json, null if the camera moves alone; colour: CSS, undefined for its own paint
   * @param {VehicleShape | null} shape
   * @param {{colour?: string, ghost?: boolean}} [options]
   */
  constructor(shape, { colour, ghost = false } = {}) {
    this.group = new THREE.Group();
    this.group.rotation.order = "ZYX"; // yaw, then pitch, then roll
    this.max = shape?.thrust_max ?? 1;
    this.thrusters = (shape?.thrusters ?? []).map((one) => new Thruster(one, shape?.nozzle_radius ?? 0));
    this.hull = shape ? groupOf(shape.solids) : lone();
    this.group.add(this.hull, ...this.thrusters.map(({ group }) => group));
    this.arm = shape?.arm ? new Arm(shape.arm) : null;
    if (this.arm) this.group.add(this.arm.group);
    if (ghost || colour) repaint(this.group, colour, ghost);
    if (ghost)
      for (const { arrow } of [...this.thrusters, ...(this.arm ? [this.arm] : [])]) arrow.group.removeFromParent();
  }

  /**
   * From on board one sees the arm alone.
   * @param {boolean} onBoard
   */
  setOnBoard(onBoard) {
    for (const part of [this.hull, ...this.thrusters.map(({ group }) => group)]) part.visible = !onBoard;
    this.arm?.setOnBoard(onBoard);
  }

  /**
   * pose: {x, y, z [m], roll, pitch, yaw [rad]} in the world frame
   * @param {Pose} pose
   * @param {Row} row
   * @param {number} seconds
   */
  show(pose, row, seconds) {
    this.group.position.set(pose.x, pose.y, pose.z);
    this.group.rotation.set(pose.roll, pose.pitch, pose.yaw);
    for (const [index, thruster] of this.thrusters.entries()) {
      thruster.show((row[`thrust_${index}`] ?? 0) / this.max, seconds);
    }
    this.arm?.show(row);
  }
}
