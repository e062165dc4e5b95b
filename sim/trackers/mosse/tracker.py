"""`mosse`: a correlation filter that is learnt from each image, for an upright box.

The filter H makes the response to the target's image F a narrow peak G at its centre, with the
least sum of squared errors over all images so far, of which the last ones count most (Bolme,
Beveridge, Draper and Lui, CVPR 2010):

    H* = A / B,   A = η G F* + (1 - η) A,   B = η F F* + (1 - η) B

The target is where the response to the next image has its peak. How far that stands out from the
rest, the peak-to-sidelobe ratio, tells a loss. The box neither scales nor rotates.
"""

import numpy as np
from numpy.typing import NDArray

from seamark.sim.numerics.fourier import roots
from seamark.sim.numerics.libm import PI, cos, exp, sincos
from seamark.sim.trackers.interface import Corners, Track, Window
from seamark.sim.trackers.mosse.filter import SMALLEST_RATIO, Filter, learn, respond, sample
from seamark.sim.trackers.plausibility import PlausibilityGate
from seamark.sim.trackers.subpixel import peak_offset

SMALLEST_PX = 6
WIDEST_PX = 256  # E: bounds time and memory; larger targets are followed by their middle
SURROUNDINGS = 1.5  # E: of the box, at least, that the filter sees: room for a jump
PEAK_SIGMA_PX = 2.0  # S: of G
# S: eight small affine changes of the first image; E: which: turns [rad] and scales.
CHANGES = (
    *((0.0, 1.0), (0.06, 1.0), (-0.06, 1.0), (0.0, 1.05), (0.0, 0.95)),
    *((0.1, 1.02), (-0.1, 0.98), (0.03, 0.97)),
)


class MosseTracker:
    """Moves the target's corners with the peak of the filter's response."""

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Learn the filter from a whole image (H, W), and from it turned and scaled a little."""
        self._gate = PlausibilityGate(corners)
        self._shape = image.shape
        low, high = corners.min(axis=0), corners.max(axis=0)
        if (high - low).min() < SMALLEST_PX:
            raise ValueError("the target is too small")
        width, height = (_size(float(extent)) for extent in high - low)
        self._centre = 0.5 * (low + high)
        self._offsets = self._gate.last - self._centre
        self._filter = _filter(height, width)
        for number, (turn, scale) in enumerate(CHANGES):
            sine, cosine = sincos(turn)
            x, y = self._centre.tolist()
            sample(image, (x, y), (scale * cosine, scale * sine), self._filter)
            learn(self._filter, 1.0 / (number + 1.0))  # the mean of all

    def window(self) -> Window:
        """Return what the filter may see, before and after it has moved, inside the image."""
        height, width = self._filter.patch.shape
        x, y = self._centre.tolist()
        return (
            min(max(int(x) - width, 0), self._shape[1]),
            min(max(int(y) - height, 0), self._shape[0]),
            max(min(int(x) + width + 2, self._shape[1]), 0),
            max(min(int(y) + height + 2, self._shape[0]), 0),
        )

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Move to the peak of the response in the next image (H, W), and learn from it."""
        x, y = self._centre.tolist()
        sample(image, (x, y), (1.0, 0.0), self._filter)
        row, column, ratio = respond(self._filter)
        height, width = self._filter.patch.shape
        response = self._filter.patch
        x += peak_offset(response[row], column) + column - width // 2
        y += peak_offset(response[:, column], row) + row - height // 2
        moved = np.array([x, y])
        ok = ratio >= SMALLEST_RATIO and self._gate.accept(moved + self._offsets)
        if ok:
            self._centre = moved
            sample(image, (x, y), (1.0, 0.0), self._filter)
            learn(self._filter)
        return Track(self._gate.last.copy(), ok, 1.0 / (1.0 + max(ratio, 0.0)), 1)


def _size(extent: float) -> int:
    """Return the power of two that the filter has for an extent of the box [px]."""
    size = 1
    while size < min(SURROUNDINGS * extent, WIDEST_PX):
        size *= 2
    return size


def _filter(height: int, width: int) -> Filter:
    rows, columns = np.arange(height) - height // 2, np.arange(width) - width // 2
    peak = np.array([[_gaussian(int(x * x + y * y)) for x in columns] for y in rows])
    empty = np.zeros((height, width), np.complex128)
    made = Filter(
        row_roots=roots(width),
        column_roots=roots(height),
        taper=np.outer(_taper(height), _taper(width)),
        patch=np.zeros((height, width)),
        image=empty.copy(),
        goal=peak.astype(np.complex128),
        numerator=empty.copy(),
        energy=np.zeros((height, width)),
    )
    made.transform_goal()
    return made


def _gaussian(squared_px: int) -> float:
    return exp(-0.5 * squared_px / PEAK_SIGMA_PX**2)


def _taper(size: int) -> NDArray[np.float64]:
    """Return a cosine window, (size,): the transform takes the image for periodic."""
    return np.array([0.5 - 0.5 * cos(2.0 * PI * (k + 0.5) / size) for k in range(size)])
