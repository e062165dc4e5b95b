"""Images with the objects in them in the layouts of other programs: COCO, YOLO and plain CSV.

Image points of COCO and YOLO are in px from the upper left corner of the image, those of CSV from
the centre of its first pixel, as Seamark's own.
"""

import json
import tempfile
from collections.abc import Iterator, Mapping
from typing import IO, Protocol

import numpy as np

from seamark.sim.engine.archive_writing import Line, Member, csv_lines
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
from seamark.sim.engine.labelled_images import Label, LabelledImage
from seamark.sim.vehicles.patterns import CLASSES

OBJECT_LINE = (
    *("file", "class", "counts", "visible", "distance_m", "angle_rad"),
    *(f"corner_{axis}{corner}" for corner in range(4) for axis in "uv"),
    *("left", "upper", "right", "lower"),
)
IMAGE_LINE = ("file", "scene", "optical_depth", "altitude_m", "objects")

_NAMES = tuple(CLASSES)
_CLASS_LIST = ", ".join(_NAMES)
_IN_MEMORY = 1 << 22  # [bytes] of annotations; more are in a temporary file until they are written
_PIECE = 1 << 20  # [bytes]

_BEGIN = """\
# Seamark images for {what}

{{count}} {{colours}} images of the sea bottom from the benchmark {{benchmark}}, with the objects in
them. Each bottom is painted anew and serves {{per_scene}} images of one passage: keep those of a
bottom together when you split them. Each has an optical depth from {{shallow:g}} to {{deep:g}}.
Classes, in the order of their numbers ({numbers}):
{classes}.

Decoys (rocks, bottles, false markers and others) have no annotation: no answer should lie on them.
The benchmark ignores an object that is mostly hidden or cut off: less than 40 % of its outline
visible, or less than 60 % in the image. {ignored}

The same version makes the same bytes again: `{{command}}`.

No trial of the benchmark shows one of these bottoms: they have seeds that no run can have. Ranked
fresh trials use secret seeds.

"""


class LabelledLayout(Protocol):
    """Writes the files of a data set as its images come, in memory that does not grow."""

    readme: str  # with {benchmark}, {count}, {colours}, {per_scene}, {shallow}, {deep}, {command}

    def add(self, name: str, labelled: LabelledImage) -> Iterator[Member]:
        """Yield the files that belong to an image alone."""

    def end(self) -> Iterator[Member]:
        """Yield the files about all images."""


class _Growing:
    """A part of a file that is kept until the images are written."""

    def __init__(self) -> None:
        self._file: IO[bytes] = tempfile.SpooledTemporaryFile(_IN_MEMORY)

    def add(self, data: bytes) -> None:
        """Append to it."""
        self._file.write(data)

    def pieces(self) -> Iterator[bytes]:
        """Yield all of it and forget it."""
        self._file.seek(0)
        while piece := self._file.read(_PIECE):
            yield piece
        self._file.close()


class _JsonList:
    """A list in JSON that is too long for the memory."""

    def __init__(self) -> None:
        self._text, self.count = _Growing(), 0

    def add(self, value: object) -> None:
        """Append a value."""
        separator = ",\n" if self.count else ""
        self._text.add((separator + json.dumps(value, allow_nan=False)).encode())
        self.count += 1

    def pieces(self) -> Iterator[bytes]:
        """Yield the list."""
        yield b"[\n"
        yield from self._text.pieces()
        yield b"\n]"


class Coco:
    """https://cocodataset.org/#format-data: instances with a polygon and four key points."""

    readme = _BEGIN.format(
        what="COCO",
        numbers=f"1 to {len(_NAMES)}",
        classes=_CLASS_LIST,
        ignored="Here it has iscrowd 1,\nas what COCO's evaluation ignores.",
    ) + (
        "annotations/instances.json has for each object its polygon, cut at the border; the\n"
        "upright box around its corners, cut at the border, which the benchmark compares; its\n"
        "corners as key points (visibility 0 outside of the image); and `visible`, the share of\n"
        "its outline that is in the image and not covered. Each image has `scene`,\n"
        "`optical_depth` and `altitude_m`. Points are in px from the upper left corner of the\n"
        "image.\n"
    )

    def __init__(self) -> None:
        self._images, self._annotations = _JsonList(), _JsonList()

    def add(self, name: str, labelled: LabelledImage) -> Iterator[Member]:
        """Note the image and its objects."""
        width, height = size = _size(labelled)
        number = self._images.count + 1
        about = {"scene": labelled.scene, "optical_depth": labelled.optical_depth}
        about |= {"altitude_m": labelled.altitude_m}
        image = {"id": number, "file_name": name, "width": width, "height": height}
        self._images.add(image | about)
        for label in labelled.labels:
            corners = label.corners + CORNER
            seen = seen_part(corners, size)
            if seen is None:
                continue
            points = coco_key_points(corners, size)
            self._annotations.add(
                {
                    "id": self._annotations.count + 1,
                    "image_id": number,
                    "category_id": label.number + 1,
                    "segmentation": [seen.ravel().tolist()],
                    "area": area(seen),
                    "bbox": coco_box(_clipped(corners, size)),
                    "iscrowd": int(not label.counts),
                    "keypoints": [value for point in points for value in point],
                    "num_keypoints": sum(point[2] > 0 for point in points),
                    "visible": label.visible,
                }
            )
        yield from ()

    def end(self) -> Iterator[Member]:
        """Yield the annotations."""
        yield "annotations/instances.json", self._document()

    def _document(self) -> Iterator[bytes]:
        about = {"description": "Seamark images of patterns", "version": "1.0"}
        corners = {
            "keypoints": [f"corner {number}" for number in range(4)],
            "skeleton": [[1, 2], [2, 3], [3, 4], [4, 1]],
        }
        categories = [
            {"id": number, "name": name, "supercategory": "object"} | corners
            for number, name in enumerate(_NAMES, start=1)
        ]
        yield b'{"info": ' + json.dumps(about).encode() + b', "licenses": [],\n"images": '
        yield from self._images.pieces()
        yield b',\n"annotations": '
        yield from self._annotations.pieces()
        yield b',\n"categories": ' + json.dumps(categories).encode() + b"}\n"


class Yolo:
    """https://docs.ultralytics.com/datasets/obb: the four corners of each object, normalised."""

    readme = _BEGIN.format(
        what="YOLO",
        numbers=f"0 to {len(_NAMES) - 1}",
        classes=_CLASS_LIST,
        ignored="It is left out here.",
    ) + (
        "labels/*.txt has for each object a line `class x1 y1 x2 y2 x3 y3 x4 y4`: its corners in\n"
        "shares of width and height. Oriented boxes (OBB) keep the heading; training of plain\n"
        "boxes reads the same lines. An object that the border cuts has the corners of the\n"
        "upright box around it, cut at the border. An empty file belongs to an image without an\n"
        "object.\n\n"
        "data.yaml names the images for training and for validation alike: make a second data set\n"
        "with another seed for the validation.\n"
    )

    def add(self, name: str, labelled: LabelledImage) -> Iterator[Member]:
        """Yield the label of an image."""
        size = _size(labelled)
        lines = [_yolo_line(label, size) for label in labelled.labels if label.counts]
        yield f"labels/{name.removesuffix('.png')}.txt", "".join(lines).encode()

    def end(self) -> Iterator[Member]:
        """Yield what Ultralytics reads first."""
        names = "".join(f"  {number}: {name}\n" for number, name in enumerate(_NAMES))
        yield "data.yaml", f"path: .\ntrain: images\nval: images\nnames:\n{names}".encode()


class Csv:
    """Two tables, of the images and of the objects in them."""

    readme = _BEGIN.format(
        what="any program",
        numbers="they have names here",
        classes=_CLASS_LIST,
        ignored="Here its `counts` is 0.",
    ) + (
        "images.csv has a line for each image: number of its bottom, optical depth, mean altitude\n"
        "of the camera [m], and how many lines of objects.csv belong to it.\n\n"
        "objects.csv has a line for each object in an image: class, `counts`, `visible` (share of\n"
        "its outline that is in the image and not covered), distance from the camera [m], angle\n"
        "between the line of sight and the normal of the bottom [rad], its corners, and the\n"
        "upright box around them, cut at the border. Points are in px, u to the right, v down;\n"
        "pixel centres are whole numbers. Corners may lie outside of the image.\n"
    )

    def __init__(self) -> None:
        self._images, self._objects = _Growing(), _Growing()
        self._images.add(csv_lines([IMAGE_LINE]))
        self._objects.add(csv_lines([OBJECT_LINE]))

    def add(self, name: str, labelled: LabelledImage) -> Iterator[Member]:
        """Note the image and its objects."""
        size = _size(labelled)
        lines = [_object_line(name, label, size) for label in labelled.labels]
        _, _, scene, depth, altitude_m = labelled
        self._images.add(csv_lines([[name, scene, depth, altitude_m, len(lines)]]))
        self._objects.add(csv_lines(lines))
        yield from ()

    def end(self) -> Iterator[Member]:
        """Yield the tables."""
        yield "images.csv", self._images.pieces()
        yield "objects.csv", self._objects.pieces()


LABELLED_LAYOUTS: Mapping[str, type[LabelledLayout]] = {
    "coco": Coco,
    "yolo": Yolo,
    "csv": Csv,
}


def _size(labelled: LabelledImage) -> tuple[int, int]:
    height, width = labelled.image.shape[:2]
    return width, height


def _clipped(corners: Points, size: tuple[int, int]) -> Points:
    """Return corners in the image; the box around them is the one that the benchmark compares."""
    points: Points = np.clip(corners, 0.0, size)
    return points


def _yolo_line(label: Label, size: tuple[int, int]) -> str:
    corners = label.corners + CORNER
    seen = corners if whole(corners, size) else upright(_clipped(corners, size))
    shares = (seen / np.array(size)).ravel()
    return " ".join([str(label.number), *(f"{share:.8f}" for share in shares)]) + "\n"


def _object_line(name: str, label: Label, size: tuple[int, int]) -> Line:
    box = upright(_clipped(label.corners + CORNER, size) - CORNER)
    numbers = [label.visible, label.distance, label.angle, *label.corners.ravel().tolist()]
    return [name, _NAMES[label.number], int(label.counts), *numbers, *box[::2].ravel().tolist()]
