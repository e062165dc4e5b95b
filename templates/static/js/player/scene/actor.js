// A vehicle of the scene with its trail. The first one is followed; others are ghosts, translucent and in
// a colour of their own.
/**
 * @import { Row, Triple, VehicleShape } from "../../server_data.d.ts"
 * @import { Pose } from "./vehicle.js"
 */
import { Group } from "../../../vendor/three/three.min.js";
import { Trace } from "./surroundings.js";
import { Vehicle } from "./vehicle.js";

const TRAIL_POINTS = 500;
const TRAIL = 0xffe08a;

/**
 * work: pose of what the arm moves; decoy: of what looks like it
 * @typedef {{pose: Pose, work: Pose | null, decoy: Pose | null, row: Row, trail: Row[]}} SceneMoment
 */

export class Actor {
  /**
   * shape: of scene.json, null if the camera moves alone; colour: CSS, of hull and trail, null for its own paint
   * @param {{shape: VehicleShape | null, colour?: string}} vehicle
   * @param {{ghost: boolean}} options
   */
  constructor({ shape, colour }, { ghost }) {
    this.vehicle = new Vehicle(shape, { colour, ghost });
    this.trail = new Trace(colour ?? TRAIL, TRAIL_POINTS);
    this.group = new Group();
    this.group.add(this.vehicle.group, this.trail.line);
    this.group.visible = false;
  }

  /** @param {boolean} onBoard */
  setOnBoard(onBoard) {
    this.vehicle.setOnBoard(onBoard);
    this.trail.line.visible = !onBoard;
  }

  /**
   * moment: {pose, row, trail}, null where this vehicle has no telemetry; seconds: simulated, since the last picture
   * @param {SceneMoment | null} moment
   * @param {number} seconds
   */
  show(moment, seconds) {
    this.group.visible = moment !== null;
    if (!moment) return;
    this.vehicle.show(moment.pose, moment.row, seconds);
    /** @type {Triple[]} */
    const before = moment.trail.map(({ x, y, z }) => [Number(x), Number(y), Number(z)]);
    this.trail.show([...before, this.vehicle.group.position.toArray()]);
  }
}
