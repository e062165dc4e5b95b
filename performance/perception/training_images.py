"""Images to train detectors with, compared with the plain image of the camera of the same size.

A labelled image is its share of painting the bottom, the image and its labels. What the files of an
archive cost is said apart.
"""

from collections import deque
from collections.abc import Callable
from functools import partial

from performance.tables import Row, cpu_us
from seamark.sim.benchmarks.patterns_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.patterns_v1.settings import PatternsConfiguration
from seamark.sim.camera import VISIBILITY, Camera, Target, Water, start_pose
from seamark.sim.engine.archive_writing import png
from seamark.sim.engine.labelled_images import LabelledImage, labelled_images
from seamark.sim.engine.labelled_layouts import LABELLED_LAYOUTS

SCENES = 4
HEIGHT_M = 1.27


def rows() -> list[Row]:
    """Measure and return the rows."""
    target = Target()
    camera = Camera(VISIBILITY, Water(), target, noise_seed=1)
    pose = start_pose(VISIBILITY, target, HEIGHT_M)
    found = []
    for name, show in (("grey", camera.grey), ("colour", camera.colour)):
        images = _images(colour=name == "colour")
        plain_us = cpu_us(partial(show, pose, 3), inner=20)
        drawn_us = cpu_us(partial(_images, colour=name == "colour")) / len(images)
        files: dict[str, Callable[[], object]] = {"PNG": partial(_encoded, images)}
        files |= {layout: partial(_laid_out, layout, images) for layout in LABELLED_LAYOUTS}
        costs = {f"{name} image with labels": drawn_us} | {
            f"{name} image as {kind}": cpu_us(call) / len(images) for kind, call in files.items()
        }
        found += [
            Row(
                what=what,
                value=value,
                unit="us CPU",
                baseline=f"plain {name} image 320x240",
                baseline_value=plain_us,
            )
            for what, value in costs.items()
        ]
    return found


def _images(*, colour: bool) -> list[LabelledImage]:
    config = PatternsConfiguration(colour=colour)
    count = SCENES * EXPERIMENT.images_per_scene
    return list(labelled_images(EXPERIMENT, config, seed=1, count=count))


def _encoded(images: list[LabelledImage]) -> list[bytes]:
    return [png(one.image) for one in images]


def _laid_out(layout: str, images: list[LabelledImage]) -> None:
    written = LABELLED_LAYOUTS[layout]()
    for number, one in enumerate(images):
        deque(written.add(f"{number:06d}.png", one), maxlen=0)
