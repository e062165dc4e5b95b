"""Aligns the template with an image over all pyramid levels: first search, second search, grid."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.stack import on_stack
from seamark.sim.numerics.uncounted import uncounted
from seamark.sim.trackers.interface import Window
from seamark.sim.trackers.template.alignment import (
    MISSED,
    SANE,
    Stage,
    align,
    extract_patch,
    is_known,
    zncc,
)
from seamark.sim.trackers.template.level_buffers import (
    COLUMNS,
    PyramidLevels,
    SearchSettings,
    pyramid_level,
)
from seamark.sim.trackers.template.patches import Matrix
from seamark.sim.trackers.template.pyramid import (
    Images,
    from_pyramid_level,
    full_bounds,
    known_bounds,
    resolutions,
    to_pyramid_level,
)
from seamark.sim.trackers.template.warps import assign

# E: of the second search on each pyramid level; 10 found 1 to 2 % less of the targets.
SECOND_ITERATIONS = 30
# E: it begins at a quarter of the resolution and then at an eighth. Down to a quarter it aligns
# scale, rotation and translation, which converge from farther away, and from there on the warp.
_QUARTER = 2


@uncounted
def _bounds(images: Images, out: NDArray[np.float64]) -> None:
    for k in range(4):
        out[k] = images.window[k]


@njit(cache=True, nogil=True, error_model="numpy")
def _stage(search: SearchSettings, k: int, coarse: bool, iterations: int) -> Stage:
    """Return the settings on level k, for the coarse levels' warp or that of the tracker."""
    return Stage(
        search.coarse_basis if coarse else search.basis,
        search.coarse_criterion if k > 0 else search.criterion,
        search.weight,
        search.is_additive,
        iterations,
        search.stop_px,
        k > 0 or not search.smooth_image,
    )


@uncounted
def _shift(h: Matrix, du: float, dv: float) -> None:
    """Move the image of a homography by (du, dv) [px]."""
    for j in range(3):
        h[0, j] += du * h[2, j]
        h[1, j] += dv * h[2, j]


@njit(cache=True, nogil=True, error_model="numpy")
def _align_level(
    images: Images, k: int, h: Matrix, levels: PyramidLevels, stage: Stage
) -> tuple[int, int]:
    """Improve h (of level 0) on level k; return iterations and how it ended."""
    level = pyramid_level(levels, k)
    bounds, known = on_stack(np.float64, 4), on_stack(np.float64, 4)
    known_bounds(images, k, known)
    if k > 0:
        low = on_stack(np.float64, 3, 3)
        to_pyramid_level(h, k, images.window, low)
        small = images.small[k - 1]
        full_bounds(small, bounds)
        done, end = align(small, bounds, known, low, level, stage)
        from_pyramid_level(low, k, images.window, h)
        return done, end
    if stage.smooth:
        _bounds(images, bounds)
        return align(images.whole, bounds, known, h, level, stage)
    x0, y0 = float(images.window[0]), float(images.window[1])
    _shift(h, -x0, -y0)
    full_bounds(images.smooth, bounds)
    done, end = align(images.smooth, bounds, known, h, level, stage)
    _shift(h, x0, y0)
    return done, end


@njit(cache=True, nogil=True, error_model="numpy")
def _extract(images: Images, k: int, h: Matrix, levels: PyramidLevels) -> bool:
    """Sample the image under h (of level 0) into the patch of level k; False if it is not known."""
    low, bounds = on_stack(np.float64, 3, 3), on_stack(np.float64, 4)
    known = on_stack(np.float64, 4)
    to_pyramid_level(h, k, images.window, low)
    level = pyramid_level(levels, k)
    smooth = k == 0 and images.smooth.shape[0] > 0
    if smooth:
        _shift(low, -float(images.window[0]), -float(images.window[1]))
    known_bounds(images, k, known)
    if not is_known(low, level, known):
        return False
    if k > 0:
        small = images.small[k - 1]
        full_bounds(small, bounds)
        extract_patch(small, bounds, low, level, True)
    elif smooth:
        full_bounds(images.smooth, bounds)
        extract_patch(images.smooth, bounds, low, level, False)
    else:
        _bounds(images, bounds)
        extract_patch(images.whole, bounds, low, level, True)
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _similarity_at(images: Images, k: int, h: Matrix, levels: PyramidLevels) -> float:
    """Return the ZNCC of level k with the image under h (of level 0); NaN if it is not known."""
    if not _extract(images, k, h, levels):
        return np.nan
    return zncc(pyramid_level(levels, k))


@njit(cache=True, nogil=True, error_model="numpy")
def align_pyramid(
    images: Images, h: Matrix, levels: PyramidLevels, search: SearchSettings
) -> tuple[int, int, float]:
    """Improve h on all levels; return iterations, how it ended and the final ZNCC.

    The ZNCC is that of level 1, where the noise is a quarter as strong. Nothing outside the window
    is read.
    """
    done = 0
    for k in range(search.levels - 1, -1, -1):
        most = search.coarse_iterations if k > 0 else search.fine_iterations
        more, end = _align_level(images, k, h, levels, _stage(search, k, k > 0, most))
        done += more
        if end != SANE:
            return done, end, 0.0
    similar = _similarity_at(images, min(1, search.levels - 1), h, levels)
    return done, MISSED if np.isnan(similar) else SANE, similar


@njit(cache=True, nogil=True, error_model="numpy")
def _align_from(
    images: Images, coarsest: int, h: Matrix, levels: PyramidLevels, search: SearchSettings
) -> tuple[int, bool]:
    """Improve h from a pyramid level down to the finest; return iterations and validity."""
    done = 0
    for k in range(coarsest, -1, -1):
        for coarse in (True, False):
            if (coarse and k < min(coarsest, _QUARTER)) or (not coarse and k > _QUARTER):
                continue
            stage = _stage(search, k, coarse, SECOND_ITERATIONS)
            more, end = _align_level(images, k, h, levels, stage)
            done += more
            if end != SANE:
                return done, False
    return done, True


@njit(cache=True, nogil=True, error_model="numpy")
def search_again(
    images: Images,
    start: Matrix,
    levels: PyramidLevels,
    search: SearchSettings,
    enough: float,
    h: Matrix,
) -> tuple[int, float]:
    """Write the best homography of the second search; return iterations and its ZNCC.

    It begins at the homography `start`, on one coarse level after the other until the ZNCC is
    `enough`. If it finds none, the ZNCC is -1 and h unchanged. The whole window must be known.
    """
    whole = images.window
    every = resolutions(images.whole, whole, whole, search.second_levels, search.smooth_image)
    top = search.second_levels - 1
    done, best = 0, -1.0
    warp = on_stack(np.float64, 3, 3)
    for coarsest in range(min(_QUARTER, top), top + 1):
        assign(start, warp)
        more, sane = _align_from(every, coarsest, warp, levels, search)
        done += more
        if not sane:
            continue
        similar = _similarity_at(every, min(1, top), warp, levels)
        if similar > best:
            best = similar
            assign(warp, h)
        if best >= enough:
            break
    return done, best


@njit(cache=True, nogil=True, error_model="numpy")
def grid_search(
    images: Images, h: Matrix, levels: PyramidLevels, search: SearchSettings, radius: float
) -> None:
    """Move h to the position with the best ZNCC on a grid around the last one.

    The spacing is a quarter of the template's shorter side, so the alignment converges from the
    nearest point. The whole window must be known.
    """
    k = min(1, search.levels - 1)
    pitch = np.sqrt(h[0, 0] * h[0, 0] + h[1, 0] * h[1, 0])  # image px per template px
    finest = pyramid_level(levels, 0)
    shorter = min(finest.ys.shape[0], finest.frame[COLUMNS]) * pitch
    step = min(max(0.25 * shorter, 2.0), 12.0)
    count = int(radius / step)
    best = -2.0
    start, there = on_stack(np.float64, 3, 3), on_stack(np.float64, 3, 3)
    assign(h, start)
    for row in range(-count, count + 1):
        for column in range(-count, count + 1):
            assign(start, there)
            _shift(there, column * step, row * step)
            similarity = _similarity_at(images, k, there, levels)
            if similarity > best:
                best = similarity
                assign(there, h)


@njit(cache=True, nogil=True, error_model="numpy")
def extract_template(
    image: NDArray[np.uint8],
    window: Window,
    k: int,
    h: Matrix,
    levels: PyramidLevels,
    smooth_image: bool,
) -> None:
    """Extract the patch of level k from the image in which the target is known."""
    _extract(resolutions(image, window, window, k + 1, smooth_image), k, h, levels)
