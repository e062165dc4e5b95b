"""What happens from one picture to the next: expect, align, judge, and ask for a window.

All of it is one compiled call a picture: at 20 pictures a second the way between Python and
compiled code would cost as much as the alignment.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.trackers.alignment import (
    Level,
    Search,
    align,
    cut,
    from_coarse,
    half_image,
    to_coarse,
)
from sim.trackers.interface import Window
from sim.trackers.patches import Matrix, correlation
from sim.trackers.warps import apply, inverse, is_convex, multiply, signed_area

LOWEST_CORRELATION = 0.5  # E: chance alignments on noise reach 0.3 to 0.4
LARGEST_AREA_RATIO = 4.0  # research: area outside [1/4, 4] of the start
LARGEST_JUMP = 1.0 / 3.0  # of the template's longer side, between two pictures
# The window need not reach farther than the target may be off its expected place. That is judged
# by the last picture: E, four times as far as the expectation was off then, and never below 8 px.
CLOSEST_SEARCH_PX = 8.0
SURPRISE_FACTOR = 4.0


class Memory(NamedTuple):
    """What the tracker knows between pictures; the arrays are changed in place."""

    home: Matrix  # (3, 3) template px -> image px where the target was last seen
    motion: Matrix  # (3, 3) of the last picture, in template coordinates
    quad: Matrix  # (4, 2) the target's corners in template px
    last: Matrix  # (4, 2) [px] corners where the target was last seen
    reach: NDArray[np.float64]  # (3,) [px] search margin now, at most, and beyond the template
    area: float  # [px^2] of the target in the first picture
    predict: bool  # whether the target is expected to move on as it did


@njit(cache=True, nogil=True, error_model="numpy")
def _expect(memory: Memory, out: Matrix) -> None:
    """Write the homography from which the next search starts."""
    if not memory.predict:
        out[:] = memory.home
        return
    multiply(memory.home, memory.motion, out)
    last = out[2, 2]
    for i in range(3):
        for j in range(3):
            out[i, j] /= last


@njit(cache=True, nogil=True, error_model="numpy")
def _window(memory: Memory, width: int, height: int) -> Window:
    """Return the box on even pixels around expected and last place, inside the picture.

    An expected place that is not a number, or far away, is ignored.
    """
    expected = np.empty((4, 2))
    h = np.empty((3, 3))
    _expect(memory, h)
    apply(h, memory.quad, expected)
    last = memory.last
    reach = np.ceil(memory.reach[0]) + memory.reach[2]
    limits = (width, height)
    found = np.empty(4, np.int64)
    for axis in range(2):
        low = last[0, axis]
        high = low
        for k in range(4):
            low = min(low, last[k, axis])
            high = max(high, last[k, axis])
            if abs(expected[k, axis]) < 1e5:
                low = min(low, expected[k, axis])
                high = max(high, expected[k, axis])
        limit = limits[axis]
        first = int(min(max(low - reach, 0.0), limit - 32.0)) // 2 * 2
        found[axis] = first
        found[axis + 2] = int(min(max(high + reach + 2.0, first + 32.0), float(limit))) // 2 * 2
    return found[0], found[1], found[2], found[3]


@njit(cache=True, nogil=True, error_model="numpy")
def next_window(memory: tuple[Any, ...], width: int, height: int) -> Window:
    """Return the box x0, y0, x1, y1 of the next picture that will be read."""
    return _window(Memory(*memory), width, height)


@njit(cache=True, nogil=True, error_model="numpy")
def _track(
    image: NDArray[np.uint8],
    window: Window,
    h: Matrix,
    coarse: Level,
    fine: Level,
    search: Search,
) -> tuple[int, bool, float]:
    """Improve h on both levels; return iterations, sanity and the final normalised correlation.

    The correlation is that of the coarse level, where the noise is a quarter as strong. Nothing
    outside the window is read.
    """
    x0, y0 = window[0], window[1]
    bounds = np.empty(4, np.float32)
    for k in range(4):
        bounds[k] = window[k]
    small, small_bounds = half_image(image, window)
    low = np.empty((3, 3))
    done = 0
    if search.coarse_iterations > 0:
        to_coarse(h, x0, y0, low)
        done, sane = align(
            small, small_bounds, low, coarse, search, search.coarse_basis, search.coarse_iterations
        )
        if not sane:
            return done, False, 0.0
        from_coarse(low, x0, y0, h)
    more, sane = align(image, bounds, h, fine, search, search.basis, search.fine_iterations)
    if not sane:
        return done + more, False, 0.0
    to_coarse(h, x0, y0, low)
    cut(small, small_bounds, low, coarse)
    similar = correlation(coarse.patch, coarse.template, coarse.frame[3], coarse.frame[4])
    return done + more, True, similar


@njit(cache=True, nogil=True, error_model="numpy")
def _largest(a: Matrix, b: Matrix) -> float:
    """Return the largest absolute difference; inf where one is not a number."""
    most = 0.0
    for k in range(a.shape[0]):
        for axis in range(2):
            off = abs(a[k, axis] - b[k, axis])
            if not off < 1e5:
                return np.inf
            most = max(most, off)
    return most


@njit(cache=True, nogil=True, error_model="numpy")
def _plausible(corners: Matrix, memory: Memory, longer_side: float) -> bool:
    """Return whether a quadrilateral can be the target one picture after the last good one."""
    if not is_convex(corners):
        return False
    ratio = signed_area(corners) / memory.area
    if not 1.0 / LARGEST_AREA_RATIO <= ratio <= LARGEST_AREA_RATIO:
        return False
    return _largest(corners, memory.last) <= LARGEST_JUMP * longer_side


@njit(cache=True, nogil=True, error_model="numpy")
def _remember(memory: Memory, h: Matrix, corners: Matrix, expected: Matrix) -> None:
    """Take a good place over, and how far it was off the expected one."""
    back = np.empty((3, 3))
    inverse(memory.home, back)
    multiply(back, h, memory.motion)
    memory.home[:] = h
    memory.last[:] = corners
    surprise = SURPRISE_FACTOR * _largest(corners, expected)
    memory.reach[0] = min(max(surprise, CLOSEST_SEARCH_PX), memory.reach[1])


@njit(cache=True, nogil=True, error_model="numpy")
def _forget_motion(memory: Memory) -> None:
    """Expect the target where it last was, and look for it as far as is allowed."""
    memory.motion[:] = 0.0
    for i in range(3):
        memory.motion[i, i] = 1.0
    memory.reach[0] = memory.reach[1]


@njit(cache=True, nogil=True, error_model="numpy")
def follow(
    image: NDArray[np.uint8], window: Window, memory: tuple[Any, ...], packed: tuple[Any, ...]
) -> tuple[bool, float, int, Window]:
    """Find the target in the next picture, of which the window alone is read.

    Returns whether it was found, the normalised correlation, the iterations, and the window of
    the picture after. `memory` and `packed` (coarse level, fine level, search) are plain tuples:
    Numba takes named ones from Python at five times the cost.
    """
    known = Memory(*memory)
    coarse = Level(*packed[0])
    fine = Level(*packed[1])
    h = np.empty((3, 3))
    expected = np.empty((4, 2))
    corners = np.empty((4, 2))
    _expect(known, h)
    apply(h, known.quad, expected)
    iterations, sane, similar = _track(image, window, h, coarse, fine, Search(*packed[2]))
    apply(h, known.quad, corners)
    found = (
        sane and similar >= LOWEST_CORRELATION and _plausible(corners, known, 2.0 * fine.frame[0])
    )
    if found:
        _remember(known, h, corners, expected)
    else:
        _forget_motion(known)
    ahead = _window(known, image.shape[1], image.shape[0])
    return found, similar, iterations, ahead
