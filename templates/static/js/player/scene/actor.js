// A vehicle of the scene with its trail. The first one is followed; others are ghosts, translucent and in
// a colour of their own.
import { Group } from "../../../vendor/three/three.min.js";
import { Trace } from "./surroundings.js";
import { Vehicle } from "./vehicle.js";

const TRAIL_POINTS = 500;
const TRAIL = 0xffe08a;

export class Actor {
  // shape: of scene.json, null if the camera moves alone; colour: CSS, of hull and trail, null for its own paint
  constructor({ shape, colour = null }, { ghost }) {
    this.vehicle = new Vehicle(shape, { colour, ghost });
    this.trail = new Trace(colour ?? TRAIL, TRAIL_POINTS);
    this.group = new Group();
    this.group.add(this.vehicle.group, this.trail.line);
    this.group.visible = false;
  }

  // moment: {pose, row, trail}, null where this vehicle has no telemetry; seconds: simulated, since the last picture
  show(moment, seconds) {
    this.group.visible = moment !== null;
    if (!moment) return;
    this.vehicle.show(moment.pose, moment.row, seconds);
    this.trail.show([...moment.trail.map(({ x, y, z }) => [x, y, z]), this.vehicle.group.position.toArray()]);
  }
}
