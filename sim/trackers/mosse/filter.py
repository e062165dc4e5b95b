"""The filter of `mosse`, compiled: sampling an image, learning from it, and the response to it."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.fourier import Complex, inverse_real, transform
from seamark.sim.numerics.libm import log
from seamark.sim.trackers.bilinear import grey_between

RATE = 0.125  # S: η
SMALLEST_RATIO = 7.0  # S: peak to sidelobe; about there the target is covered or lost
BESIDE_PX = 5  # S: the peak itself is 11 x 11 pixels of the response
REGULARISATION = 1e-3  # E: share of the mean energy, for frequencies that the target does not have


class Filter(NamedTuple):
    """A filter of (H, W), both powers of two, and what it is computed with."""

    row_roots: Complex  # of W
    column_roots: Complex  # of H
    taper: Array  # (H, W)
    patch: Array  # (H, W) the image as sampled last, or the response
    image: Complex  # (H, W) F, its transform
    goal: Complex  # (H, W) G
    numerator: Complex  # (H, W) A
    energy: Array  # (H, W) B

    def transform_goal(self) -> None:
        """Transform G, which was given as an image."""
        transform(self.goal, self.row_roots, self.column_roots)


@njit(cache=True, error_model="numpy")
def sample(
    image: NDArray[np.uint8],
    centre: tuple[float, float],
    axis: tuple[float, float],
    into: Filter,
) -> None:
    """Sample the image (H, W) around a place and transform it.

    Its logarithm has zero mean and unit variance, and fades out at the rim.

    Parameters
    ----------
    centre : (2,) [px]
        x, y; what lies outside the image is as its nearest pixel.
    axis : (2,) [px]
        Where in the image the next sample to the right is: turned and scaled.
    """
    patch = into.patch
    rows, columns = patch.shape
    for row in range(rows):
        for column in range(columns):
            right, down = float(column - columns // 2), float(row - rows // 2)
            x = centre[0] + axis[0] * right - axis[1] * down
            y = centre[1] + axis[1] * right + axis[0] * down
            patch[row, column] = log(1.0 + grey_between(image, x, y))
    mean, deviation = _moments(patch)
    for row in range(rows):
        for column in range(columns):
            value = (patch[row, column] - mean) / max(deviation, 1e-6)
            into.image[row, column] = value * into.taper[row, column]
    transform(into.image, into.row_roots, into.column_roots)


@njit(cache=True, error_model="numpy")
def _moments(values: Array) -> tuple[float, float]:
    """Return mean and standard deviation."""
    total = squares = 0.0
    for value in values.flat:
        total += value
        squares += value * value
    mean = total / values.size
    return mean, math.sqrt(max(squares / values.size - mean * mean, 0.0))


@njit(cache=True, error_model="numpy")
def learn(into: Filter, rate: float = RATE) -> None:
    """Learn from what was sampled last, with a share of `rate` in all that is known."""
    for row in range(into.image.shape[0]):
        for column in range(into.image.shape[1]):
            seen = into.image[row, column]
            made = into.goal[row, column] * seen.conjugate()
            into.numerator[row, column] += rate * (made - into.numerator[row, column])
            power = seen.real * seen.real + seen.imag * seen.imag
            into.energy[row, column] += rate * (power - into.energy[row, column])


@njit(cache=True, error_model="numpy")
def respond(to: Filter) -> tuple[int, int, float]:
    """Return where the response to what was sampled last has its peak, and how far it stands out.

    Row, column, and the peak-to-sidelobe ratio. The response takes the place of the patch.
    """
    response = to.patch
    rows, columns = response.shape
    least = 0.0
    for value in to.energy.flat:
        least += value
    least = REGULARISATION * least / to.energy.size + 1e-12
    for row in range(rows):
        for column in range(columns):
            gain = to.numerator[row, column] / (to.energy[row, column] + least)
            to.image[row, column] *= gain
    inverse_real(to.image, to.row_roots, to.column_roots, response)
    row, column = 0, 0
    for i in range(rows):
        for j in range(columns):
            if response[i, j] > response[row, column]:
                row, column = i, j
    return row, column, _ratio(response, row, column)


@njit(cache=True, error_model="numpy")
def _ratio(response: Array, row: int, column: int) -> float:
    """Return by how many standard deviations of the rest the peak is above its mean."""
    total = squares = 0.0
    count = 0
    for i in range(response.shape[0]):
        for j in range(response.shape[1]):
            if abs(i - row) > BESIDE_PX or abs(j - column) > BESIDE_PX:
                value = response[i, j]
                total += value
                squares += value * value
                count += 1
    mean = total / max(count, 1)
    deviation = math.sqrt(max(squares / max(count, 1) - mean * mean, 0.0))
    ratio: float = (response[row, column] - mean) / max(deviation, 1e-9)
    return ratio
