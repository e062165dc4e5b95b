"""Images that `seamark dataset --format csv` has written, and what a network is to say of each."""

import csv
import io
import json
import zipfile
from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from seamark.sim.detectors.network.reading import CELLS, LABELS, OUTPUTS, SIZE_PX, STRIDE, views

FOLDER = "seamark-dataset"
CLASSES = len(LABELS)
SPREAD, LEAST_SPREAD = 0.15, 0.6  # of a target: share of the object's size; cells
NEAR = 0.3  # cells with a larger target learn the shape of the object, too
ROWS, COLUMNS = np.mgrid[: CELLS[0], : CELLS[1]].astype(np.float32)


class Thing(NamedTuple):
    """An object in an image."""

    number: int  # of its class
    counts: bool
    corners: np.ndarray  # (4, 2) [px]


class Shown:
    """The images of an archive that `seamark dataset --format csv` has written."""

    def __init__(self, path: Path) -> None:
        archive = zipfile.ZipFile(path)

        def read(name: str) -> bytes:
            return archive.read(f"{FOLDER}/{name}")

        self.manifest = json.loads(read("manifest.json"))
        things = defaultdict(list)
        for line in csv.DictReader(io.StringIO(read("objects.csv").decode())):
            corners = [float(line[f"corner_{axis}{k}"]) for k in range(4) for axis in "uv"]
            thing = Thing(
                LABELS.index(line["class"]), line["counts"] == "1", np.reshape(corners, (4, 2))
            )
            things[line["file"]].append(thing)
        names = [line["file"] for line in csv.DictReader(io.StringIO(read("images.csv").decode()))]
        self.files = [np.frombuffer(read(f"images/{name}"), np.uint8) for name in names]
        self.things = [things[name] for name in names]

    def sample(self, number: int, *, turned: bool) -> tuple[np.ndarray, ...]:
        """Return what the network sees of an image and its targets, turned upside down or not."""
        image, things = cv2.imdecode(self.files[number], cv2.IMREAD_GRAYSCALE), self.things[number]
        if turned:
            far = np.array(image.shape[::-1]) - 1.0
            image = image[::-1, ::-1]
            things = [thing._replace(corners=far - thing.corners) for thing in things]
        return views(image), *targets(things)


def targets(things: list[Thing]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the targets of an image.

    Returns
    -------
    scores, weights : (CLASSES, 30, 40)
        Near 1 at the centre of an object; weights are 0 around objects that the benchmark ignores.
    shape, near : (6, 30, 40), (30, 40)
        The numbers that `reading.corners_of` reads, the last two as shares, and their weight.
    """
    scores, weights = (
        np.zeros((CLASSES, *CELLS), np.float32),
        np.ones((CLASSES, *CELLS), np.float32),
    )
    shape, near = np.zeros((OUTPUTS - CLASSES, *CELLS), np.float32), np.zeros(CELLS, np.float32)
    for thing in things:
        low, high = thing.corners.min(axis=0), thing.corners.max(axis=0)
        size = high - low
        right, down = (0.5 * (low + high) + 0.5) / STRIDE - 0.5
        right, down = right - COLUMNS, down - ROWS
        if not thing.counts:
            width, height = 0.5 * size / STRIDE + 1.0
            weights[thing.number][(np.abs(right) <= width) & (np.abs(down) <= height)] = 0.0
            continue
        spread = np.maximum(SPREAD * size / STRIDE, LEAST_SPREAD)
        score = np.exp(-0.5 * ((right / spread[0]) ** 2 + (down / spread[1]) ** 2))
        scores[thing.number] = np.maximum(scores[thing.number], score)
        mine = (score > near) & (score > NEAR)
        numbers = (right, down, *np.log(size / SIZE_PX), *shares(thing.corners))
        for channel, number in enumerate(numbers):
            shape[channel][mine] = np.broadcast_to(number, CELLS)[mine]
        near[mine] = score[mine]
    return scores, weights, shape, near


def shares(corners: np.ndarray) -> tuple[float, float]:
    """Return where along the upper and right side of its upright box a parallelogram touches."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    (u, v), (width, height) = corners.T, high - low
    across = (u[v.argmin()] - low[0]) + (high[0] - u[v.argmax()])
    along = (v[u.argmax()] - low[1]) + (high[1] - v[u.argmin()])
    return 0.5 * across / width, 0.5 * along / height
