"""What detectors of boxes say of the right box and of another one, and what an image costs them."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from performance.tables import cpu_us, markdown_table
from seamark.sim.detectors import Detector, make
from seamark.sim.registry import BOX_DETECTORS
from tests.sim.detectors.box_scenes import BoxView, look

DISTANCES_M = (0.9, 1.2, 1.6, 2.0, 2.4)  # of the face
OPTICAL_DEPTHS = (0.5, 1.5, 2.5, 3.5)  # of the seabed
_VIEWS = 40  # of either box at each distance and depth
_SEED = 900
_SURE = 0.5  # of 1
_NEAR = 0.15  # [lengths of the face] corners that are farther off on the average are not its own
_TIMED = 10  # views
_HEAD = (
    "detector",
    "distance [m]",
    "optical depth",
    "right boxes above 0.5 [%]",
    "other boxes above 0.5 [%]",
    "error of corners, median [px]",
    "95 % [px]",
    "CPU time [ms]",
)


class Answer(NamedTuple):
    """What a detector says of the box in a view."""

    confidence: float  # 0: it did not find it
    error_px: float  # of its corners, root mean square; NaN


def table() -> str:
    """Measure and return the table, in Markdown."""
    return markdown_table(_HEAD, _rows())


def _rows() -> Iterator[tuple[object, ...]]:
    detectors = {name: make(name) for name in BOX_DETECTORS}
    for distance in DISTANCES_M:
        for depth in OPTICAL_DEPTHS:
            random = np.random.default_rng(_SEED)
            right, other = (
                [look(random, distance, depth, right=one) for _ in range(_VIEWS)]
                for one in (True, False)
            )
            for name, detector in detectors.items():
                yield name, distance, depth, *_figures(detector, right, other)


def _figures(detector: Detector, right: list[BoxView], other: list[BoxView]) -> tuple[str, ...]:
    mine, others = ([_answer(detector, view) for view in views] for views in (right, other))
    errors = [one.error_px for one in (*mine, *others) if one.confidence > 0.0]
    images = [view.image for view in right[:_TIMED]]
    spent = cpu_us(lambda: [detector.detect(image) for image in images]) / len(images)
    return (
        *(
            f"{100.0 * np.mean([a.confidence > _SURE for a in some]):.0f}"
            for some in (mine, others)
        ),
        *(f"{np.percentile(errors, share):.2f}" if errors else "" for share in (50, 95)),
        f"{1e-3 * spent:.1f}",
    )


def _answer(detector: Detector, view: BoxView) -> Answer:
    near = _NEAR * float(np.sqrt(((view.corners[1] - view.corners[0]) ** 2).sum()))
    for one in detector.detect(view.image):
        error = float(np.sqrt(((one.corners - view.corners) ** 2).sum(axis=1).mean()))
        if error < near:
            return Answer(one.confidence, error)
    return Answer(0.0, np.nan)
