"""What happens from one picture to the next: expect, align, judge, and ask for a window.

All of it is one compiled call a picture, with few arrays (level_buffers.py): at 20 pictures a
second the way between Python and compiled code would cost as much as the alignment.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.trackers.interface import Window
from seamark.sim.trackers.template.alignment import align, cut, likeness
from seamark.sim.trackers.template.level_buffers import (
    COLUMNS,
    SCALE,
    Levels,
    Numbers,
    Search,
    Store,
    level_of,
    search_of,
)
from seamark.sim.trackers.template.patches import Matrix
from seamark.sim.trackers.template.pyramid import Sums, from_level, pyramid, to_level, whole_of
from seamark.sim.trackers.template.warps import apply, inverse, is_convex, multiply, signed_area

LOWEST_CORRELATION = 0.5  # E: chance alignments on noise reach 0.3 to 0.4
# E: the best of some hundred places is alike by chance more often than one place.
LOWEST_CORRELATION_AFAR = 0.7
LARGEST_AREA_RATIO = 4.0  # research: area outside [1/4, 4] of the start
LARGEST_JUMP = 1.0 / 3.0  # of the template's longer side, between two pictures
# The window need not reach farther than the target may be off its expected place. That is judged
# by the last picture: E, four times as far as the expectation was off then, and never below 8 px.
CLOSEST_SEARCH_PX = 8.0
SURPRISE_FACTOR = 4.0
GROWTH = 1.5  # E: of the searched reach, from one picture without the target to the next

NOW, MOST, BEYOND, AFAR = range(4)


class Memory(NamedTuple):
    """What the tracker knows between pictures; the arrays are changed in place."""

    home: Matrix  # (3, 3) template px -> image px where the target was last seen
    motion: Matrix  # (3, 3) of the last picture, in template coordinates
    quad: Matrix  # (4, 2) the target's corners in template px
    last: Matrix  # (4, 2) [px] corners where the target was last seen
    reach: Numbers  # (4,) [px] search margin now, at most, beyond the template, afar
    lost: Numbers  # (1,) pictures since the target was last seen
    area: float  # [px^2] of the target in the first picture
    predict: bool  # whether the target is expected to move on as it did


@njit(cache=True, nogil=True, error_model="numpy")
def memory_of(numbers: Numbers) -> Memory:
    """Return the memory that these numbers are."""
    return Memory(
        numbers[:9].reshape(3, 3),
        numbers[9:18].reshape(3, 3),
        numbers[18:26].reshape(4, 2),
        numbers[26:34].reshape(4, 2),
        numbers[34:38],
        numbers[38:39],
        numbers[39],
        numbers[40] != 0.0,
    )


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
    reach = np.ceil(memory.reach[NOW]) + memory.reach[BEYOND]
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
def next_window(memory: Numbers, width: int, height: int) -> Window:
    """Return the box x0, y0, x1, y1 of the next picture that will be read."""
    return _window(memory_of(memory), width, height)


@njit(cache=True, nogil=True, error_model="numpy")
def _at(
    image: NDArray[np.uint8],
    small: tuple[Sums, Sums, Sums],
    window: Window,
    h: Matrix,
    levels: Levels,
    k: int,
) -> float:
    """Return the normalised correlation of level k with the image under h (of level 0)."""
    low = np.empty((3, 3))
    to_level(h, k, window, low)
    if k == 0:
        return likeness(image, _bounds(window), low, level_of(levels, 0))
    return likeness(small[k - 1], whole_of(small[k - 1]), low, level_of(levels, k))


@njit(cache=True, nogil=True, error_model="numpy")
def _bounds(window: Window) -> NDArray[np.float64]:
    bounds = np.empty(4)
    for k in range(4):
        bounds[k] = window[k]
    return bounds


@njit(cache=True, nogil=True, error_model="numpy")
def _track(
    image: NDArray[np.uint8],
    small: tuple[Sums, Sums, Sums],
    window: Window,
    h: Matrix,
    levels: Levels,
    search: Search,
) -> tuple[int, bool, float]:
    """Improve h on all levels; return iterations, sanity and the final normalised correlation.

    The correlation is that of level 1, where the noise is a quarter as strong. Nothing outside the
    window is read.
    """
    low = np.empty((3, 3))
    done = 0
    for k in range(search.levels - 1, 0, -1):
        to_level(h, k, window, low)
        level = level_of(levels, k)
        more, sane = align(small[k - 1], whole_of(small[k - 1]), low, level, search, True)
        done += more
        if not sane:
            return done, False, 0.0
        from_level(low, k, window, h)
    more, sane = align(image, _bounds(window), h, level_of(levels, 0), search, False)
    if not sane:
        return done + more, False, 0.0
    return done + more, True, _at(image, small, window, h, levels, min(1, search.levels - 1))


@njit(cache=True, nogil=True, error_model="numpy")
def _look_around(
    image: NDArray[np.uint8],
    small: tuple[Sums, Sums, Sums],
    window: Window,
    h: Matrix,
    levels: Levels,
    search: Search,
    radius: float,
) -> None:
    """Move h to where the target's last appearance fits best, on a grid of places around.

    The grid is a quarter of the template's shorter side wide: from its nearest point the alignment
    finds the way.
    """
    k = min(1, search.levels - 1)
    pitch = np.sqrt(h[0, 0] * h[0, 0] + h[1, 0] * h[1, 0])  # image px per template px
    finest = level_of(levels, 0)
    shorter = min(finest.ys.shape[0], finest.frame[COLUMNS]) * pitch
    step = min(max(0.25 * shorter, 2.0), 12.0)
    count = int(radius / step)
    best = -2.0
    start = h.copy()
    there = np.empty((3, 3))
    for row in range(-count, count + 1):
        for column in range(-count, count + 1):
            for j in range(3):
                there[0, j] = start[0, j] + column * step * start[2, j]
                there[1, j] = start[1, j] + row * step * start[2, j]
                there[2, j] = start[2, j]
            alike = _at(image, small, window, there, levels, k)
            if alike > best:
                best = alike
                h[:] = there


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
def _plausible(corners: Matrix, memory: Memory, jump: float) -> bool:
    """Return whether a quadrilateral can be the target, at most `jump` px off the last good one."""
    if not is_convex(corners):
        return False
    ratio = signed_area(corners) / memory.area
    if not 1.0 / LARGEST_AREA_RATIO <= ratio <= LARGEST_AREA_RATIO:
        return False
    return _largest(corners, memory.last) <= jump


@njit(cache=True, nogil=True, error_model="numpy")
def _remember(memory: Memory, h: Matrix, corners: Matrix, expected: Matrix) -> None:
    """Take a good place over, and how far it was off the expected one."""
    if memory.lost[0] > 0:
        _stand_still(memory)
    else:
        back = np.empty((3, 3))
        inverse(memory.home, back)
        multiply(back, h, memory.motion)
    memory.home[:] = h
    memory.last[:] = corners
    memory.lost[0] = 0
    surprise = SURPRISE_FACTOR * _largest(corners, expected)
    memory.reach[NOW] = min(max(surprise, CLOSEST_SEARCH_PX), memory.reach[MOST])


@njit(cache=True, nogil=True, error_model="numpy")
def _stand_still(memory: Memory) -> None:
    memory.motion[:] = 0.0
    for i in range(3):
        memory.motion[i, i] = 1.0


@njit(cache=True, nogil=True, error_model="numpy")
def _forget_motion(memory: Memory) -> None:
    """Expect the target where it last was, and look for it as far as is allowed."""
    _stand_still(memory)
    reach = memory.reach
    grown = max(GROWTH * reach[NOW], reach[MOST]) if memory.lost[0] > 0 else reach[MOST]
    reach[NOW] = min(grown, max(reach[AFAR], reach[MOST]))
    memory.lost[0] += 1


@njit(cache=True, nogil=True, error_model="numpy")
def follow(  # fewer would be packed and unpacked
    image: NDArray[np.uint8],
    window: Window,
    memory: Numbers,
    search_numbers: Numbers,
    facts: Matrix,
    store: Store,
) -> tuple[bool, float, int, Window]:
    """Find the target in the next picture, of which the window alone is read.

    Returns whether it was found, the normalised correlation, the iterations, and the window of
    the picture after.
    """
    known, search = memory_of(memory), search_of(search_numbers)
    levels = (facts, store)
    h = np.empty((3, 3))
    expected = np.empty((4, 2))
    corners = np.empty((4, 2))
    small = pyramid(image, window, search.levels)
    _expect(known, h)
    apply(h, known.quad, expected)
    jump = LARGEST_JUMP * 2.0 * facts[0, SCALE]
    lowest = LOWEST_CORRELATION
    if known.lost[0] > 0 and known.reach[AFAR] > 0.0:
        lowest = LOWEST_CORRELATION_AFAR
        jump += known.reach[NOW]
        _look_around(image, small, window, h, levels, search, known.reach[NOW])
    iterations, sane, similar = _track(image, small, window, h, levels, search)
    apply(h, known.quad, corners)
    found = sane and similar >= lowest and _plausible(corners, known, jump)
    if found:
        _remember(known, h, corners, expected)
    else:
        _forget_motion(known)
    ahead = _window(known, image.shape[1], image.shape[0])
    return found, similar, iterations, ahead


@njit(cache=True, nogil=True, error_model="numpy")
def cut_start(
    image: NDArray[np.uint8], window: Window, h: Matrix, levels: Levels, count: int
) -> None:
    """Fill all levels' patches from the picture in which the target is known."""
    small = pyramid(image, window, count)
    cut(image, _bounds(window), h, level_of(levels, 0))
    low = np.empty((3, 3))
    for k in range(1, count):
        to_level(h, k, window, low)
        cut(small[k - 1], whole_of(small[k - 1]), low, level_of(levels, k))
