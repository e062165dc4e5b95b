"""Images of the vehicle's camera as messages, with what the tracker saw in them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from seamark.formats.jpeg import jpeg
from seamark.formats.recording import Recording
from seamark.formats.ros import frames, geometry
from seamark.formats.ros.geometry import Message, Stamp
from seamark.sim import registry
from seamark.sim.recording.telemetry import INDEX, has_work

if TYPE_CHECKING:
    from seamark.sim.engine.replay import CameraFrame, Replay

IMAGES_MAX = 600  # in one file: 30 MB
PERIOD_S = 1.0  # from one image to the next, or more in a long run
LINE_LOOP = 2
GREEN, AMBER = (0.27, 0.9, 0.29), (1.0, 0.69, 0.0)  # tracked and true outline, as on the site
_PIXEL_CENTRE = 0.5  # Foxglove counts from the corner of the first pixel, Seamark from its centre
_CORNERS = slice(INDEX["corner_0"], INDEX["corner_7"] + 1)


@dataclass(frozen=True, slots=True)
class Pictures:
    """Renders one row in so many."""

    replay: Replay
    every: int  # rows

    def mount(self, row: frames.Array, stamp: Stamp) -> Message:
        """Return where the camera is on the vehicle, which is the same in the whole run."""
        mount_m = np.array(self.replay.frame(row).camera.optics.mount_m)
        position = frames.to_port_up(mount_m)
        return geometry.transform(
            frames.BASE, frames.CAMERA, stamp, position.tolist(), frames.CAMERA_ORIENTATION
        )

    def messages(self, row: frames.Array, stamp: Stamp) -> Iterator[tuple[str, Message]]:
        """Yield topic and message of what belongs to the image at a row."""
        frame = self.replay.frame(row)
        header = geometry.header(stamp, frames.CAMERA)
        if not has_work(len(row)):  # a target that an arm works on is a moving link of its own
            pose = _target_pose(frame)
            target = geometry.transform(frames.MAP, frames.TARGET, stamp, *pose)
            yield "/tf", {"transforms": [target]}
            yield "/target/pose", geometry.pose_stamped(*pose, stamp)
        yield "/camera/camera_info", _camera_info(frame, header)
        data = jpeg(frame.colour())
        yield "/camera/image/compressed", {"header": header, "format": "jpeg", "data": data}
        yield "/camera/annotations", _outlines(frame, row, stamp)


def pictures_of(recording: Recording) -> Pictures | None:
    """Return what renders the images of a run, or None if its seeds are not known."""
    if recording.seeds is None:
        return None
    from seamark.sim.engine.replay import Replay

    config: Any = registry.benchmark(recording.benchmark).restore(dict(recording.config))
    at_least = round(PERIOD_S / config.control_period_s)
    every = max(at_least, -(-recording.row_count // IMAGES_MAX))
    return Pictures(Replay(recording.benchmark, config, recording.seeds.__getitem__), every)


def _target_pose(frame: CameraFrame) -> tuple[frames.Array, frames.Array]:
    """Return the centre of the box in the world frame, and its attitude."""
    target = frame.camera.target_at(frame.motion)
    heading = np.array([0.0, 0.0, target.heading_rad])
    return frames.to_enu(target.origin()), frames.orientation(heading)


def _camera_info(frame: CameraFrame, header: Message) -> Message:
    """Return an ideal pinhole; as everywhere in ROS, pixel centres are whole numbers."""
    optics = frame.camera.optics
    focal, u0, v0 = map(float, optics.intrinsics())
    return {
        "header": header,
        "height": optics.height,
        "width": optics.width,
        "distortion_model": "plumb_bob",
        "d": [0.0] * 5,
        "k": [focal, 0.0, u0, 0.0, focal, v0, 0.0, 0.0, 1.0],
        "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "p": [focal, 0.0, u0, 0.0, 0.0, focal, v0, 0.0, 0.0, 0.0, 1.0, 0.0],
        "binning_x": 0,
        "binning_y": 0,
        "roi": {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False},
    }


def _outlines(frame: CameraFrame, row: frames.Array, stamp: Stamp) -> Message:
    """Return the tracked outline, if there is one, and the true one."""
    lines = []
    if row[INDEX["tracker_ok"]] == 1.0:
        lines.append(_outline(row[_CORNERS].reshape(4, 2), GREEN, 2.0, stamp))
    lines.append(_outline(frame.corners(), AMBER, 1.0, stamp))
    return {
        "timestamp": stamp,
        "circles": [],
        "points": [line for line in lines if line],
        "texts": [],
        "metadata": [],
    }


def _outline(
    corners: frames.Array, colour: tuple[float, float, float], thickness: float, stamp: Stamp
) -> Message | None:
    if not np.isfinite(corners).all():
        return None
    red, green, blue = colour
    return {
        "timestamp": stamp,
        "type": LINE_LOOP,
        "points": [{"x": u, "y": v} for u, v in (corners + _PIXEL_CENTRE).tolist()],
        "outline_color": {"r": red, "g": green, "b": blue, "a": 1.0},
        "outline_colors": [],
        "fill_color": {"r": 0.0, "g": 0.0, "b": 0.0, "a": 0.0},
        "thickness": thickness,
        "metadata": [],
    }
