"""One frame of template tracking: predict, align, check plausibility, choose the next window.

All of it is one compiled call with few arrays (level_buffers.py): several calls per image would
take as long as the alignment itself.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.arrays import Integers
from seamark.sim.numerics.stack import on_stack
from seamark.sim.numerics.uncounted import uncounted
from seamark.sim.trackers.interface import Window
from seamark.sim.trackers.template.alignment import MISSED, SANE
from seamark.sim.trackers.template.level_buffers import (
    SCALE,
    Bench,
    Numbers,
    PlaneStore,
    PyramidLevels,
    SearchSettings,
    unpack_search,
)
from seamark.sim.trackers.template.patches import Matrix
from seamark.sim.trackers.template.pyramid import Images, blocks_around, resolutions
from seamark.sim.trackers.template.pyramid_alignment import (
    align_pyramid,
    grid_search,
    search_again,
)
from seamark.sim.trackers.template.warps import (
    apply,
    assign,
    inverse,
    is_convex,
    multiply,
    signed_area,
)

LOWEST_CORRELATION = 0.5  # E: chance alignments on noise reach 0.3 to 0.4
# E: the best of some hundred positions is more often similar by chance than a single one.
LOWEST_CORRELATION_REACQUIRE = 0.7
MAX_AREA_RATIO = 4.0  # E: of the area at the start, both ways
# E: a result is doubtful, and searched for again, when 1 - ZNCC grew by more than this since the
# target was last seen: a wrong one in clear water has a ZNCC of at most 0.95.
DOUBT_FACTOR, DOUBT_OFFSET = 2.0, 0.02
# The search margin follows the last prediction error: E, four times the error, at least 8 px.
MIN_SEARCH_PX = 8.0
PREDICTION_ERROR_FACTOR = 4.0
_FAR_PX = 1e5  # nothing is expected, or moves, as far away
# [px] E: around the expected target. In currents-v1 to -v3 with PI, the patches on both levels stay
# within 1 px of it in 99 % of the images.
_LIKELY_MARGIN_PX = 2.0
REACH_GROWTH = 1.5  # E: of the search margin, for each image without the target

LOST, FOUND, PART_TOO_SMALL = range(3)  # what `track_frame` returns

SEARCH, SEARCH_LIMIT, MARGIN, REACQUIRE, SEARCH_LEAST = range(5)


class TrackerState(NamedTuple):
    """The tracker's state between images; the arrays are updated in place."""

    homography: Matrix  # (3, 3) template px -> image px where the target was last seen
    motion: Matrix  # (3, 3) of the last image, in template coordinates
    template_corners: Matrix  # (4, 2) the target's corners in template px
    last: Matrix  # (4, 2) [px] corners where the target was last seen
    # (5,) [px] search margin, its limit, margin of the template, limit after a loss, least margin
    reach: Numbers
    lost: Numbers  # (1,) images since the target was last seen
    similarity: Numbers  # (1,) ZNCC when the target was last seen
    area: float  # [px^2] of the target in the first image
    max_jump: float  # largest motion of a corner between images, in the template's longer sides
    predict: bool  # whether constant velocity is predicted


@njit(cache=True, nogil=True, error_model="numpy")
def unpack_state(numbers: Numbers) -> TrackerState:
    """Return the state as views of an array of numbers."""
    return TrackerState(
        numbers[:9].reshape(3, 3),
        numbers[9:18].reshape(3, 3),
        numbers[18:26].reshape(4, 2),
        numbers[26:34].reshape(4, 2),
        numbers[34:39],
        numbers[39:40],
        numbers[40:41],
        numbers[41],
        numbers[42],
        numbers[43] != 0.0,
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _predict_homography(state: TrackerState, out: Matrix) -> None:
    """Write the homography from which the next search starts."""
    if not state.predict:
        assign(state.homography, out)
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
    expected = on_stack(np.float64, 4, 2)
    h = on_stack(np.float64, 3, 3)
    _predict_homography(state, h)
    apply(h, state.template_corners, expected)
    last = state.last
    reach = np.ceil(state.reach[SEARCH]) + state.reach[MARGIN]
    limits = (width, height)
    window = on_stack(np.int64, 4)
    for axis in range(2):
        low = last[0, axis]
        high = low
        for k in range(4):
            low = min(low, last[k, axis])
            high = max(high, last[k, axis])
            if abs(expected[k, axis]) < _FAR_PX:
                low = min(low, expected[k, axis])
                high = max(high, expected[k, axis])
        limit = limits[axis]
        first = int(min(max(low - reach, 0.0), limit - 32.0)) // 2 * 2
        window[axis] = first
        window[axis + 2] = int(min(max(high + reach + 2.0, first + 32.0), float(limit))) // 2 * 2
    return window[0], window[1], window[2], window[3]


@njit(cache=True, nogil=True, error_model="numpy")
def next_window(state: Numbers, width: int, height: int) -> Window:
    """Return the box x0, y0, x1, y1 of the next image that will be read."""
    return _window(unpack_state(state), width, height)


@njit(cache=True, nogil=True, error_model="numpy")
def likely_part(state: Numbers, levels: int, window: Window) -> Window:
    """Return the part of the next window in which the target is, if it is where it is expected.

    The whole window if the target is lost, or expected nowhere. It is of whole pixels on so many
    pyramid levels.
    """
    known = unpack_state(state)
    if known.lost[0] > 0:
        return window
    h, expected = on_stack(np.float64, 3, 3), on_stack(np.float64, 4, 2)
    _predict_homography(known, h)
    apply(h, known.template_corners, expected)
    reach = known.reach[MARGIN] + _LIKELY_MARGIN_PX
    part = on_stack(np.int64, 4)
    for axis in range(2):
        low = high = expected[0, axis]
        for k in range(1, 4):
            low, high = min(low, expected[k, axis]), max(high, expected[k, axis])
        if not abs(low) + abs(high) < _FAR_PX:
            return window
        part[axis], part[axis + 2] = int(np.floor(low - reach)), int(np.ceil(high + reach))
        if part[axis] >= window[axis + 2] or part[axis + 2] <= window[axis]:
            return window
    return blocks_around((part[0], part[1], part[2], part[3]), levels, window)


@uncounted
def _largest_difference(a: Matrix, b: Matrix) -> float:
    """Return the largest absolute difference; inf if one is not finite."""
    most = 0.0
    for k in range(a.shape[0]):
        for axis in range(2):
            off = abs(a[k, axis] - b[k, axis])
            if not off < _FAR_PX:
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
def _accept(
    state: TrackerState, h: Matrix, corners: Matrix, expected: Matrix, similar: float
) -> None:
    """Accept a result; the prediction error sets the next search margin."""
    if state.lost[0] > 0:
        _reset_motion(state)
    else:
        back = on_stack(np.float64, 3, 3)
        inverse(state.homography, back)
        multiply(back, h, state.motion)
    assign(h, state.homography)
    assign(corners, state.last)
    state.lost[0] = 0
    state.similarity[0] = similar
    margin = PREDICTION_ERROR_FACTOR * _largest_difference(corners, expected)
    state.reach[SEARCH] = min(max(margin, state.reach[SEARCH_LEAST]), state.reach[SEARCH_LIMIT])


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


@uncounted
def _least_similarity(known: TrackerState) -> float:
    """Return the ZNCC below which a result is doubtful."""
    return float(1.0 - (DOUBT_FACTOR * (1.0 - known.similarity[0]) + DOUBT_OFFSET))


@njit(cache=True, nogil=True, error_model="numpy")
def _second_search(
    images: Images,
    known: TrackerState,
    levels: PyramidLevels,
    search: SearchSettings,
    start: Matrix,
    similar: float,
    jump: float,
    h: Matrix,
) -> tuple[int, float]:
    """Replace a doubtful h if there is a better one; return iterations and the ZNCC.

    `similar` is the ZNCC of h, or 0 if h is not plausible. The best of several alignments is more
    often similar by chance than a single one, so its ZNCC must be higher.
    """
    enough = _least_similarity(known)
    other, corners = on_stack(np.float64, 3, 3), on_stack(np.float64, 4, 2)
    done, best = search_again(images, start, levels, search, enough, other)
    if best > max(similar, LOWEST_CORRELATION_REACQUIRE):
        apply(other, known.template_corners, corners)
        if _plausible(corners, known, jump):
            assign(other, h)
            return done, best
    return done, similar


@njit(cache=True, nogil=True, error_model="numpy")
def track_frame(  # fewer arguments would have to be packed and unpacked
    image: NDArray[np.uint8],
    part: Window,
    box: Integers,
    state: Numbers,
    search_numbers: Numbers,
    level_numbers: Matrix,
    store: PlaneStore,
    bench: Bench,
) -> tuple[int, float, int]:
    """Find the target in the next image, of which only a part of the window `box`, (4,), is read.

    Returns whether the target was found (`LOST`, `FOUND`), the ZNCC, and the iterations; `box` is
    then the window of the following image. Or, if more than the part is needed, `PART_TOO_SMALL`;
    then nothing has changed, and the image can be tried again with the whole window.

    Parameters
    ----------
    part
        As `likely_part`, or the whole window. The result is the same.
    """
    window = (box[0], box[1], box[2], box[3])
    known, search = unpack_state(state), unpack_search(search_numbers)
    levels = (level_numbers, store, bench)
    h, start = on_stack(np.float64, 3, 3), on_stack(np.float64, 3, 3)
    expected, corners = on_stack(np.float64, 4, 2), on_stack(np.float64, 4, 2)
    images = resolutions(image, window, part, search.levels, search.smooth_image)
    _predict_homography(known, h)
    apply(h, known.template_corners, expected)
    jump = known.max_jump * 2.0 * level_numbers[0, SCALE]
    lowest = LOWEST_CORRELATION
    if known.lost[0] > 0 and known.reach[REACQUIRE] > 0.0:
        lowest = LOWEST_CORRELATION_REACQUIRE
        jump += known.reach[SEARCH]
        if part != window:
            return PART_TOO_SMALL, 0.0, 0
        grid_search(images, h, levels, search, known.reach[SEARCH])
    assign(h, start)
    iterations, end, similar = align_pyramid(images, h, levels, search)
    if end == MISSED:
        return PART_TOO_SMALL, 0.0, iterations
    apply(h, known.template_corners, corners)
    tracked = end == SANE and similar >= lowest and _plausible(corners, known, jump)
    sure = similar if tracked else 0.0
    if search.second_levels > 0 and sure < _least_similarity(known):
        if part != window:
            return PART_TOO_SMALL, 0.0, iterations
        more, again = _second_search(images, known, levels, search, start, sure, jump, h)
        iterations += more
        if again > 0.0:
            tracked, similar = True, again
            apply(h, known.template_corners, corners)
    if tracked:
        _accept(known, h, corners, expected, similar)
    else:
        _mark_lost(known)
    box[0], box[1], box[2], box[3] = _window(known, image.shape[1], image.shape[0])
    return FOUND if tracked else LOST, similar, iterations
