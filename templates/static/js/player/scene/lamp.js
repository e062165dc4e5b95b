// The light cone of the vehicle's lamp, if the run has one: ahead of the camera, looking down as it does.
/**
 * @import { Object3D } from "three"
 * @import { LightData, Triple } from "../../server_data.d.ts"
 */
import {
  AdditiveBlending,
  BufferAttribute,
  ConeGeometry,
  DoubleSide,
  Mesh,
  MeshBasicMaterial,
} from "../../../vendor/three/three.min.js";

const BRIGHTNESS = 0.05; // of one wall of the cone at the lamp; it fades to none at the seabed
const STEPS = 8; // of the fading

export class LampCone {
  /**
   * light: of scene.json; mount: of the camera in the body frame [m]; depth: of the seabed
   * @param {LightData} light
   * @param {Triple} mount
   * @param {number} depth
   */
  constructor({ cone, forward }, [x, y, z], depth) {
    this.depth = depth;
    const geometry = new ConeGeometry(Math.tan(cone), 1, 32, STEPS, true).translate(0, -0.5, 0);
    const { position } = geometry.attributes;
    const colours = Array.from({ length: position.count }, (_, index) => BRIGHTNESS * (1 + position.getY(index)) ** 2);
    geometry.setAttribute(
      "color",
      new BufferAttribute(new Float32Array(colours.flatMap((value) => [value, value, 0.85 * value])), 3),
    );
    const material = new MeshBasicMaterial({
      vertexColors: true,
      blending: AdditiveBlending,
      transparent: true,
      depthWrite: false,
      side: DoubleSide,
    });
    this.mesh = new Mesh(geometry, material);
    this.mesh.rotation.x = -Math.PI / 2; // its tip up, at the vehicle
    this.mesh.position.set(x + forward, y, z);
  }

  /**
   * vehicle: its group in the world
   * @param {Object3D} vehicle
   */
  show({ position }) {
    this.mesh.scale.setScalar(Math.max(this.depth - position.z - this.mesh.position.z, 0.1));
  }
}
