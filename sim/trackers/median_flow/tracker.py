"""`median-flow`: the median motion and scale of those points that are followed best.

From each image to the next, a grid of points in the box is followed by optical flow, and from where
they ended back again. Half of the points are dropped because they do not come back to their start
(forward-backward error), and half because their surroundings look different (normalised
correlation). The box moves by the median of the others, and scales by the median change of their
distances (Kalal, Mikolajczyk and Matas, ICPR 2010). It does not rotate, and since it only knows the
last image, it drifts.
"""

import numpy as np
from numpy.typing import NDArray

from seamark.sim.trackers.interface import Corners, Track, Window
from seamark.sim.trackers.median_flow.flow import Pyramid, follow, pyramid, similarities
from seamark.sim.trackers.plausibility import PlausibilityGate

SMALLEST_PX = 6
GRID = 10  # S: points on each side
MOST_SPREAD_PX = 10.0  # S: a median distance from the median motion that is above it is a loss
LOWEST_SIMILARITY = 0.5  # E: median of the points', as for the other trackers
FEWEST_POINTS = 4  # E: of a hundred; fewer have no median to trust
Points = NDArray[np.float64]  # (n, 2) [px]


class MedianFlowTracker:
    """Moves and scales the target's corners with the points inside their box."""

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Take the first image (H, W) and the corners (4, 2) in it."""
        self._gate = PlausibilityGate(corners)
        self._shape = image.shape
        if (corners.max(axis=0) - corners.min(axis=0)).min() < SMALLEST_PX:
            raise ValueError("the target is too small")
        self._old: Pyramid = pyramid(image)

    def window(self) -> Window:
        """Return the whole image."""
        return 0, 0, self._shape[1], self._shape[0]

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Follow the points into the next image (H, W); after a loss, from the last good one."""
        new = pyramid(image)
        points = _grid(self._gate.last)
        ends, back = np.empty_like(points), np.empty_like(points)
        follow(self._old, new, points, ends)
        follow(new, self._old, ends, back)
        alike = similarities(self._old[0], new[0], points, ends)
        kept = _best(_lengths(back - points), alike)
        ok = int(kept.sum()) >= FEWEST_POINTS
        similarity = float(np.median(alike[kept])) if ok else 0.0
        if ok:
            moved, spread = _moved(self._gate.last, points[kept], ends[kept])
            ok = spread <= MOST_SPREAD_PX and similarity >= LOWEST_SIMILARITY
            ok = ok and self._gate.accept(moved)
        if ok:
            self._old = new
        return Track(self._gate.last.copy(), ok, 1.0 - similarity, 1)


def _grid(corners: Corners) -> Points:
    """Return points in the middles of the cells of a grid over the box around the corners."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    shares = (np.arange(GRID) + 0.5) / GRID
    x, y = (low[at] + (high[at] - low[at]) * shares for at in range(2))
    return np.ascontiguousarray(
        np.stack([np.tile(x, GRID), np.repeat(y, GRID)], axis=-1), dtype=np.float64
    )


def _lengths(vectors: Points) -> NDArray[np.float64]:
    x, y = vectors[:, 0], vectors[:, 1]
    lengths: NDArray[np.float64] = np.sqrt(x * x + y * y)
    return lengths


def _best(errors: NDArray[np.float64], alike: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which points come back best and look most alike, (n,)."""
    sound = np.isfinite(errors)
    if not sound.any():
        return sound
    middle, usual = np.median(errors[sound]), np.median(alike[sound])
    kept: NDArray[np.bool_] = sound & (errors <= middle) & (alike >= usual)
    return kept


def _moved(corners: Corners, points: Points, ends: Points) -> tuple[Corners, float]:
    """Return the corners after the median motion, and the median distance of the points from it."""
    motions = ends - points
    shift = np.median(motions, axis=0)
    first, second = np.triu_indices(len(points), 1)
    before = _lengths(points[first] - points[second])
    scale = float(np.median(_lengths(ends[first] - ends[second]) / before))
    centre = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    spread = float(np.median(_lengths(motions - shift)))
    return centre + shift + scale * (corners - centre), spread
