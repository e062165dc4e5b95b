// The PI controller of the published experiment behind a bridge, with roslib (npm install roslib).
//
//     seamark bridge rosbridge currents-v1 --seed 7
//     node pi.mjs
//
// It publishes one velocity reference for each position error, so the run is reproducible: with the
// same seed it has the digest of `seamark run currents-v1 --controller pi --seed 7`.

import { Ros, Topic } from "roslib";

const [KP, KI, LIMIT] = [0.5, 0.02, 1.0]; // [1/s, 1/s², m/s] the defaults of the built-in controller
const url = process.argv[2] ?? "ws://127.0.0.1:9090";
const ros = new Ros({ url });
let integral = { x: 0.0, y: 0.0 }; // [m/s]
let visible = false;
let dt = 0.0;

function topic(name, messageType) {
  return new Topic({ ros, name, messageType });
}

const velocity = topic("/cmd_vel", "geometry_msgs/Twist");

function answer({ vector }) {
  const linear = { x: 0.0, y: 0.0, z: 0.0 };
  for (const axis of ["x", "y"]) {
    const change = visible ? KI * vector[axis] * dt : 0.0;
    const wanted = KP * vector[axis] + integral[axis] + change;
    linear[axis] = Math.min(Math.max(wanted, -LIMIT), LIMIT);
    if (linear[axis] === wanted || (wanted - linear[axis]) * change < 0.0) {
      integral[axis] += change;
    }
  }
  velocity.publish({ linear, angular: { x: 0.0, y: 0.0, z: 0.0 } });
}

ros.on("connection", () => {
  topic("/seamark/level", "std_msgs/String").subscribe(({ data }) => {
    dt = JSON.parse(data).dt;
    integral = { x: 0.0, y: 0.0 };
  });
  topic("/seamark/target_visible", "std_msgs/Bool").subscribe(({ data }) => {
    visible = data;
  });
  topic("/seamark/result", "std_msgs/String").subscribe(({ data }) => {
    console.log(data);
    process.exit(0);
  });
  // Last: with its first message the run begins.
  topic("/seamark/error", "geometry_msgs/Vector3Stamped").subscribe(answer);
});
ros.on("error", (error) => {
  console.error(`${url}: ${error.message ?? error}`);
  process.exit(1);
});
