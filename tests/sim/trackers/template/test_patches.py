"""Patches are bilinear samples of the image, and those beyond a border take the value there."""

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.numerics.simd import WIDTH
from seamark.sim.trackers.template.patches import warp_patch

IMAGE = np.random.default_rng(5).integers(0, 4000, (40, 60)).astype(np.uint16)
ROWS = 21  # of the patch, rim included
BOUNDS = np.array([4.0, 3.0, 52.0, 36.0])


def warped(m: NDArray[np.float64], columns: int) -> NDArray[np.float32]:
    """Return the patch under a homography, computed by the tracker's loop."""
    width = -(-columns // WIDTH) * WIDTH + WIDTH
    numbers = np.zeros((3, width), np.float32)
    numbers[0] = np.arange(width)
    out = np.zeros((ROWS, width), np.float32)
    warp_patch(IMAGE, BOUNDS, m, 0.5, (numbers, columns), out)
    return out[:, :columns]


def sampled(m: NDArray[np.float64], columns: int) -> NDArray[np.float64]:
    """Return the same patch, one sample after the other."""
    out = np.empty((ROWS, columns))
    for r, c in np.ndindex(out.shape):
        u, v, w = m @ (c - 1.0, r - 1.0, 1.0)
        w = max(w, 1e-3)
        u = min(max(u / w, BOUNDS[0]), BOUNDS[2] - 1.001)
        v = min(max(v / w, BOUNDS[1]), BOUNDS[3] - 1.001)
        x, y = int(u), int(v)
        upper, lower = (
            IMAGE[row, x] + (u - x) * (float(IMAGE[row, x + 1]) - IMAGE[row, x])
            for row in (y, y + 1)
        )
        out[r, c] = 0.5 * (upper + (v - y) * (lower - upper))
    return out


@pytest.mark.parametrize("columns", [37, 33, 32])  # one column in the last vector; all of it
@pytest.mark.parametrize(
    "m",
    [
        [[0.9, 0.1, 10.0], [-0.1, 0.9, 8.0], [0.001, -0.001, 1.0]],  # all inside
        [[0.9, 0.1, 40.0], [-0.1, 0.9, 20.0], [0.001, -0.001, 1.0]],  # beyond two borders
        [[2.5, 0.3, -30.0], [0.2, 2.0, -15.0], [0.0, 0.0, 1.0]],  # beyond all of them
        [[0.02, 0.01, 20.3], [0.01, 0.02, 12.6], [0.0, 0.0, 1.0]],  # within one pixel
        [[0.0, 0.0, 90.0], [0.0, 0.5, 10.0], [0.0, 0.0, 1.0]],  # each row at one place
        [[1.0, 0.0, 5.0], [0.0, 1.0, 5.0], [-0.05, 0.0, 1.0]],  # across the horizon
    ],
)
def test_a_patch_is_what_single_samples_are(m: list[list[float]], columns: int) -> None:
    found, expected = warped(np.array(m), columns), sampled(np.array(m), columns)

    np.testing.assert_allclose(found, expected, rtol=0, atol=0.6)
