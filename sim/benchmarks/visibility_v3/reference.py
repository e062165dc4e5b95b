"""Reference entries of visibility-v3 that see what no program does."""

from collections.abc import Callable
from enum import Enum

import cv2
import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.moving_target import MovingTargetCamera
from seamark.sim.metrics.tracking import FAR_PX
from seamark.sim.metrics.tracking_answers import WRONG_COST
from seamark.sim.trackers import Track, Window
from seamark.sim.trackers.interface import Corners

Plane = NDArray[np.float32]
Pose = NDArray[np.float64]
Part = tuple[slice, slice]  # rows and columns of an image

SURE = WRONG_COST / (1.0 + WRONG_COST)  # probability of being right from which an answer pays
HALF = 55, 33  # [px] half the size of the part of an image that the target may cover; D
ROUNDING = 1.0 / 12.0  # [grey^2] variance of rounding to whole grey levels
REACH = 4.0  # standard deviations of the motion that are looked at
NEGLIGIBLE = 1e-9  # probability of a place


class Truth(Enum):
    """Stands for what only a level knows."""

    IDEAL = "ideal"  # all but the target's place


class SilentTracker:
    """Reports a loss in every image."""

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Remember the corners."""
        self._corners = corners.copy()

    def window(self) -> Window:
        """Return an empty window."""
        return 0, 0, 0, 0

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Return no corners."""
        return Track(self._corners, False, 1.0, 0)


class IdealObserver:
    """Bayes' rule with everything known but the target's place in the image.

    It knows the picture that the target gives in this water from this pose, with its turn, scale,
    tilt and blur, and that of the bottom without it; the noise; and how far the target moves from
    image to image. Each image gives the likelihood of every place, in whole pixels:

        log L(p) = sum over the target's pixels at p of (y - b)^2 - (y - s)^2, over 2 sigma^2

    with the image y, bottom b and target s. The place before, spread by the motion (a random walk),
    is the prior. It answers with the place that has most probability within the limit of p@5, if
    that makes an answer pay. Only a tracker that also foresaw the path could do better.
    """

    def __init__(
        self,
        camera: MovingTargetCamera,
        clear: MovingTargetCamera,
        pose: Callable[[int], Pose],
        *,
        motion_px: float,
    ) -> None:
        """Set up the observer of a level.

        Parameters
        ----------
        camera, clear
            That of the level, and the same in clear water.
        pose
            Returns the pose (18,) of each image of the level.
        motion_px
            How far the target moves from one image to the next.
        """
        self._camera, self._clear, self._pose = camera, clear, pose
        self._spread_px, self._image = motion_px, -1
        width, height = camera.optics.width, camera.optics.height
        self._size = height, width
        column, row = camera.optics.principal_px
        rows, columns = np.mgrid[:height, :width]
        squared = ((columns - column) ** 2 + (rows - row) ** 2) / camera.optics.focal_px**2
        self._slant = np.sqrt(1.0 + squared).astype(np.float32)
        self._belief: Plane = np.zeros(self._size, np.float32)

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Learn where the target is in the first image."""
        self._image += 1
        column, row = np.rint(corners.mean(axis=0)).astype(int)
        self._belief[:] = 0.0
        self._belief[row, column] = 1.0

    def window(self) -> Window:
        """Return the whole image."""
        return 0, 0, self._size[1], self._size[0]

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Return the likeliest place in the next image (H, W)."""
        self._image += 1
        pose = self._pose(self._image)
        corners = self._camera.corners(pose)
        true = np.rint(corners.mean(axis=0)).astype(int)
        places = self._expected()
        log = self._likelihood(image, pose, true, places)
        log += np.log(np.maximum(self._belief[places], np.float32(1e-30)))
        self._belief[:] = 0.0
        self._belief[places] = np.exp(log - log.max())
        self._belief /= float(self._belief.sum())
        near = _correlate(self._belief[places], _DISC)
        row, column = np.unravel_index(int(near.argmax()), near.shape)
        sure = float(near[row, column])
        moved = np.array([column + places[1].start, row + places[0].start]) - true
        return Track(corners + moved, sure > SURE, 1.0 - sure, 1)

    def _expected(self) -> Part:
        """Spread the belief by the motion of the target; return where it is not negligible."""
        rows, columns = (
            np.flatnonzero(self._belief.max(axis=axis) > NEGLIGIBLE) for axis in (1, 0)
        )
        reach = int(REACH * self._spread_px) + 1
        part = (
            slice(max(int(rows[0]) - reach, 0), int(rows[-1]) + reach + 1),
            slice(max(int(columns[0]) - reach, 0), int(columns[-1]) + reach + 1),
        )
        self._belief[part] = cv2.GaussianBlur(
            self._belief[part], (0, 0), self._spread_px, borderType=cv2.BORDER_CONSTANT
        )
        return part

    def _likelihood(
        self, image: NDArray[np.uint8], pose: Pose, true: NDArray[np.int_], places: Part
    ) -> Plane:
        """Return the logarithm of the likelihood of the target's centre in some pixels."""
        water, target = self._camera.water, self._camera.target
        with_it, without = (self._clear.without_noise(pose, target=it) for it in (True, False))
        height_m = target.seabed_m - float(self._camera.position(pose)[2])
        bottom = _around(self._through_water(without, height_m), places)
        column, row = true.tolist()
        shown_at = slice(row, row + 1), slice(column, column + 1)
        shown = _around(self._through_water(with_it, height_m - target.height_m), shown_at)
        covered = _closed(_around((with_it != without).astype(np.float32), shown_at))
        shown = shown * covered
        seen = _around(image.astype(np.float32) - np.float32(255.0 * water.veil[1]), places)
        total = _correlate(seen, shown)
        total -= _correlate(seen * bottom - 0.5 * bottom * bottom, covered)
        total -= 0.5 * float(np.square(shown).sum())  # the whole target is in the image
        variance = water.read_sigma_grey**2 + water.shot_gain * float(image.mean()) + ROUNDING
        inner = total[HALF[1] : -HALF[1], HALF[0] : -HALF[0]]
        return np.asarray(inner / variance, dtype=np.float32)

    def _through_water(self, clear: NDArray[np.uint8], distance_m: float) -> Plane:
        """Return what is left of an image above the veil [grey], at a level surface's distance."""
        water = self._camera.water
        left = np.exp(-water.attenuation[1] * distance_m * self._slant)
        return np.asarray((clear - np.float32(255.0 * water.veil[1])) * left, dtype=np.float32)


def _around(plane: Plane, part: Part) -> Plane:
    """Return a part of an image and `HALF` more on each side, with zeros outside the image."""
    padded = np.pad(plane, ((HALF[1], HALF[1]), (HALF[0], HALF[0])))
    rows, columns = part
    return padded[rows.start : rows.stop + 2 * HALF[1], columns.start : columns.stop + 2 * HALF[0]]


def _closed(plane: Plane) -> Plane:
    """Fill what is missing where the target happens to be as bright as the bottom."""
    closed = cv2.morphologyEx(plane, cv2.MORPH_CLOSE, np.ones((5, 5)))
    return np.asarray(closed, dtype=np.float32)


def _correlate(plane: Plane, kernel: Plane) -> Plane:
    """Return the sum of products with the kernel around each pixel; zeros outside."""
    return np.asarray(cv2.filter2D(plane, cv2.CV_32F, kernel, borderType=cv2.BORDER_CONSTANT))


def _disc(radius_px: float) -> Plane:
    """Return a disc that weighs its middle a little more, so that a sure place is its own best."""
    reach = int(radius_px)
    rows, columns = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    squared = (rows**2 + columns**2) / radius_px**2
    return np.asarray(np.where(squared <= 1.0, 1.0 - 0.01 * squared, 0.0), dtype=np.float32)


_DISC = _disc(FAR_PX)
