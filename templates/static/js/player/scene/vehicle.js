// The vehicles from simple solids in the body frame: x forward, y starboard, z down. The places of
// hulls and thrusters are those of the simulation; a vehicle without a model of its own is its hull boxes.
import * as THREE from "../../../vendor/three/three.min.js";

const ARROW_M = 0.9; // of full thrust
const BLADES = 3;
const TURN = 26; // [rad] per second of simulated time at full thrust; eyes cannot follow more
const SPIN_MAX = 0.7; // [rad] per picture, so that blades do not seem to stand still

const paint = (color, options = {}) => new THREE.MeshLambertMaterial({ color, ...options });
const PAINT = {
  yellow: paint(0xf2b61d), dark: paint(0x20262b), metal: paint(0x9fb0ba), blue: paint(0x1668b8),
  foam: paint(0x2f8fdd), glass: paint(0x0e2a3a), white: paint(0xe9f0f2), arrow: paint(0xff7a1a),
};

function part(geometry, material, [x, y, z] = [0, 0, 0]) {
  const mesh = new THREE.Mesh(geometry, material);
  mesh.position.set(x, y, z);
  return mesh;
}

const box = ([x, y, z], material, at) => part(new THREE.BoxGeometry(x, y, z), material, at);

// A cylinder or capsule along the x axis.
function lengthwise(geometry, material, at) {
  const mesh = part(geometry, material, at);
  mesh.rotation.z = Math.PI / 2;
  return mesh;
}

function girona(shape) {
  const group = new THREE.Group();
  for (const { name, centre, size } of shape.hull) {
    const radius = size[1] / 2;
    const [x, y, z] = centre;
    group.add(lengthwise(new THREE.CapsuleGeometry(radius, size[0] - 2 * radius, 6, 18), name === "lower" ? PAINT.dark : PAINT.yellow, centre));
    group.add(lengthwise(new THREE.CylinderGeometry(radius * 1.02, radius * 1.02, 0.05, 18), PAINT.metal, [x + 0.45, y, z]));
    group.add(lengthwise(new THREE.CylinderGeometry(radius * 1.02, radius * 1.02, 0.05, 18), PAINT.metal, [x - 0.45, y, z]));
  }
  const [lower, port, starboard] = shape.hull.map(({ centre }) => centre);
  const height = lower[2] - port[2];
  for (const x of [-0.42, 0.32]) {
    group.add(box([0.05, starboard[1] - port[1], 0.05], PAINT.metal, [x, 0, port[2]]));
    group.add(box([0.05, 0.05, height], PAINT.metal, [x, 0, port[2] + height / 2]));
  }
  group.add(box([1.15, 0.04, 0.06], PAINT.metal, [0, 0, 0]));
  group.add(box([0.2, 0.03, 0.16], PAINT.yellow, [-0.62, 0, lower[2] - 0.2])); // tail fin
  return group;
}

function bluerov(shape) {
  const group = new THREE.Group();
  const [length, width, height] = shape.hull[0].size;
  for (const side of [-1, 1]) {
    group.add(box([length, 0.012, height * 0.42], PAINT.blue, [0, side * 0.17, height * 0.28]));
    group.add(box([0.05, 0.012, height * 0.6], PAINT.blue, [length * 0.42, side * 0.17, 0]));
    group.add(box([0.05, 0.012, height * 0.6], PAINT.blue, [-length * 0.42, side * 0.17, 0]));
    group.add(box([length * 0.82, 0.1, 0.07], PAINT.foam, [0, side * 0.12, -height * 0.4]));
    group.add(box([length * 0.5, 0.03, 0.03], PAINT.dark, [0, side * width * 0.36, -0.03])); // outriggers of the heave thrusters
    for (const x of [-0.118, 0.118]) group.add(box([0.03, 0.1, 0.03], PAINT.dark, [x, side * 0.2, -0.03]));
  }
  group.add(lengthwise(new THREE.CylinderGeometry(0.057, 0.057, length * 0.62, 18), PAINT.glass, [0, 0, -0.02]));
  group.add(part(new THREE.SphereGeometry(0.057, 16, 10), PAINT.white, [length * 0.31, 0, -0.02]));
  group.add(lengthwise(new THREE.CylinderGeometry(0.044, 0.044, length * 0.5, 14), PAINT.dark, [0, 0, 0.08]));
  group.add(box([length * 0.8, 0.34, 0.012], PAINT.blue, [0, 0, height * 0.47]));
  return group;
}

function plain(shape) {
  const group = new THREE.Group();
  for (const { centre, size } of shape.hull) group.add(box(size, PAINT.yellow, centre));
  return group;
}

function hullOf(shape) {
  if (shape.name.startsWith("girona500")) return girona(shape);
  if (shape.name.startsWith("bluerov2")) return bluerov(shape);
  return plain(shape);
}

// A camera that moves without a vehicle.
function lone() {
  const camera = part(new THREE.CylinderGeometry(0.07, 0.07, 0.16, 16), PAINT.dark);
  camera.rotation.x = Math.PI / 2;
  return camera;
}

class Thruster {
  constructor({ position, direction }, radius) {
    this.group = new THREE.Group();
    this.group.position.set(...position);
    this.group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...direction));
    const nozzle = new THREE.CylinderGeometry(radius, radius * 0.92, radius * 0.8, 20, 1, true);
    this.group.add(part(nozzle, paint(0x2b3238, { side: THREE.DoubleSide })));
    this.group.add(part(new THREE.CylinderGeometry(radius * 0.3, radius * 0.3, radius * 1.3, 10), PAINT.dark));
    this.blades = new THREE.Group();
    for (let number = 0; number < BLADES; number += 1) {
      const blade = part(new THREE.BoxGeometry(radius * 0.85, radius * 0.06, radius * 0.42), PAINT.white, [radius * 0.5, 0, 0]);
      blade.rotation.x = 0.6;
      const arm = new THREE.Group();
      arm.rotation.y = (2 * Math.PI * number) / BLADES;
      arm.add(blade);
      this.blades.add(arm);
    }
    this.group.add(this.blades);
    this.shaft = part(new THREE.CylinderGeometry(0.013, 0.013, 1, 8), PAINT.arrow);
    this.head = part(new THREE.ConeGeometry(0.042, 0.11, 12), PAINT.arrow);
    this.arrow = new THREE.Group();
    this.arrow.add(this.shaft, this.head);
    this.group.add(this.arrow);
  }

  // share: of full thrust, -1 to 1; seconds: of simulated time since the last picture
  show(share, seconds) {
    const turn = Math.sign(share) * Math.sqrt(Math.abs(share)) * TURN * seconds;
    this.blades.rotation.y += Math.min(Math.max(turn, -SPIN_MAX), SPIN_MAX);
    const length = Math.abs(share) * ARROW_M;
    this.arrow.visible = length > 0.02;
    this.arrow.scale.y = Math.sign(share) || 1;
    this.shaft.scale.y = Math.max(length, 0.01);
    this.shaft.position.y = length / 2;
    this.head.position.y = length + 0.05;
  }
}

const LIVERY = [PAINT.yellow, PAINT.blue, PAINT.foam]; // what a colour of one's own replaces
const GHOST_OPACITY = 0.55;

// A ghost is of one translucent paint, so that the vehicles behind it can be seen.
function repaint(group, colour, ghost) {
  const shine = { emissive: colour ?? 0, emissiveIntensity: 0.6 }; // so that dark water leaves the colour
  const own = paint(colour ?? 0xbfd3dc, { ...shine, ...(ghost ? { transparent: true, opacity: GHOST_OPACITY } : {}) });
  group.traverse((mesh) => {
    if (mesh.material && (ghost || LIVERY.includes(mesh.material))) mesh.material = own;
  });
}

export class Vehicle {
  // shape: of scene.json, null if the camera moves alone; colour: CSS, null for its own paint
  constructor(shape, { colour = null, ghost = false } = {}) {
    this.group = new THREE.Group();
    this.group.rotation.order = "ZYX"; // yaw, then pitch, then roll
    this.max = shape?.thrust_max ?? 1;
    const radius = shape?.name.startsWith("girona") ? 0.1 : 0.05;
    this.thrusters = (shape?.thrusters ?? []).map((one) => new Thruster(one, radius));
    this.hull = shape ? hullOf(shape) : lone();
    this.group.add(this.hull, ...this.thrusters.map(({ group }) => group));
    if (ghost || colour) repaint(this.group, colour, ghost);
    if (ghost) for (const { arrow } of this.thrusters) arrow.removeFromParent();
  }

  // pose: {x, y, z [m], roll, pitch, yaw [rad]} in the world frame
  show(pose, row, seconds) {
    this.group.position.set(pose.x, pose.y, pose.z);
    this.group.rotation.set(pose.roll, pose.pitch, pose.yaw);
    this.thrusters.forEach((thruster, index) => thruster.show((row[`thrust_${index}`] ?? 0) / this.max, seconds));
  }
}
