"""`face` and `outline`: a coarse search for places, a fit of the picture, and reading."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.detectors.boxes import first_apart
from seamark.sim.detectors.faces.fitting import (
    Look,
    Map,
    Plane,
    agreement,
    levels,
    step,
)
from seamark.sim.detectors.faces.picture import (
    HALF_LENGTH,
    HALF_WIDTH,
    LETTERS,
    RIGHT,
    UNKNOWN,
    Texels,
    pictures,
)
from seamark.sim.detectors.faces.reading import evidence, likeliest, misfits
from seamark.sim.detectors.faces.shape import candidates, shape
from seamark.sim.detectors.interface import Corners, Detection, Image, grey, most_confident
from seamark.sim.detectors.template.matching import octaves
from seamark.sim.numerics.libm import cos, exp, sin

LABEL = "box"
_SOFT, _SHARP = 3.0, 1.0  # [px] over which the edge of a face goes, E
_FEW_PX, _MANY_PX = 25.0, 45.0  # pixels along a face that a fit looks at, E
_EITHER_STEPS, _SOFT_STEPS, _SHARP_STEPS, _READ_STEPS = 3, 2, 2, 1  # E
_PASSES = 2  # of reading, E
_FITTED = 5  # places, E
_PROMISING = 0.10  # E: agreement of an unsharp picture from which a place is looked at closely
_UNSURE, _SURE = 0.30, 0.45  # E: agreement at which a place is no box, and surely one
_BLANK, _LETTERED = 0.15, 0.35  # E: likewise, on the face alone
_TRUST = 0.5  # E: in what the letters say; pixels are off together
_LENGTHS_PX = (16.0, 100.0)  # of a face, E
_SAME = 0.3  # intersection over union from which two answers are one


class Found(NamedTuple):
    """A face, or what looks like one."""

    at: Map
    agreement: float
    printed: float
    evidence: float  # for the right letters


class OutlineDetector:
    """Finds lettered boxes, whatever their letters are."""

    _reads = False

    def __init__(self) -> None:
        self._pictures, self._shape = pictures(), shape()

    def detect(self, image: Image) -> list[Detection]:
        """Return the boxes of an image."""
        whole = np.ascontiguousarray(grey(image))
        images = octaves(whole)
        found = []
        for u, v, length, heading in candidates(whole, images, self._shape)[:_FITTED].tolist():
            x, y = length * cos(heading), length * sin(heading)
            one = _examined(images[0], Map(u, v, x, y, -y, x), *self._pictures, self._reads)
            confidence = self._confidence(one)
            if confidence > 0.0:
                found.append(Detection(LABEL, _corners(one.at), confidence))
        return first_apart(most_confident(found), _SAME)

    def _confidence(self, one: Found) -> float:
        fit = (one.agreement - _UNSURE) / (_SURE - _UNSURE)
        printed = (one.printed - _BLANK) / (_LETTERED - _BLANK)
        return min(max(min(fit, printed), 0.0), 1.0)


class FaceDetector(OutlineDetector):
    """Finds lettered boxes, and says how likely each has the right letters."""

    _reads = True

    def _confidence(self, one: Found) -> float:
        box = super()._confidence(one)
        return box / (1.0 + exp(-_TRUST * box * one.evidence))


@njit(cache=True, nogil=True, error_model="numpy")
def _examined(
    image: Plane, at: Map, sharp: Texels, soft: Texels, either: Texels, reads: bool
) -> Found:
    """Return the face near a place, the right way up."""
    none, unknown = np.zeros(LETTERS, np.int64), np.full(LETTERS, UNKNOWN)
    at, fit, printed = _fitted(image, at, Look(either, none, _SOFT, _FEW_PX), _EITHER_STEPS)
    if fit < _PROMISING:
        return Found(at, 0.0, 0.0, 0.0)
    look = Look(soft, none, _SOFT, _FEW_PX)
    turned = Map(at.u, at.v, -at.ax, -at.ay, -at.bx, -at.by)
    if _fitted(image, turned, look, 0)[1] > _fitted(image, at, look, 0)[1]:
        at = turned
    at, fit, printed = _fitted(image, at, look, _SOFT_STEPS)
    length = np.sqrt(at.ax * at.ax + at.ay * at.ay)
    if min(fit, printed) < _PROMISING or not _LENGTHS_PX[0] < length < _LENGTHS_PX[1]:
        return Found(at, 0.0, 0.0, 0.0)
    at, fit, printed = _fitted(image, at, Look(sharp, unknown, _SHARP, _MANY_PX), _SHARP_STEPS)
    if not reads or fit < _UNSURE or printed < _BLANK:
        return Found(at, fit, printed, 0.0)
    at, likelier = _read(image, at, sharp, unknown)
    return Found(at, fit, printed, likelier)


@njit(cache=True, nogil=True, error_model="numpy")
def _fitted(image: Plane, at: Map, look: Look, steps: int) -> tuple[Map, float, float]:
    """Return a map that fits better, its agreement with the image, and that on the face."""
    for _ in range(steps):
        at = step(image, at, look)
    have = levels(image, at, look)
    return at, agreement(image, at, look, have), have.printed


@njit(cache=True, nogil=True, error_model="numpy")
def _read(image: Plane, at: Map, sharp: Texels, letters: NDArray[np.int64]) -> tuple[Map, float]:
    """Return the map with the letters that are likeliest, and the evidence for the right ones."""
    for _ in range(_PASSES):
        have = levels(image, at, Look(sharp, letters, _SHARP, _MANY_PX))
        letters = likeliest(misfits(image, at, sharp, have)[0])
        for _ in range(_READ_STEPS):
            at = step(image, at, Look(sharp, letters, _SHARP, _MANY_PX))
    have = levels(image, at, Look(sharp, letters, _SHARP, _MANY_PX))
    squares, pixels = misfits(image, at, sharp, have)
    return at, evidence(squares, pixels, have, RIGHT)


def _corners(at: Map) -> Corners:
    """Return the corners (4, 2) [px] of a face in reading order."""
    along = HALF_LENGTH * np.array([at.ax, at.ay])
    down = HALF_WIDTH * np.array([at.bx, at.by])
    middle = np.array([at.u, at.v])
    return np.array(
        [middle - along - down, middle + along - down, middle + along + down, middle - along + down]
    )
