"""The topics of a bridge: their names, types and messages, in the order in which they are sent.

Frames are those of Seamark and of the original: x forward, y starboard, z down in the body
(`base_link_frd`), north, east, down in the world (`map_ned`); SI units, angles in rad.
"""

import base64
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

import cv2
import numpy as np
import orjson
from numpy.typing import NDArray

from seamark.bridge.rosbridge.navigation import DeadReckoning
from seamark.sim.camera.optics import Optics
from seamark.sim.control.observation import Observation

BODY, WORLD, CAMERA = "base_link_frd", "map_ned", "camera"
NS = 1_000_000_000
Message = dict[str, Any]


class Ros(Enum):
    """Whose names of types and time stamps a client uses; the type of a subscription tells."""

    ONE = 1
    TWO = 2


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
    image: Callable[[], NDArray[np.uint8]]  # (H, W, 3) blue, green, red

    def header(self, ros: Ros, frame: str) -> Message:
        """Return the header of a message in a frame."""
        numbered = {"seq": self.step} if ros is Ros.ONE else {}
        return {**numbered, "stamp": self.stamp.of(ros), "frame_id": frame}


def _xyz(values: NDArray[np.float64]) -> Message:
    return dict(zip("xyz", values.tolist(), strict=True))


def _level(now: Moment, ros: Ros) -> Message:
    return {"data": orjson.dumps(dict(now.level)).decode()}


def _original_level(now: Moment, ros: Ros) -> Message:
    return {"data": f"Updated scene {now.level['index']}"}


def _image(now: Moment, ros: Ros) -> Message:
    rgb = np.ascontiguousarray(now.image()[..., ::-1])
    height, width, channels = rgb.shape
    return {
        "header": now.header(ros, CAMERA),
        "height": height,
        "width": width,
        "encoding": "rgb8",
        "is_bigendian": 0,
        "step": width * channels,
        "data": base64.b64encode(rgb.tobytes()).decode(),
    }


def _compressed_image(now: Moment, ros: Ros) -> Message:
    _done, png = cv2.imencode(".png", now.image())
    data = base64.b64encode(png.tobytes()).decode()
    return {"header": now.header(ros, CAMERA), "format": "png", "data": data}


def _camera(now: Moment, ros: Ros) -> Message:
    optics = now.optics
    (u, v), f = optics.principal_px, optics.focal_px
    matrices = {
        "d": [0.0] * 5,
        "k": [f, 0.0, u, 0.0, f, v, 0.0, 0.0, 1.0],
        "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "p": [f, 0.0, u, 0.0, 0.0, f, v, 0.0, 0.0, 0.0, 1.0, 0.0],
    }
    if ros is Ros.ONE:
        matrices = {name.upper(): values for name, values in matrices.items()}
    return {
        "header": now.header(ros, CAMERA),
        "height": optics.height,
        "width": optics.width,
        "distortion_model": "plumb_bob",
        **matrices,
    }


def _pose(now: Moment, ros: Ros) -> Message:
    at = now.navigation
    return {
        "header": now.header(ros, WORLD),
        "pose": {
            "position": {"x": at.north_m, "y": at.east_m, "z": at.down_m},
            "orientation": dict(zip("xyzw", at.orientation, strict=True)),
        },
    }


def _velocity(now: Moment, ros: Ros) -> Message:
    twist = {"linear": _xyz(now.seen.velocity), "angular": _xyz(now.seen.rates)}
    return {"header": now.header(ros, BODY), "twist": twist}


def _velocity_valid(now: Moment, ros: Ros) -> Message:
    return {"data": now.seen.velocity_valid}


def _altitude(now: Moment, ros: Ros) -> Message:
    return {"data": now.seen.altitude}


def _thrust(now: Moment, ros: Ros) -> Message:
    values = now.seen.thrust.tolist()
    label = {"label": "thruster", "size": len(values), "stride": len(values)}
    return {"layout": {"dim": [label], "data_offset": 0}, "data": values}


def _visible(now: Moment, ros: Ros) -> Message:
    return {"data": now.seen.target_visible}


def _error_px(now: Moment, ros: Ros) -> Message:
    x, y = now.seen.error_px.tolist()
    return {"header": now.header(ros, CAMERA), "point": {"x": x, "y": y, "z": 0.0}}


def _error(now: Moment, ros: Ros) -> Message:
    return {"header": now.header(ros, BODY), "vector": _xyz(now.seen.error)}


def _original_error(now: Moment, ros: Ros) -> Message:
    upright = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
    pose = {"position": _xyz(now.seen.error), "orientation": upright}
    return {"header": now.header(ros, BODY), "pose": pose}


def _clock(now: Moment, ros: Ros) -> Message:
    return {"clock": now.stamp.of(ros)}


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic that the bridge publishes."""

    package: str
    kind: str
    meaning: str
    message: Callable[[Moment, Ros], Message]
    at_levels: bool = False  # published only when a level begins

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
    "/seamark/pose": Topic(
        "geometry_msgs", "PoseStamped", "pose by dead reckoning since the level began", _pose
    ),
    "/seamark/velocity": Topic(
        "geometry_msgs", "TwistStamped", "velocity (DVL) and rates, body frame", _velocity
    ),
    "/seamark/velocity_valid": Topic(
        "std_msgs", "Bool", "whether the last DVL measurement was good", _velocity_valid
    ),
    "/seamark/altitude": Topic("std_msgs", "Float64", "height above the bottom [m]", _altitude),
    "/seamark/thrust": Topic(
        "std_msgs", "Float64MultiArray", "last thrust of each thruster [N]", _thrust
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


def resolved(name: str) -> str:
    """Return the global name of a topic: a relative one belongs to the root."""
    return name if name.startswith("/") else f"/{name}"
