"""Finds a pipe in a grey image by its two edges: a Hough transform of its middle, then a line fit.

Each pixel with a strong gradient votes for the middle line of a pipe whose edge it may be on: half
a width away along its gradient, for a bright or for a dark pipe (Duda and Hart 1972, with the
direction of the gradient as Ballard 1981). A pipe has two edges with opposite gradients, as the
vision systems for cables and pipes on the seabed use (Matsumoto and Ito 1995; Ortiz, Simó and
Oliver 2002): a line counts only as much as its weaker edge. What voted for the best line is fitted
by total least squares.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.compilation import SameTypes
from seamark.sim.numerics.libm import PI, atan2, sincos

BLOCK = 4  # [px] side of the squares that are averaged first, against noise and pebbles
HALF = 36  # directions of a line, over half a turn
_SPREAD = 2  # E: directions to either side for which a pixel votes as well
_STRONG = 2.0  # E: gradients above so many times their mean vote
LEAST_VOTES = 18.0  # E: of the weaker edge [blocks] for a line to be a pipe
WIDTHS = (0.7, 1.0, 1.3)  # E: relative to the one expected: height, and sand at its foot
_NEAR = 2.0  # [blocks] E: from the best line, of what is fitted


class PipeSeen(NamedTuple):
    """A pipe in an image."""

    found: bool
    u: float  # [px] point of its middle line that is nearest to the middle of the image
    v: float
    direction: tuple[float, float]  # of the line, a unit vector, either way round
    width: float  # [px]
    votes: float  # of its weaker edge


class PipeEdges:
    """Looks for a pipe of about one width in images of one size."""

    def __init__(self, width_px: float) -> None:
        """Set the width of the pipe in the image at the height that is meant to be kept."""
        self._widths = np.array([share * width_px / BLOCK for share in WIDTHS])
        angles = [sincos(PI * k / HALF) for k in range(HALF)]
        self._normals = np.array([(cosine, sine) for sine, cosine in angles])
        self._find = SameTypes(find)

    def find(self, image: NDArray[np.uint8]) -> PipeSeen:
        """Return the most likely pipe in an image (H, W)."""
        seen: PipeSeen = self._find.call(image, self._widths, self._normals)
        return seen


@njit(cache=True, nogil=True, error_model="numpy")
def find(image: NDArray[np.uint8], widths: Array, normals: Array) -> PipeSeen:
    """Return the most likely pipe; `widths` in blocks, `normals` (HALF, 2) of the directions."""
    edges, count = _edges(_averaged(image))
    votes = _vote(edges[:count], widths, normals)
    best, at = _best(votes)
    bright, k, direction, middle = at
    none = PipeSeen(False, 0.0, 0.0, (0.0, 0.0), 0.0, best)
    if best < LEAST_VOTES:
        return none
    half = 0.5 * widths[k] * (1.0 if bright else -1.0)
    normal = normals[direction]
    offset = float(middle - votes.shape[4] // 2)
    sums = _sums(edges[:count], normal, offset, half, direction)
    if min(sums[0, 0], sums[1, 0]) < 3.0:
        return none
    x, y, dx, dy = _fit(sums)
    off = y * dx - x * dy  # of the middle of the image from the line
    scale = float(BLOCK)
    u, v = (
        0.5 * (image.shape[1] - 1) - scale * off * dy,
        0.5 * (image.shape[0] - 1) + scale * off * dx,
    )
    return PipeSeen(True, u, v, (dx, dy), scale * widths[k], best)


@njit(cache=True, nogil=True, error_model="numpy")
def _averaged(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return the means of squares of BLOCK px."""
    height, width = image.shape[0] // BLOCK, image.shape[1] // BLOCK
    out = np.empty((height, width), np.float32)
    for j in range(height):
        for i in range(width):
            total = 0
            for y in range(BLOCK):
                for x in range(BLOCK):
                    total += int(image[BLOCK * j + y, BLOCK * i + x])
            out[j, i] = total / (BLOCK * BLOCK)
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _edges(small: NDArray[np.float32]) -> tuple[Array, int]:
    """Return place from the middle (x, y) and direction (0 to 2 HALF) of strong gradients."""
    height, width = small.shape
    gradients, total = np.zeros((height, width, 2), np.float32), 0.0
    for j in range(1, height - 1):
        for i in range(1, width - 1):
            right = small[j - 1, i + 1] + 2.0 * small[j, i + 1] + small[j + 1, i + 1]
            left = small[j - 1, i - 1] + 2.0 * small[j, i - 1] + small[j + 1, i - 1]
            below = small[j + 1, i - 1] + 2.0 * small[j + 1, i] + small[j + 1, i + 1]
            above = small[j - 1, i - 1] + 2.0 * small[j - 1, i] + small[j - 1, i + 1]
            x, y = right - left, below - above
            gradients[j, i, 0], gradients[j, i, 1] = x, y
            total += math.sqrt(x * x + y * y)
    least = (_STRONG * total / ((height - 2) * (width - 2))) ** 2
    edges, count = np.empty((height * width, 3)), 0
    for j in range(1, height - 1):
        for i in range(1, width - 1):
            x, y = float(gradients[j, i, 0]), float(gradients[j, i, 1])
            if x * x + y * y > least:
                edges[count, 0], edges[count, 1] = i - 0.5 * (width - 1), j - 0.5 * (height - 1)
                edges[count, 2] = HALF / PI * atan2(y, x) % (2.0 * HALF)
                count += 1
    return edges, count


@njit(cache=True, nogil=True, error_model="numpy")
def _vote(edges: Array, widths: Array, normals: Array) -> NDArray[np.float32]:
    """Return the votes, (2, widths, HALF, 2, places).

    By whether the pipe is bright, its width, the direction of its normal, on which side of it the
    voting edge is, and its distance from the middle of the image.
    """
    reach = 2
    for n in range(edges.shape[0]):
        reach = max(reach, int(abs(edges[n, 0]) + abs(edges[n, 1])) + 2)
    reach += int(widths.max())
    votes = np.zeros((2, widths.size, HALF, 2, 2 * reach + 1), np.float32)
    for n in range(edges.shape[0]):
        x, y = edges[n, 0], edges[n, 1]
        near = int(edges[n, 2] + 0.5)
        for at in range(near - _SPREAD, near + _SPREAD + 1):
            turned = at % (2 * HALF)
            side, direction = turned // HALF, turned % HALF
            place = x * normals[direction, 0] + y * normals[direction, 1] + reach
            brighter = 1.0 if side == 0 else -1.0  # on which side of the edge it is
            for k in range(widths.size):
                half = 0.5 * widths[k] * brighter
                for bright in range(2):
                    middle = place + (half if bright == 1 else -half)
                    first = int(middle)
                    share = np.float32(middle - first)
                    votes[bright, k, direction, side, first] += np.float32(1.0) - share
                    votes[bright, k, direction, side, first + 1] += share
    return votes


@njit(cache=True, nogil=True, error_model="numpy")
def _best(votes: NDArray[np.float32]) -> tuple[float, tuple[int, int, int, int]]:
    """Return the most votes that both edges of a line have, and where."""
    most, at = 0.0, (0, 0, 0, 0)
    for bright in range(2):
        for k in range(votes.shape[1]):
            for direction in range(HALF):
                sides = votes[bright, k, direction]
                for p in range(1, sides.shape[1] - 1):
                    one = sides[0, p - 1] + sides[0, p] + sides[0, p + 1]
                    other = sides[1, p - 1] + sides[1, p] + sides[1, p + 1]
                    if min(one, other) > most:
                        most, at = float(min(one, other)), (bright, k, direction, p)
    return most, at


@njit(cache=True, nogil=True, error_model="numpy")
def _sums(edges: Array, normal: Array, offset: float, half: float, direction: int) -> Array:
    """Return sums over the edges of a line, (2, 6): number, x, y, xx, xy, yy by side.

    Of where each has the middle of the pipe.
    """
    sums = np.zeros((2, 6))
    for n in range(edges.shape[0]):
        turn = (edges[n, 2] - direction) % (2.0 * HALF)
        side = 0 if turn < 0.5 * HALF or turn > 1.5 * HALF else 1
        if abs(turn - (HALF if side else (2.0 * HALF if turn > HALF else 0.0))) > _SPREAD + 1.0:
            continue
        to_middle = half if side == 0 else -half
        x, y = edges[n, 0] + to_middle * normal[0], edges[n, 1] + to_middle * normal[1]
        if abs(x * normal[0] + y * normal[1] - offset) <= _NEAR:
            sums[side, 0] += 1.0
            sums[side, 1] += x
            sums[side, 2] += y
            sums[side, 3] += x * x
            sums[side, 4] += x * y
            sums[side, 5] += y * y
    return sums


@njit(cache=True, nogil=True, error_model="numpy")
def _fit(sums: Array) -> tuple[float, float, float, float]:
    """Return a point and the direction of the line through two edges that count alike."""
    x = y = xx = xy = yy = 0.0
    for side in range(2):
        count = sums[side, 0]
        mean_x, mean_y = sums[side, 1] / count, sums[side, 2] / count
        x, y = x + 0.5 * mean_x, y + 0.5 * mean_y
        xx += sums[side, 3] / count - mean_x * mean_x
        xy += sums[side, 4] / count - mean_x * mean_y
        yy += sums[side, 5] / count - mean_y * mean_y
    sine, cosine = sincos(0.5 * atan2(2.0 * xy, xx - yy))
    return x, y, cosine, sine
