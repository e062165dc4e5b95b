// The route that a vehicle follows, as a tube in two colours; the point that is due, the last acoustic fix, and the
// boat that it is from. In colours that can be seen in any water. A pipe on the seabed is drawn where it is bare.
/**
 * @import { ColorRepresentation } from "three"
 * @import { RouteData, Row, Triple } from "../../server_data.d.ts"
 */
import * as THREE from "../../../vendor/three/three.min.js";
import { fixOf, partedAt, piecesOf } from "../route_track.js";
import { Trace } from "./surroundings.js";

const RADIUS_M = 0.05; // of the tube
const SIDES = 8;
const DONE = 0x5ed394;
const REST = 0xe8eef2;
const PIPE = 0x262a2c;
const DUE = 0xff5fa2;
const FIX = 0xffa04d;
const SHADOW = 0x06121a;
const ABOVE_M = 0.03; // of what is drawn on the seabed
const MARK_M = 0.09; // radius of a mark

export class Course {
  /**
   * depth: of the seabed [m]
   * @param {RouteData} route
   * @param {number} depth
   */
  constructor({ points, boat, pipe }, depth) {
    this.points = points;
    this.depth = depth;
    this.done = new Tube(DONE);
    this.rest = new Tube(REST);
    this.due = ball(DUE, MARK_M);
    this.fix = ball(FIX, MARK_M);
    this.sigma = new THREE.Mesh(
      new THREE.SphereGeometry(1, 24, 16),
      new THREE.MeshBasicMaterial({ color: FIX, transparent: true, opacity: 0.18, depthWrite: false }),
    );
    this.off = new Trace(DUE, 2); // from the vehicle to the point that is due
    const shadow = new Trace(SHADOW, points.length, { opacity: 0.6 });
    shadow.show(points.map(([north, east]) => [north, east, depth - ABOVE_M]));
    const transceiver = ball(REST, 0.3);
    transceiver.position.set(...boat);
    this.group = new THREE.Group();
    this.group.add(this.rest.mesh, this.done.mesh, shadow.line, transceiver);
    for (const piece of pipe ? piecesOf(pipe).bare : []) {
      const tube = new Tube(PIPE, pipe?.radius);
      tube.show(piece);
      this.group.add(tube.mesh);
    }
    this.outside = new THREE.Group(); // what is not to be seen from on board
    this.outside.add(this.due, this.fix, this.sigma, this.off.line);
  }

  /**
   * @param {THREE.Vector3} vehicle where it is
   * @param {Row} row
   */
  show(vehicle, row) {
    const [done, rest] = partedAt(this.points, Number(row.route_along));
    this.done.show(done);
    this.rest.show(rest);
    /** @type {Triple} */
    const due = [Number(row.route_x), Number(row.route_y), Number(row.route_z)];
    this.due.position.set(...due);
    this.off.show([vehicle.toArray(), due]);
    const fix = fixOf(row);
    this.fix.visible = this.sigma.visible = fix !== null;
    if (!fix) return;
    for (const mark of [this.fix, this.sigma]) mark.position.set(...fix.at, Number(row.fix_z));
    this.sigma.scale.setScalar(Math.max(fix.sigma, MARK_M));
  }
}

/**
 * @param {ColorRepresentation} color
 * @param {number} radius
 */
function ball(color, radius) {
  return new THREE.Mesh(new THREE.SphereGeometry(radius, 16, 12), new THREE.MeshBasicMaterial({ color }));
}

// Round pieces along straight lines, with a ball where they meet.
class Tube {
  /**
   * @param {ColorRepresentation} color
   * @param {number} radius
   */
  constructor(color, radius = RADIUS_M) {
    const sides = radius > RADIUS_M ? 3 * SIDES : SIDES;
    this.paint = new THREE.MeshLambertMaterial({ color });
    this.piece = new THREE.CylinderGeometry(radius, radius, 1, sides);
    this.joint = new THREE.SphereGeometry(radius, sides, sides / 2);
    this.mesh = new THREE.Group();
    /** @type {{piece: THREE.Mesh, joint: THREE.Mesh}[]} */
    this.made = [];
  }

  /** @param {Triple[]} points */
  show(points) {
    const up = new THREE.Vector3(0, 1, 0); // along which a cylinder lies
    while (this.made.length < points.length - 1) {
      const made = { piece: new THREE.Mesh(this.piece, this.paint), joint: new THREE.Mesh(this.joint, this.paint) };
      this.mesh.add(made.piece, made.joint);
      this.made.push(made);
    }
    for (const [index, { piece, joint }] of this.made.entries()) {
      piece.visible = joint.visible = index < points.length - 1;
      if (!piece.visible) continue;
      const [from, to] = [new THREE.Vector3(...points[index]), new THREE.Vector3(...points[index + 1])];
      joint.position.copy(to);
      piece.position.copy(from).lerp(to, 0.5);
      to.sub(from);
      const length = to.length();
      piece.scale.y = Math.max(length, 1e-6);
      if (length > 0) piece.quaternion.setFromUnitVectors(up, to.divideScalar(length));
    }
  }
}
