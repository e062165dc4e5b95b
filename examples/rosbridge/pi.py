"""The PI controller of the published experiment behind a bridge, with roslibpy.

    seamark bridge rosbridge currents-v1 --seed 7
    python examples/rosbridge/pi.py

It publishes one velocity reference for each position error, so the run is reproducible: with the
same seed it has the digest of `seamark run currents-v1 --controller pi --seed 7`, with `--axes enu`
(forward, port, up, as in ROS) too.
"""

import json
import sys
import threading

import roslibpy

KP, KI, LIMIT = 0.5, 0.02, 1.0  # [1/s, 1/s², m/s] the defaults of the built-in controller


def main(host: str = "127.0.0.1", port: str = "9090") -> None:
    ros = roslibpy.Ros(host, int(port))
    integral = [0.0, 0.0]  # [m/s]
    seen = {"visible": False, "dt": 0.0}
    over = threading.Event()

    def restart(message: dict) -> None:
        seen["dt"] = json.loads(message["data"])["dt"]
        integral[:] = 0.0, 0.0

    def see(message: dict) -> None:
        seen["visible"] = message["data"]

    def answer(message: dict) -> None:
        reference = {"x": 0.0, "y": 0.0, "z": 0.0}
        for axis, name in enumerate("xy"):
            error = message["vector"][name]
            change = KI * error * seen["dt"] if seen["visible"] else 0.0
            wanted = KP * error + integral[axis] + change
            reference[name] = min(max(wanted, -LIMIT), LIMIT)
            if reference[name] == wanted or (wanted - reference[name]) * change < 0.0:
                integral[axis] += change
        still = {"x": 0.0, "y": 0.0, "z": 0.0}
        velocity.publish({"linear": reference, "angular": still})

    def end(message: dict) -> None:
        print(message["data"])
        over.set()

    velocity = roslibpy.Topic(ros, "/cmd_vel", "geometry_msgs/Twist")
    roslibpy.Topic(ros, "/seamark/level", "std_msgs/String").subscribe(restart)
    roslibpy.Topic(ros, "/seamark/target_visible", "std_msgs/Bool").subscribe(see)
    roslibpy.Topic(ros, "/seamark/result", "std_msgs/String").subscribe(end)
    # Last: with its first message the run begins.
    roslibpy.Topic(ros, "/seamark/error", "geometry_msgs/Vector3Stamped").subscribe(answer)
    ros.run()
    over.wait()
    ros.terminate()


if __name__ == "__main__":
    main(*sys.argv[1:])
