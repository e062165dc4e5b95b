"""Targets cut out of photographs, displaced at random between two images, or turning slowly.

Displacements as in Baker & Matthews (IJCV 2004): each corner of the target moves by independent
Gaussian noise, and the homography of the four moves the whole photograph. Cubic interpolation
draws the images, so that no tracker's own interpolation is favoured.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from performance.perception.trackers.sequences import TURN_DEGREES, Sequence
from seamark.sim.camera.pictures import PHOTOGRAPHS, SIDE, picture
from seamark.sim.trackers.template.warps import is_convex, signed_area

SIGMAS_PX = (8.0, 11.0, 14.0, 18.0)
NOISE_GREY = 1.5  # E: standard deviation of the camera's noise, about that of our camera
LEAST_AREA = 0.25  # of the target's; a flatter quadrilateral is drawn again
SIZE = (320, 240)
TARGET_PX = (120, 90)
TURNED_PX = ((120.0, 90.0, 0.0), (110.0, 80.0, 0.1), (100.0, 75.0, 0.2), (85.0, 57.0, 0.3))

Array = NDArray[np.float64]
_MIDDLE = 0.5 * (np.array(SIZE) - 1.0)
_SQUARE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])


@dataclass(frozen=True, slots=True)
class Displaced:
    """Two images (H, W) and the target's corners (4, 2) [px] in each."""

    first: NDArray[np.uint8]
    before: Array
    second: NDArray[np.uint8]
    after: Array


def displaced(sigma_px: float, *, each: int, seed: int = 1) -> Iterator[Displaced]:
    """Yield targets whose corners move by this standard deviation, `each` from every photograph."""
    before = _MIDDLE + _SQUARE * TARGET_PX
    for number, name in enumerate(PHOTOGRAPHS):
        random = np.random.default_rng([seed, number, round(10 * sigma_px)])
        for _ in range(each):
            cut = _translation(_MIDDLE - 0.5 * SIDE + random.uniform(-20.0, 20.0, 2))
            after = _moved(before, sigma_px, random)
            points = (before.astype(np.float32), after.astype(np.float32))
            warp = cv2.getPerspectiveTransform(*points)
            first, second = (_view(name, h, random) for h in (cut, warp @ cut))
            yield Displaced(first, before, second, after)


def turning(name: str, width: float, height: float, phase: float) -> Sequence:
    """Return a photograph that turns by TURN_DEGREES about the target's centre.

    `phase` [px, and 20 times as many rad] shifts and turns the target on the pixel grid.
    """
    random = np.random.default_rng(round(1000 * phase))
    centre = _MIDDLE + phase
    before = centre + _SQUARE * (width, height)
    images, corners = [], []
    for angle in np.deg2rad(TURN_DEGREES) + 20.0 * phase:
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        warp = np.eye(3)
        warp[:2, :2], warp[:2, 2] = turn, centre - turn @ centre
        images.append(_view(name, warp @ _translation(_MIDDLE - 0.5 * SIDE), random))
        corners.append((before - centre) @ turn.T + centre)
    return Sequence(np.stack(images), np.stack(corners))


def _moved(corners: Array, sigma_px: float, random: np.random.Generator) -> Array:
    """Return displaced corners (4, 2): inside the image, convex and not too flat."""
    area = float(np.prod(TARGET_PX))
    while True:
        moved: Array = corners + sigma_px * random.standard_normal((4, 2))
        inside = bool((moved > 0).all() and (moved < np.array(SIZE) - 1).all())
        if inside and is_convex(moved) and signed_area(moved) > LEAST_AREA * area:
            return moved


def _translation(shift: Array) -> Array:
    return np.array([[1.0, 0.0, shift[0]], [0.0, 1.0, shift[1]], [0.0, 0.0, 1.0]])


def _view(name: str, warp: Array, random: np.random.Generator) -> NDArray[np.uint8]:
    """Return an image (H, W) of a photograph under a homography (3, 3), with noise."""
    drawn = cv2.warpPerspective(
        picture(name), warp, SIZE, flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT
    )
    noisy = drawn + NOISE_GREY * random.standard_normal(drawn.shape)
    return np.clip(np.round(noisy), 0, 255).astype(np.uint8)
