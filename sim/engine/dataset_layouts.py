"""Data sets in the layouts of other programs: COCO, YOLO and TUM.

Image points are in px from the upper left corner of the image, as COCO and YOLO count: 0.5 more
than in Seamark, where pixel centres are whole numbers.
"""

import json
from collections.abc import Iterator
from math import sqrt
from typing import Protocol

import numpy as np

from seamark.sim.engine.image_polygons import (
    CORNER,
    Points,
    area,
    coco_box,
    coco_key_points,
    seen_part,
    upright,
    whole,
)
from seamark.sim.engine.replay import CameraFrame, Row
from seamark.sim.recording.telemetry import INDEX

_NAMES = ("upper left", "upper right", "lower right", "lower left")

_BEGIN = """\
# Seamark data set for {what}

Images of the vehicle's downward camera with the true position of the target, from the benchmark
{{benchmark}}. {{count}} They are {{colours}}. camera.json has the pinhole (no distortion), its
mount on the vehicle and the water; configuration.json and manifest.json have settings and seed.

The same version makes the same bytes again: `{{command}}`.

"""


class Layout(Protocol):
    """Writes the files of a data set as its images come."""

    readme: str  # with {benchmark}, {count}, {colours} and {command}
    images: str  # folder of the images

    def add(self, name: str, row: Row, frame: CameraFrame) -> Iterator[tuple[str, bytes]]:
        """Yield the files that belong to an image alone."""

    def end(self) -> Iterator[tuple[str, bytes]]:
        """Yield the files about all images."""


class Coco:
    """https://cocodataset.org/#format-data: instances with a polygon and four key points."""

    readme = _BEGIN.format(what="COCO") + (
        "annotations/instances.json has for each image in which the target is seen its polygon\n"
        "and box, cut at the border, and its four corners as key points (visibility 0 outside of\n"
        "the image). An image without an annotation does not show the target. Points are in px\n"
        "from the upper left corner of the image.\n"
    )
    images = "images"

    def __init__(self) -> None:
        self._images: list[object] = []
        self._annotations: list[object] = []

    def add(self, name: str, row: Row, frame: CameraFrame) -> Iterator[tuple[str, bytes]]:
        """Note the image and its target."""
        width, height = size = _size(frame)
        number = len(self._images) + 1
        image = {"id": number, "file_name": name, "width": width, "height": height}
        self._images.append(image)
        seen = seen_part(_corners(frame), size)
        if seen is not None:
            corners = coco_key_points(_corners(frame), size)
            self._annotations.append(
                {
                    "id": len(self._annotations) + 1,
                    "image_id": number,
                    "category_id": 1,
                    "segmentation": [seen.ravel().tolist()],
                    "area": area(seen),
                    "bbox": coco_box(seen),
                    "iscrowd": 0,
                    "keypoints": [value for corner in corners for value in corner],
                    "num_keypoints": sum(corner[2] > 0 for corner in corners),
                }
            )
        yield from ()

    def end(self) -> Iterator[tuple[str, bytes]]:
        """Yield the annotations."""
        around = [[1, 2], [2, 3], [3, 4], [4, 1]]
        category = {"id": 1, "name": "target", "supercategory": "target"}
        document = {
            "info": {"description": "Seamark data set", "version": "1.0"},
            "licenses": [],
            "images": self._images,
            "annotations": self._annotations,
            "categories": [category | {"keypoints": list(_NAMES), "skeleton": around}],
        }
        yield "annotations/instances.json", json.dumps(document, allow_nan=False).encode() + b"\n"


class Yolo:
    """https://docs.ultralytics.com/datasets/obb: the four corners of the target, normalised."""

    readme = _BEGIN.format(what="YOLO") + (
        "labels/*.txt has for each image a line `0 x1 y1 x2 y2 x3 y3 x4 y4`: the corners of the\n"
        "target, clockwise from its letters' upper left, in shares of width and height. Oriented\n"
        "boxes (OBB) keep the heading of the target; training of plain boxes reads the same\n"
        "lines. A target that the border cuts has the corners of the upright box around what is\n"
        "seen of it. An empty file belongs to an image without the target.\n\n"
        "data.yaml names the images for training and for validation alike: make a second data set\n"
        "with another seed for the validation.\n"
    )
    images = "images"

    def add(self, name: str, row: Row, frame: CameraFrame) -> Iterator[tuple[str, bytes]]:
        """Yield the label of an image."""
        size, corners = _size(frame), _corners(frame)
        seen, line = seen_part(corners, size), ""
        if seen is not None:
            shares = (corners if whole(corners, size) else upright(seen)) / np.array(size)
            line = " ".join(["0", *(f"{share:.8f}" for share in shares.ravel())]) + "\n"
        yield f"labels/{name.removesuffix('.png')}.txt", line.encode()

    def end(self) -> Iterator[tuple[str, bytes]]:
        """Yield what Ultralytics reads first."""
        yield "data.yaml", b"path: .\ntrain: images\nval: images\nnames:\n  0: target\n"


class Tum:
    """https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats: images and a trajectory."""

    readme = _BEGIN.format(what="TUM RGB-D tools") + (
        "rgb.txt has `timestamp file` of each image, groundtruth.txt `timestamp tx ty tz qx qy qz\n"
        "qw`: the pose of the camera in the world. The world is north, east, down [m]; the camera\n"
        "has x to the right of the image, y down and z along its axis. Times are simulated [s].\n"
        "At each level the vehicle is back at its start.\n"
    )
    images = "rgb"

    def __init__(self) -> None:
        self._images = ["# color images", "# timestamp filename"]
        self._poses = ["# ground truth trajectory", "# timestamp tx ty tz qx qy qz qw"]

    def add(self, name: str, row: Row, frame: CameraFrame) -> Iterator[tuple[str, bytes]]:
        """Note time and pose of an image."""
        time = f"{row[INDEX['t']]:.6f}"
        position = frame.camera.truth(frame.motion)[-3:]
        turn = camera_orientation(*row[INDEX["roll"] : INDEX["yaw"] + 1].tolist())
        self._images.append(f"{time} {self.images}/{name}")
        self._poses.append(" ".join([time, *(f"{value:.9f}" for value in (*position, *turn))]))
        yield from ()

    def end(self) -> Iterator[tuple[str, bytes]]:
        """Yield the lists."""
        yield "rgb.txt", "\n".join([*self._images, ""]).encode()
        yield "groundtruth.txt", "\n".join([*self._poses, ""]).encode()


def camera_orientation(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """Return the attitude of the camera's optical frame in north, east, down: x, y, z, w.

    The optical frame is the body's, a quarter of a turn to starboard: its x is starboard, y aft.
    """
    (sr, cr), (sp, cp), (sy, cy) = (
        (float(np.sin(0.5 * one)), float(np.cos(0.5 * one))) for one in (roll, pitch, yaw)
    )
    w, x = cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy
    y, z = cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy
    half = sqrt(0.5)
    return half * (x + y), half * (y - x), half * (z + w), half * (w - z)


def _corners(frame: CameraFrame) -> Points:
    return frame.corners() + CORNER


def _size(frame: CameraFrame) -> tuple[int, int]:
    return frame.camera.optics.width, frame.camera.optics.height
