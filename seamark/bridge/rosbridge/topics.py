"""The topics of a bridge: their names, types and messages, in the order in which they are sent.

Frames are those of Seamark and of the original, x forward, y starboard, z down in the body
(`base_link_frd`), north, east, down in the world (`map_ned`), or those of ROS (`axes`); SI units,
angles in rad.
"""

import base64
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

import cv2
import numpy as np
import orjson
from numpy.typing import NDArray

from seamark.bridge.rosbridge.axes import Axes
from seamark.bridge.rosbridge.navigation import DeadReckoning
from seamark.bridge.rosbridge.protocol import NS
from seamark.sim.camera.arm_camera import ON_ARM
from seamark.sim.camera.optics import Optics
from seamark.sim.control.observation import ARM_CAMERA, SONAR, VEHICLE_CAMERA, Observation

CAMERA, FORCE_SENSOR = "camera", "force_sensor"
FRAMES = {VEHICLE_CAMERA: CAMERA, ARM_CAMERA: "arm_camera", SONAR: SONAR}
_UNKNOWN = [0.0] * 36  # a covariance, as nav_msgs says
Message = dict[str, Any]
Publishing = Callable[["Moment", "Dialect"], Message]


class Ros(Enum):
    """Whose names of types and time stamps a client uses; the type of a subscription tells."""

    ONE = 1
    TWO = 2


@dataclass(frozen=True, slots=True)
class Dialect:
    """How a client wants its messages."""

    ros: Ros
    axes: Axes


@dataclass(frozen=True, slots=True)
class Stamp:
    """A simulated time [ns] in the message of a client's ROS."""

    ns: int

    def of(self, ros: Ros) -> Message:
        """Return the message."""
        seconds, rest = divmod(self.ns, NS)
        names = ("secs", "nsecs") if ros is Ros.ONE else ("sec", "nanosec")
        return dict(zip(names, (seconds, rest), strict=True))


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """All that can be published of one control step."""

    step: int  # since the trial began
    stamp: Stamp
    level: Mapping[str, float | int]  # as a program in a box gets it
    begins: bool  # whether a level begins
    seen: Observation
    navigation: DeadReckoning
    optics: Optics
    motors: tuple[str, ...]  # of the vehicle's arm
    image: Callable[[], NDArray[np.uint8]]  # (H, W, 3) blue, green, red
    new_images: bool  # whether the observation is the first with its images

    def header(self, to: Dialect, frame: str, stamp: Stamp | None = None) -> Message:
        """Return the header of a message in a frame; of this moment, unless stamped."""
        numbered = {"seq": self.step} if to.ros is Ros.ONE else {}
        return {**numbered, "stamp": (stamp or self.stamp).of(to.ros), "frame_id": frame}

    def image_header(self, to: Dialect, camera: str) -> Message:
        """Return the header of what comes with the newest image of a camera."""
        return self.header(to, FRAMES[camera], Stamp(round(self.seen.image_t * NS)))


def _xyz(vector: Iterable[float]) -> Message:
    return dict(zip("xyz", vector, strict=True))


def _in_body(values: NDArray[np.float64], to: Dialect) -> Message:
    return _xyz(to.axes.of_body(values.tolist()))


def _level(now: Moment, to: Dialect) -> Message:
    return {"data": orjson.dumps(dict(now.level)).decode()}


def _original_level(now: Moment, to: Dialect) -> Message:
    return {"data": f"Updated scene {now.level['index']}"}


def _pixels(header: Message, encoding: str, image: NDArray[np.uint8]) -> Message:
    height, width = image.shape[:2]
    return {
        "header": header,
        "height": height,
        "width": width,
        "encoding": encoding,
        "is_bigendian": 0,
        "step": image.nbytes // height,
        "data": base64.b64encode(image.tobytes()).decode(),
    }


def _png(header: Message, image: NDArray[np.uint8]) -> Message:
    _done, png = cv2.imencode(".png", image)
    data = base64.b64encode(png.tobytes()).decode()
    return {"header": header, "format": "png", "data": data}


def _image(now: Moment, to: Dialect) -> Message:
    return _pixels(now.header(to, CAMERA), "rgb8", now.image()[..., ::-1])


def _compressed_image(now: Moment, to: Dialect) -> Message:
    return _png(now.header(to, CAMERA), now.image())


def _grey(camera: str) -> Publishing:
    return lambda now, to: _pixels(now.image_header(to, camera), "mono8", now.seen.images[camera])


def _compressed_grey(camera: str) -> Publishing:
    return lambda now, to: _png(now.image_header(to, camera), now.seen.images[camera])


def _camera(now: Moment, to: Dialect) -> Message:
    return _camera_info(now.header(to, CAMERA), now.optics, to)


def _arm_camera(now: Moment, to: Dialect) -> Message:
    return _camera_info(now.image_header(to, ARM_CAMERA), ON_ARM, to)


def _camera_info(header: Message, optics: Optics, to: Dialect) -> Message:
    (u, v), f = optics.principal_px, optics.focal_px
    matrices = {
        "d": [0.0] * 5,
        "k": [f, 0.0, u, 0.0, f, v, 0.0, 0.0, 1.0],
        "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "p": [f, 0.0, u, 0.0, 0.0, f, v, 0.0, 0.0, 0.0, 1.0, 0.0],
    }
    if to.ros is Ros.ONE:
        matrices = {name.upper(): values for name, values in matrices.items()}
    return {
        "header": header,
        "height": optics.height,
        "width": optics.width,
        "distortion_model": "plumb_bob",
        **matrices,
    }


def _place(now: Moment, to: Dialect) -> Message:
    at = now.navigation
    turned = to.axes.of_orientation(at.orientation)
    return {
        "position": _xyz(to.axes.of_world((at.north_m, at.east_m, at.down_m))),
        "orientation": dict(zip("xyzw", turned, strict=True)),
    }


def _twist(now: Moment, to: Dialect) -> Message:
    return {"linear": _in_body(now.seen.velocity, to), "angular": _in_body(now.seen.rates, to)}


def _pose(now: Moment, to: Dialect) -> Message:
    return {"header": now.header(to, to.axes.world), "pose": _place(now, to)}


def _velocity(now: Moment, to: Dialect) -> Message:
    return {"header": now.header(to, to.axes.body), "twist": _twist(now, to)}


def _odometry(now: Moment, to: Dialect) -> Message:
    return {
        "header": now.header(to, to.axes.world),
        "child_frame_id": to.axes.body,
        "pose": {"pose": _place(now, to), "covariance": _UNKNOWN},
        "twist": {"twist": _twist(now, to), "covariance": _UNKNOWN},
    }


def _velocity_valid(now: Moment, to: Dialect) -> Message:
    return {"data": now.seen.velocity_valid}


def _altitude(now: Moment, to: Dialect) -> Message:
    return {"data": now.seen.altitude}


def _thrust(now: Moment, to: Dialect) -> Message:
    values = now.seen.thrust.tolist()
    label = {"label": "thruster", "size": len(values), "stride": len(values)}
    return {"layout": {"dim": [label], "data_offset": 0}, "data": values}


def _visible(now: Moment, to: Dialect) -> Message:
    return {"data": now.seen.target_visible}


def _error_px(now: Moment, to: Dialect) -> Message:
    x, y = now.seen.error_px.tolist()
    return {"header": now.header(to, CAMERA), "point": {"x": x, "y": y, "z": 0.0}}


def _error(now: Moment, to: Dialect) -> Message:
    return {"header": now.header(to, to.axes.body), "vector": _in_body(now.seen.error, to)}


def _original_error(now: Moment, to: Dialect) -> Message:
    upright = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
    pose = {"position": _in_body(now.seen.error, to), "orientation": upright}
    return {"header": now.header(to, to.axes.body), "pose": pose}


def _clock(now: Moment, to: Dialect) -> Message:
    return {"clock": now.stamp.of(to.ros)}


def _joints(now: Moment, to: Dialect) -> Message:
    seen = now.seen
    return {
        "header": now.header(to, to.axes.body),
        "name": list(now.motors),
        "position": seen.joints.tolist(),
        "velocity": seen.joint_speeds.tolist(),
        "effort": seen.joint_efforts.tolist(),
    }


def _wrench(now: Moment, to: Dialect) -> Message:
    seen = now.seen
    force, torque = _xyz(seen.wrist_force.tolist()), _xyz(seen.wrist_torque.tolist())
    wrench = {"force": force, "torque": torque}
    return {"header": now.header(to, FORCE_SENSOR), "wrench": wrench}


def _touch(now: Moment, to: Dialect) -> Message:
    values = now.seen.touch.tolist()
    label = {"label": "part of the hand", "size": len(values), "stride": len(values)}
    return {"layout": {"dim": [label], "data_offset": 0}, "data": values}


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic that the bridge publishes."""

    package: str
    kind: str
    meaning: str
    message: Publishing
    at_levels: bool = False  # published only when a level begins
    of_arm: bool = False  # published only if the vehicle has an arm
    camera: str = ""  # published only with new images of this camera

    def has_message(self, now: Moment) -> bool:
        """Return whether there is a message of a moment."""
        if self.camera:
            return now.new_images and self.camera in now.seen.images
        return (now.begins or not self.at_levels) and (bool(now.motors) or not self.of_arm)

    def type_in(self, ros: Ros) -> str:
        """Return the name of the type."""
        middle = "/" if ros is Ros.ONE else "/msg/"
        return f"{self.package}{middle}{self.kind}"

    def ros_of(self, name: str) -> Ros | None:
        """Return whose name of the type this is; of ROS 1 if it is empty, None if it is wrong."""
        if not name:
            return Ros.ONE
        return next((ros for ros in Ros if name == self.type_in(ros)), None)


# In the order in which they are sent: a program that answers to the error has all else by then.
TOPICS: Mapping[str, Topic] = {
    "/BenchmarkInfo": Topic(
        "std_msgs", "String", "a level begins: `Updated scene 0` and so on", _original_level, True
    ),
    "/seamark/level": Topic(
        "std_msgs",
        "String",
        "a level begins: JSON with `index`, `count`, `duration_s`, `dt`, `t`",
        _level,
        True,
    ),
    "/seamark/camera_info": Topic(
        "sensor_msgs", "CameraInfo", "focal length and size of the camera", _camera
    ),
    "/seamark/image": Topic("sensor_msgs", "Image", "image of the camera below, rgb8", _image),
    "/seamark/image/compressed": Topic(
        "sensor_msgs", "CompressedImage", "the same, as PNG", _compressed_image
    ),
    "/seamark/vehicle_camera/image": Topic(
        "sensor_msgs",
        "Image",
        "with the setting `images`: what an uploaded controller gets of that camera, mono8",
        _grey(VEHICLE_CAMERA),
        camera=VEHICLE_CAMERA,
    ),
    "/seamark/vehicle_camera/image/compressed": Topic(
        "sensor_msgs",
        "CompressedImage",
        "the same, as PNG",
        _compressed_grey(VEHICLE_CAMERA),
        camera=VEHICLE_CAMERA,
    ),
    "/seamark/arm_camera/camera_info": Topic(
        "sensor_msgs",
        "CameraInfo",
        "with the setting `images`: focal length and size of the camera on the arm",
        _arm_camera,
        camera=ARM_CAMERA,
    ),
    "/seamark/arm_camera/image": Topic(
        "sensor_msgs",
        "Image",
        "with the setting `images`: what an uploaded controller gets of that camera, mono8",
        _grey(ARM_CAMERA),
        camera=ARM_CAMERA,
    ),
    "/seamark/arm_camera/image/compressed": Topic(
        "sensor_msgs",
        "CompressedImage",
        "the same, as PNG",
        _compressed_grey(ARM_CAMERA),
        camera=ARM_CAMERA,
    ),
    "/seamark/sonar/image": Topic(
        "sensor_msgs",
        "Image",
        "with the setting `sonar`: what an uploaded controller gets of the sonar, mono8",
        _grey(SONAR),
        camera=SONAR,
    ),
    "/seamark/sonar/image/compressed": Topic(
        "sensor_msgs",
        "CompressedImage",
        "the same, as PNG",
        _compressed_grey(SONAR),
        camera=SONAR,
    ),
    "/seamark/pose": Topic(
        "geometry_msgs", "PoseStamped", "pose by dead reckoning since the level began", _pose
    ),
    "/seamark/velocity": Topic(
        "geometry_msgs", "TwistStamped", "velocity (DVL) and rates, body frame", _velocity
    ),
    "/seamark/odometry": Topic(
        "nav_msgs", "Odometry", "pose and velocity in one message", _odometry
    ),
    "/seamark/velocity_valid": Topic(
        "std_msgs", "Bool", "whether the last DVL measurement was good", _velocity_valid
    ),
    "/seamark/altitude": Topic("std_msgs", "Float64", "height above the bottom [m]", _altitude),
    "/seamark/thrust": Topic(
        "std_msgs", "Float64MultiArray", "last thrust of each thruster [N]", _thrust
    ),
    "/seamark/joint_states": Topic(
        "sensor_msgs",
        "JointState",
        "with an arm: coordinate, speed and effort of each joint with a motor",
        _joints,
        of_arm=True,
    ),
    "/seamark/wrench": Topic(
        "geometry_msgs",
        "WrenchStamped",
        "with an arm: force and torque at its wrist, axes of the sensor",
        _wrench,
        of_arm=True,
    ),
    "/seamark/touch": Topic(
        "std_msgs",
        "Float64MultiArray",
        "with an arm: 1 for each part of its hand that touches something, else 0",
        _touch,
        of_arm=True,
    ),
    "/seamark/target_visible": Topic(
        "std_msgs", "Bool", "whether the tracker has the target", _visible
    ),
    "/seamark/error_px": Topic(
        "geometry_msgs", "PointStamped", "target minus image centre [px]", _error_px
    ),
    "/seamark/error": Topic(
        "geometry_msgs", "Vector3Stamped", "position error: how far to move [m], body frame", _error
    ),
    "/gotopose": Topic(
        "geometry_msgs", "PoseStamped", "the same, as the position of a pose", _original_error
    ),
    "/clock": Topic("rosgraph_msgs", "Clock", "simulated time of the trial", _clock),
}
RESULT = "/seamark/result"  # std_msgs/String, once at the end
# What a program publishes its velocity reference on; both take both types.
REFERENCES: Mapping[str, str] = {"/cmd_vel": "Twist", "/dataNavigator": "TwistStamped"}

# What it publishes the speeds of an arm's joints on.
JOINT_SPEEDS, JOINT_SPEEDS_TYPE = "/seamark/joint_velocity", "Float64MultiArray"


def resolved(name: str) -> str:
    """Return the global name of a topic: a relative one belongs to the root."""
    return name if name.startswith("/") else f"/{name}"
