// The shadow of a vehicle on the seabed: its hull once more as one flat, dark mesh, along the light. It
// costs one draw call, which a shadow map does not where there is no graphics card.
/**
 * @import { Object3D } from "three"
 * @import { Triple } from "../../server_data.d.ts"
 * @import { Water } from "./water.js"
 */
import {
  BufferAttribute,
  BufferGeometry,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  NotEqualStencilFunc,
  ReplaceStencilOp,
} from "../../../vendor/three/three.min.js";

const DARKNESS = 0.45; // share of the daylight that the hull takes away
const ABOVE_M = 0.004; // the seabed, so that they do not flicker

/**
 * Returns the triangles of all meshes in a group as one geometry, in the group's frame.
 * @param {Object3D} group
 */
function merged(group) {
  /** @type {number[]} */
  const positions = [];
  /** @type {number[]} */
  const indices = [];
  group.updateWorldMatrix(true, true);
  const inverse = group.matrixWorld.clone().invert();
  group.traverse((mesh) => {
    if (!(mesh instanceof Mesh)) return;
    const { position } = mesh.geometry.clone().applyMatrix4(mesh.matrixWorld.clone().premultiply(inverse)).attributes;
    const first = positions.length / 3;
    positions.push(...position.array);
    indices.push(...Array.from(mesh.geometry.index.array, (at) => first + at));
  });
  return new BufferGeometry()
    .setAttribute("position", new BufferAttribute(new Float32Array(positions), 3))
    .setIndex(indices);
}

export class Shadow {
  /**
   * solid: group of the parts that cast it; depth: of the seabed [m]; light: [north, east, down] along which it falls
   * @param {Object3D} solid
   * @param {number} depth
   * @param {Triple} light
   * @param {Water} water
   */
  constructor(solid, depth, light, water) {
    const material = new MeshBasicMaterial({
      color: 0,
      transparent: true,
      opacity: DARKNESS,
      depthWrite: false,
      // Each pixel once, where parts of the hull lie above each other.
      stencilWrite: true,
      stencilRef: 1,
      stencilFunc: NotEqualStencilFunc,
      stencilZPass: ReplaceStencilOp,
    });
    this.mesh = new Mesh(merged(solid), water.seen(material));
    this.mesh.matrixAutoUpdate = this.mesh.frustumCulled = false;
    const [north, east, down] = light;
    const plane = depth - ABOVE_M;
    const [n, e] = [north / down, east / down];
    this.projection = new Matrix4().set(1, 0, -n, n * plane, 0, 1, -e, e * plane, 0, 0, 0, plane, 0, 0, 0, 1);
  }

  /**
   * vehicle: its group in the world
   * @param {Object3D} vehicle
   */
  show(vehicle) {
    this.mesh.matrix.multiplyMatrices(this.projection, vehicle.matrix);
  }
}
