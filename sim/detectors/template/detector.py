"""`template`: a coarse search for places, then a comparison of each with looks of every kind."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.bottom.things import NAMES, OBJECTS
from seamark.sim.detectors.boxes import first_apart
from seamark.sim.detectors.interface import Corners, Detection, Image, grey, most_confident
from seamark.sim.detectors.template.library import library
from seamark.sim.detectors.template.matching import Pose, compare, octaves, refine
from seamark.sim.detectors.template.search import Prototypes, places, prototypes
from seamark.sim.numerics.libm import cos, sin

_REFINED = 60  # places, E: more cost time and find nothing else
_AGAINST = 0.5  # E: how much likeness to another kind counts against one
_LEAST = 0.5  # E: bare ground is hardly less like some look
_LEAST_CONTRAST = 2.0  # [grey] E: the noise of the camera alone has about 1 (`Water`, bilinear)
_SAME = 0.4  # intersection over union from which two answers of a label are one


class TemplateDetector:
    """Correlates places of an image with painted things of every kind, decoys and bare ground."""

    def __init__(self, *, template_places: int = 25) -> None:
        self._places = template_places
        self._library, self._prototypes = library(), _prototypes()

    def detect(self, image: Image) -> list[Detection]:
        """Return what looks more like an object than like anything else."""
        whole = grey(image)
        poses = places(whole, self._prototypes, self._places)
        images, (patches, kinds, proportions) = octaves(whole), self._library
        likeness = compare(images, poses, patches, kinds)
        chosen = np.argsort(-_confidence(likeness.values).max(axis=1), kind="stable")[:_REFINED]
        poses = poses[chosen]
        best = likeness.values[chosen, :OBJECTS].argmax(axis=1)
        refine(images, poses, patches, likeness.looks[chosen, best])
        likeness = compare(images, poses, patches, kinds)
        confidence = _confidence(likeness.values)
        shown = (likeness.contrast > _LEAST_CONTRAST)[:, None]
        found = []
        for place, label in np.argwhere(shown & (likeness.values[:, :OBJECTS] > _LEAST)).tolist():
            look = likeness.looks[place, label]
            corners = _corners(Pose(*poses[place].tolist()), float(proportions[look]))
            turned = bool(look >= len(kinds) // 2)
            found.append(
                Detection(
                    NAMES[label],
                    np.roll(corners, 2, axis=0) if turned else corners,
                    float(confidence[place, label]),
                )
            )
        return most_confident(first_apart(most_confident(found, most=len(found)), _SAME))


@lru_cache(maxsize=1)
def _prototypes() -> tuple[Prototypes, ...]:
    return prototypes(library())


def _confidence(likeness: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the confidence (n, OBJECTS) that places are objects, from their likeness (n, kinds).

    It is one for what is exactly like one kind, and unlike all others by half.
    """
    ranked = np.sort(likeness, axis=1)
    best, second = ranked[:, -1:], ranked[:, -2:-1]
    objects = likeness[:, :OBJECTS]
    others = np.where(objects == best, second, best)
    margin = np.clip(objects - others, -0.5, 0.5)
    return np.asarray(np.clip((objects + _AGAINST * margin) / (1.0 + 0.5 * _AGAINST), 0.0, 1.0))


def _corners(pose: Pose, proportion: float) -> Corners:
    """Return the corners (4, 2) [px] of a thing at a pose."""
    cosine, sine = cos(pose.heading), sin(pose.heading)
    along = 0.5 * pose.length * np.array([cosine, sine])
    across = 0.5 * pose.length * proportion * np.array([-sine, cosine])
    middle = np.array([pose.u, pose.v])
    return np.asarray(
        middle + np.array([-along - across, along - across, along + across, across - along])
    )
