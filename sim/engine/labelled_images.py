"""Images with the objects in them, for training detectors: what an experiment draws for them.

A level's seed has at most 63 bits (`engine.seeds`), whoever chose or drew it. Training images come
from seeds above these, so that no trial of any run, public or secret, shows one of them.
"""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.bottom.camera import Seen
from seamark.sim.camera.bottom.things import OBJECTS
from seamark.sim.engine.seeds import SEED_BITS
from seamark.sim.metrics.detection import ABSENT, COUNTS, Object, match
from seamark.sim.recording.telemetry import OBJECT, objects_of

_STATE, _VISIBLE = OBJECT["state"], OBJECT["visible"]
_FIRST_SEED = 1 << (SEED_BITS + 1)


class Label(NamedTuple):
    """An object in an image."""

    number: int  # of its class, from 0 in the order of `patterns.CLASSES`
    corners: NDArray[np.float64]  # (4, 2) [px] of its plan rectangle, in the image or not
    counts: bool  # whether the benchmark counts it; it ignores what is mostly hidden or cut off
    visible: float  # share of its outline that is in the image and not covered
    distance: float  # [m] of the camera from its centre
    angle: float  # [rad] between the line of sight and the normal of the bottom


class LabelledImage(NamedTuple):
    """An image and the objects in it."""

    image: NDArray[np.uint8]  # (H, W) grey, or (H, W, 3) blue, green, red
    labels: list[Label]
    scene: int  # number of the bottom, from 0
    optical_depth: float
    altitude_m: float  # of the camera above the bottom: mean of the passage


class LabelledScenes(Protocol):
    """An experiment that can draw scenes for training."""

    images_per_scene: int

    def labelled_scene(
        self, config: Any, number: int, *, seed: int, images: int
    ) -> Iterator[LabelledImage]:
        """Yield the first images of a scene, which depend on these values only."""


def training_seed(seed: int) -> int:
    """Return the seed of scenes for training; it differs from the seeds of all runs."""
    return _FIRST_SEED + seed


def labelled_images(
    experiment: LabelledScenes, config: Any, *, seed: int, count: int
) -> Iterator[LabelledImage]:
    """Yield images to train with, scene by scene; fewer are the beginning of more."""
    for scene, first in enumerate(range(0, count, experiment.images_per_scene)):
        images = min(experiment.images_per_scene, count - first)
        yield from experiment.labelled_scene(config, scene, seed=seed, images=images)


def labels_of(seen: Sequence[Seen], image_size: tuple[int, int]) -> list[Label]:
    """Return the objects that are in an image, by the rules of `metrics.detection`.

    Parameters
    ----------
    seen
        Of each thing, objects first.
    image_size
        Width and height [px].
    """
    objects = [Object(*one[1:]) for one in seen[:OBJECTS]]
    rows = objects_of(match(objects, (), (), image_size).columns).tolist()
    return [
        Label(number, one.corners, row[_STATE] == COUNTS, row[_VISIBLE], one.distance, one.angle)
        for number, (one, row) in enumerate(zip(objects, rows, strict=True))
        if row[_STATE] != ABSENT
    ]
