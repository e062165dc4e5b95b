// What the vehicle's camera looks at: its field of view down to the seabed, and the line to the target with the
// target's outline, which can be seen in any water.
/**
 * @import { Object3D } from "three"
 * @import { SceneData, TargetShape, Triple } from "../../server_data.d.ts"
 */
import { Group, Vector3 } from "../../../vendor/three/three.min.js";
import { Trace } from "./surroundings.js";

const REACH_MAX_M = 12;
const CORNERS = [
  [-1, -1],
  [1, -1],
  [1, 1],
  [-1, 1],
];
/** @type {(corners: Triple[]) => Triple[]} */
const edges = (corners) => corners.flatMap((corner, index) => [corner, corners[(index + 1) % corners.length]]);

export class Sight {
  constructor() {
    this.group = new Group();
    this.frustum = new Trace(0x9fe8ff, 16, { segments: true, opacity: 0.7 });
    this.line = new Trace(0xff5fa2, 10, { segments: true });
    this.group.add(this.frustum.line, this.line.line);
  }

  /**
   * vehicle: its group, with its matrix; description: of scene.json; aim: where the target is, if there is one
   * @param {Object3D} vehicle
   * @param {Pick<SceneData, "camera" | "seabed">} description
   * @param {Aim | null} aim
   */
  show(vehicle, { camera, seabed }, aim) {
    const { mount, focal, width, height } = camera;
    const eye = new Vector3(...mount).applyMatrix4(vehicle.matrix);
    // Image right is starboard (y), image down is aft (-x), the optical axis is down (z).
    const corners = CORNERS.map(([u, v]) => {
      const ray = new Vector3((-v * height) / 2 / focal, (u * width) / 2 / focal, 1).applyQuaternion(
        vehicle.quaternion,
      );
      const reach = ray.z > 0.05 ? Math.min((seabed.depth - eye.z) / ray.z, REACH_MAX_M) : REACH_MAX_M;
      return eye.clone().addScaledVector(ray, Math.max(reach, 0)).toArray();
    });
    this.frustum.show([...corners.flatMap((corner) => [eye.toArray(), corner]), ...edges(corners)]);
    this.line.show(aim ? [eye.toArray(), aim.centre, ...edges(aim.outline)] : []);
  }
}

/** @typedef {{centre: Triple, outline: Triple[]}} Aim the middle of the target, and the corners of its top */

/**
 * Where a target that stands is.
 * @param {TargetShape} target
 * @returns {Aim}
 */
export function aimAt({ centre, size: [length, width, height], heading }) {
  const [north, east, down] = centre;
  const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
  /** @type {Triple[]} */
  const outline = CORNERS.map(([u, v]) => {
    const [x, y] = [(-v * width) / 2, (u * length) / 2];
    return [north + cos * x - sin * y, east + sin * x + cos * y, down - height / 2 - 0.01];
  });
  return { centre, outline };
}
