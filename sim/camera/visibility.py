"""Which points of the world a camera on a link shows."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.hits import hit, ray
from seamark.sim.camera.instant import Instant
from seamark.sim.camera.sightings import NEAR_M, body_at
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.simd import f32x16, horizontal_sum


@njit(cache=True, nogil=True, error_model="numpy")
def nearest_hit(instant: Instant, x: float, y: float) -> float:
    """Return the depth [m] at which a ray (x, y, 1) meets the first body."""
    across, down = f32x16(x), f32x16(y)
    nearest = 1e6
    for k in range(instant.seen.number):
        body = body_at(instant.seen.numbers, k)
        hits = hit(instant.seen.kind[k], body, ray(body, across, down))
        # All lanes are the same, so that their sum is exact.
        nearest = min(nearest, horizontal_sum(hits[0]) / 16.0)
    return float(nearest)


@njit(cache=True, nogil=True, error_model="numpy")
def mark_shown(
    instant: Instant,
    points: Array,
    size: tuple[int, int],
    seabed_m: float,
    margin_m: float,
    shown: NDArray[np.bool_],
) -> None:
    """Write which points (n, 3) are in the image and not behind anything.

    What is less than the margin before a point, along the optical axis, does not hide it.
    """
    axes, centre = instant.sight.axes, instant.sight.centre
    f, u0, v0 = instant.lens
    for k in range(points.shape[0]):
        place = np.zeros(3)
        for i in range(3):
            for j in range(3):
                place[i] += axes[i, j] * (points[k, j] - centre[j])
        shown[k] = False
        if place[2] > NEAR_M and points[k, 2] < seabed_m + margin_m:
            x, y = place[0] / place[2], place[1] / place[2]
            u, v = f * x + u0, f * y + v0
            inside = -0.5 <= u < size[0] - 0.5 and -0.5 <= v < size[1] - 0.5
            shown[k] = inside and nearest_hit(instant, x, y) > place[2] - margin_m
