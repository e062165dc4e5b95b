"""One frame of template tracking: predict, align, check plausibility, choose the next window.

All of it is one compiled call with few arrays (level_buffers.py): several calls per image would
take as long as the alignment itself.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.trackers.interface import Window
from seamark.sim.trackers.template.alignment import align, extract_patch, zncc
from seamark.sim.trackers.template.level_buffers import (
    COLUMNS,
    SCALE,
    Numbers,
    PlaneStore,
    PyramidLevels,
    SearchSettings,
    pyramid_level,
    unpack_search,
)
from seamark.sim.trackers.template.patches import Matrix
from seamark.sim.trackers.template.pyramid import (
    SummedImage,
    from_pyramid_level,
    full_bounds,
    pyramid,
    to_pyramid_level,
)
from seamark.sim.trackers.template.warps import apply, inverse, is_convex, multiply, signed_area

LOWEST_CORRELATION = 0.5  # E: chance alignments on noise reach 0.3 to 0.4
# E: the best of some hundred positions is more often similar by chance than a single one.
LOWEST_CORRELATION_REACQUIRE = 0.7
MAX_AREA_RATIO = 4.0  # E: of the area at the start, both ways
MAX_JUMP = 1.0 / 3.0  # of the template's longer side, from one image to the next
# The search margin follows the last prediction error: E, four times the error, at least 8 px.
MIN_SEARCH_PX = 8.0
PREDICTION_ERROR_FACTOR = 4.0
REACH_GROWTH = 1.5  # E: of the search margin, for each image without the target

SEARCH, SEARCH_LIMIT, MARGIN, REACQUIRE = range(4)


class TrackerState(NamedTuple):
    """The tracker's state between images; the arrays are updated in place."""

    homography: Matrix  # (3, 3) template px -> image px where the target was last seen
    motion: Matrix  # (3, 3) of the last image, in template coordinates
    template_corners: Matrix  # (4, 2) the target's corners in template px
    last: Matrix  # (4, 2) [px] corners where the target was last seen
    reach: Numbers  # (4,) [px] search margin, its limit, margin of the template, limit after a loss
    lost: Numbers  # (1,) images since the target was last seen
    area: float  # [px^2] of the target in the first image
    predict: bool  # whether constant velocity is predicted


@njit(cache=True, nogil=True, error_model="numpy")
def unpack_state(numbers: Numbers) -> TrackerState:
    """Return the state as views of an array of numbers."""
    return TrackerState(
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
def _predict_homography(state: TrackerState, out: Matrix) -> None:
    """Write the homography from which the next search starts."""
    if not state.predict:
        out[:] = state.homography
        return
    multiply(state.homography, state.motion, out)
    last = out[2, 2]
    for i in range(3):
        for j in range(3):
            out[i, j] /= last


@njit(cache=True, nogil=True, error_model="numpy")
def _window(state: TrackerState, width: int, height: int) -> Window:
    """Return the box on even pixels around the predicted and the last corners, inside the image.

    A predicted corner that is not finite, or far away, is ignored.
    """
    expected = np.empty((4, 2))
    h = np.empty((3, 3))
    _predict_homography(state, h)
    apply(h, state.template_corners, expected)
    last = state.last
    reach = np.ceil(state.reach[SEARCH]) + state.reach[MARGIN]
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
def next_window(state: Numbers, width: int, height: int) -> Window:
    """Return the box x0, y0, x1, y1 of the next image that will be read."""
    return _window(unpack_state(state), width, height)


@njit(cache=True, nogil=True, error_model="numpy")
def _similarity_at(
    image: NDArray[np.uint8],
    small: tuple[SummedImage, SummedImage, SummedImage],
    window: Window,
    h: Matrix,
    levels: PyramidLevels,
    k: int,
) -> float:
    """Return the ZNCC of level k with the image under h (of level 0)."""
    low = np.empty((3, 3))
    to_pyramid_level(h, k, window, low)
    if k == 0:
        return zncc(image, _bounds(window), low, pyramid_level(levels, 0))
    return zncc(small[k - 1], full_bounds(small[k - 1]), low, pyramid_level(levels, k))


@njit(cache=True, nogil=True, error_model="numpy")
def _bounds(window: Window) -> NDArray[np.float64]:
    bounds = np.empty(4)
    for k in range(4):
        bounds[k] = window[k]
    return bounds


@njit(cache=True, nogil=True, error_model="numpy")
def _align_pyramid(
    image: NDArray[np.uint8],
    small: tuple[SummedImage, SummedImage, SummedImage],
    window: Window,
    h: Matrix,
    levels: PyramidLevels,
    search: SearchSettings,
) -> tuple[int, bool, float]:
    """Improve h on all levels; return iterations, validity and the final ZNCC.

    The ZNCC is that of level 1, where the noise is a quarter as strong. Nothing outside the window
    is read.
    """
    low = np.empty((3, 3))
    done = 0
    for k in range(search.levels - 1, 0, -1):
        to_pyramid_level(h, k, window, low)
        level = pyramid_level(levels, k)
        more, sane = align(small[k - 1], full_bounds(small[k - 1]), low, level, search, True)
        done += more
        if not sane:
            return done, False, 0.0
        from_pyramid_level(low, k, window, h)
    more, sane = align(image, _bounds(window), h, pyramid_level(levels, 0), search, False)
    if not sane:
        return done + more, False, 0.0
    return (
        done + more,
        True,
        _similarity_at(image, small, window, h, levels, min(1, search.levels - 1)),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _grid_search(
    image: NDArray[np.uint8],
    small: tuple[SummedImage, SummedImage, SummedImage],
    window: Window,
    h: Matrix,
    levels: PyramidLevels,
    search: SearchSettings,
    radius: float,
) -> None:
    """Move h to the position with the best ZNCC on a grid around the last one.

    The spacing is a quarter of the template's shorter side, so the alignment converges from the
    nearest point.
    """
    k = min(1, search.levels - 1)
    pitch = np.sqrt(h[0, 0] * h[0, 0] + h[1, 0] * h[1, 0])  # image px per template px
    finest = pyramid_level(levels, 0)
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
            similarity = _similarity_at(image, small, window, there, levels, k)
            if similarity > best:
                best = similarity
                h[:] = there


@njit(cache=True, nogil=True, error_model="numpy")
def _largest_difference(a: Matrix, b: Matrix) -> float:
    """Return the largest absolute difference; inf if one is not finite."""
    most = 0.0
    for k in range(a.shape[0]):
        for axis in range(2):
            off = abs(a[k, axis] - b[k, axis])
            if not off < 1e5:
                return np.inf
            most = max(most, off)
    return most


@njit(cache=True, nogil=True, error_model="numpy")
def _plausible(corners: Matrix, state: TrackerState, jump: float) -> bool:
    """Return whether corners are plausible: convex, of similar area, at most `jump` px away."""
    if not is_convex(corners):
        return False
    ratio = signed_area(corners) / state.area
    if not 1.0 / MAX_AREA_RATIO <= ratio <= MAX_AREA_RATIO:
        return False
    return _largest_difference(corners, state.last) <= jump


@njit(cache=True, nogil=True, error_model="numpy")
def _accept(state: TrackerState, h: Matrix, corners: Matrix, expected: Matrix) -> None:
    """Accept a result; the prediction error sets the next search margin."""
    if state.lost[0] > 0:
        _reset_motion(state)
    else:
        back = np.empty((3, 3))
        inverse(state.homography, back)
        multiply(back, h, state.motion)
    state.homography[:] = h
    state.last[:] = corners
    state.lost[0] = 0
    margin = PREDICTION_ERROR_FACTOR * _largest_difference(corners, expected)
    state.reach[SEARCH] = min(max(margin, MIN_SEARCH_PX), state.reach[SEARCH_LIMIT])


@njit(cache=True, nogil=True, error_model="numpy")
def _reset_motion(state: TrackerState) -> None:
    state.motion[:] = 0.0
    for i in range(3):
        state.motion[i, i] = 1.0


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_lost(state: TrackerState) -> None:
    """Predict the target where it last was, and enlarge the search margin."""
    _reset_motion(state)
    reach = state.reach
    grown = (
        max(REACH_GROWTH * reach[SEARCH], reach[SEARCH_LIMIT])
        if state.lost[0] > 0
        else reach[SEARCH_LIMIT]
    )
    reach[SEARCH] = min(grown, max(reach[REACQUIRE], reach[SEARCH_LIMIT]))
    state.lost[0] += 1


@njit(cache=True, nogil=True, error_model="numpy")
def track_frame(  # fewer arguments would have to be packed and unpacked
    image: NDArray[np.uint8],
    window: Window,
    state: Numbers,
    search_numbers: Numbers,
    level_numbers: Matrix,
    store: PlaneStore,
) -> tuple[bool, float, int, Window]:
    """Find the target in the next image, of which only the window is read.

    Returns whether it was found, the ZNCC, the iterations, and the window of the following image.
    """
    known, search = unpack_state(state), unpack_search(search_numbers)
    levels = (level_numbers, store)
    h = np.empty((3, 3))
    expected = np.empty((4, 2))
    corners = np.empty((4, 2))
    small = pyramid(image, window, search.levels)
    _predict_homography(known, h)
    apply(h, known.template_corners, expected)
    jump = MAX_JUMP * 2.0 * level_numbers[0, SCALE]
    lowest = LOWEST_CORRELATION
    if known.lost[0] > 0 and known.reach[REACQUIRE] > 0.0:
        lowest = LOWEST_CORRELATION_REACQUIRE
        jump += known.reach[SEARCH]
        _grid_search(image, small, window, h, levels, search, known.reach[SEARCH])
    iterations, sane, similar = _align_pyramid(image, small, window, h, levels, search)
    apply(h, known.template_corners, corners)
    found = sane and similar >= lowest and _plausible(corners, known, jump)
    if found:
        _accept(known, h, corners, expected)
    else:
        _mark_lost(known)
    ahead = _window(known, image.shape[1], image.shape[0])
    return found, similar, iterations, ahead


@njit(cache=True, nogil=True, error_model="numpy")
def extract_templates(
    image: NDArray[np.uint8], window: Window, h: Matrix, levels: PyramidLevels, count: int
) -> None:
    """Extract the patches of all levels from the image in which the target is known."""
    small = pyramid(image, window, count)
    extract_patch(image, _bounds(window), h, pyramid_level(levels, 0))
    low = np.empty((3, 3))
    for k in range(1, count):
        to_pyramid_level(h, k, window, low)
        extract_patch(small[k - 1], full_bounds(small[k - 1]), low, pyramid_level(levels, k))
