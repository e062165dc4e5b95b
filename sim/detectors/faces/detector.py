"""`face` and `outline`: a coarse search for places, a fit of the picture, and reading."""

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
    Pictures,
    Texels,
    pictures,
)
from seamark.sim.detectors.faces.reading import evidence, likeliest, misfits
from seamark.sim.detectors.faces.shape import candidates, shape
from seamark.sim.detectors.interface import Corners, Detection, Image, grey, most_confident
from seamark.sim.detectors.template.matching import octaves
from seamark.sim.numerics.libm import cos, exp, sin

LABEL = "box"
_COARSE = 0.1  # of the length of a face, over which its edge goes at first, E
_SOFT, _SHARP = 3.0, 1.0  # [px] likewise, and at last
_FEW_PX, _MANY_PX = 25.0, 45.0  # pixels along a face that a fit looks at, E
_EITHER_STEPS, _SOFT_STEPS, _SHARP_STEPS, _READ_STEPS = 3, 2, 2, 1  # E
_PASSES = 2  # of reading, E
_PROMISING = 0.17  # E: agreement of an unsharp picture from which a place is looked at closely
_UNSURE, _SURE = 0.30, 0.45  # E: agreement at which a place is no box, and surely one
_BLANK, _LETTERED = 0.15, 0.35  # E: likewise, on the face alone
_TRUST = 0.5  # E: in what the letters say; pixels are off together
_LENGTHS_PX = (16.0, 100.0)  # of a face, E
_WIDEST = 400  # [px] E: faces in wider images are larger than those that are searched for
_HALVINGS = 3  # at most, as `octaves` has them
_SAME = 0.3  # intersection over union from which two answers are one


class OutlineDetector:
    """Finds lettered boxes, whatever their letters are."""

    _reads = False

    def __init__(self) -> None:
        self._pictures, self._shape = pictures(), shape()

    def detect(self, image: Image) -> list[Detection]:
        """Return the boxes of an image."""
        small, pixels = _reduced(np.ascontiguousarray(grey(image)))
        images = octaves(small)
        poses = candidates(small, images, self._shape)
        found = []
        for row in _examined(images[0], poses, self._pictures, self._reads).tolist():
            confidence = self._confidence(*row[6:])
            if confidence > 0.0:
                corners = (_corners(Map(*row[:6])) + 0.5) * pixels - 0.5
                found.append(Detection(LABEL, corners, confidence))
        return first_apart(most_confident(found), _SAME)

    def _confidence(self, agreement: float, printed: float, _evidence: float) -> float:
        """Return the confidence that a place is such a box."""
        fit = (agreement - _UNSURE) / (_SURE - _UNSURE)
        lettered = (printed - _BLANK) / (_LETTERED - _BLANK)
        return min(max(min(fit, lettered), 0.0), 1.0)


class FaceDetector(OutlineDetector):
    """Finds lettered boxes, and says how likely each has the right letters."""

    _reads = True

    def _confidence(self, agreement: float, printed: float, evidence: float) -> float:
        box = super()._confidence(agreement, printed, evidence)
        return box / (1.0 + exp(-_TRUST * box * evidence))


def _reduced(image: Image) -> tuple[Image, int]:
    """Return an image of at most _WIDEST columns, or an eighth, and the size of its pixels [px]."""
    halvings = 0
    while image.shape[1] >> halvings > _WIDEST and halvings < _HALVINGS:
        halvings += 1
    if halvings == 0:
        return image, 1
    return (octaves(image)[halvings] + 0.5).astype(np.uint8), 1 << halvings


@njit(cache=True, nogil=True, error_model="numpy")
def _examined(
    image: Plane, poses: NDArray[np.float64], known: Pictures, reads: bool
) -> NDArray[np.float64]:
    """Return what is near the places that look most like a face, (n, 9).

    The six numbers of its map, its agreement with the picture of a face, that on the face alone,
    and the evidence for the right letters.
    """
    none = np.zeros(LETTERS, np.int64)
    out = np.zeros((poses.shape[0], 9))
    for k in range(poses.shape[0]):
        x, y = poses[k, 2] * cos(poses[k, 3]), poses[k, 2] * sin(poses[k, 3])
        at = Map(poses[k, 0], poses[k, 1], x, y, -y, x)
        look = Look(known.either, none, max(_SOFT, _COARSE * poses[k, 2]), _FEW_PX)
        for _ in range(_EITHER_STEPS):
            at = step(image, at, look)
        at, out[k, 6], out[k, 7], out[k, 8] = _closely(image, at, known, reads)
        out[k, :6] = at
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _closely(
    image: Plane, at: Map, known: Pictures, reads: bool
) -> tuple[Map, float, float, float]:
    """Return a row of `_examined` for one place: which way up it is, and what it says."""
    look = Look(known.soft, np.zeros(LETTERS, np.int64), _SOFT, _FEW_PX)
    turned = Map(at.u, at.v, -at.ax, -at.ay, -at.bx, -at.by)
    if _fitted(image, turned, look, 0)[1] > _fitted(image, at, look, 0)[1]:
        at = turned
    at, fit, printed = _fitted(image, at, look, _SOFT_STEPS)
    length = np.sqrt(at.ax * at.ax + at.ay * at.ay)
    if min(fit, printed) < _PROMISING or not _LENGTHS_PX[0] < length < _LENGTHS_PX[1]:
        return at, 0.0, 0.0, 0.0
    unknown = np.full(LETTERS, UNKNOWN)
    at, fit, printed = _fitted(
        image, at, Look(known.sharp, unknown, _SHARP, _MANY_PX), _SHARP_STEPS
    )
    if not reads or fit < _UNSURE or printed < _BLANK:
        return at, fit, printed, 0.0
    at, likelier = _read(image, at, known.sharp, unknown)
    return at, fit, printed, likelier


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
