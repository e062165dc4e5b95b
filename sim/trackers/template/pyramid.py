"""Images and homographies at half, a quarter and an eighth of the resolution.

Level 0 is the image itself. Level 1 is the window that is read, in sums of 2x2 pixels; each further
level sums the one before. Pixel centres are at whole numbers, so pixel i of a level is
2 i + 1/2 of the level below it; the same holds for the template's pixels.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.uncounted import uncounted
from seamark.sim.trackers.interface import Window
from seamark.sim.trackers.template.patches import Matrix, halve, smooth_window
from seamark.sim.trackers.template.warps import assign

MAX_LEVELS = 4  # an eighth of the resolution; sums of 64 pixels fit into 16 bits
SummedImage = NDArray[np.uint16]


class Images(NamedTuple):
    """One image at all resolutions; of the first, only the window is read.

    Where only a part of the window is known, nothing may be read of the rest.
    """

    whole: NDArray[np.uint8]  # (H, W)
    smooth: SummedImage  # the window, smoothed and times 16; empty if the patches are smoothed
    small: tuple[SummedImage, SummedImage, SummedImage]  # levels 1, 2 and 3 of the window
    window: Window
    part: Window  # that is known, as of `blocks_around`


@uncounted
def blocks_around(part: Window, levels: int, window: Window) -> Window:
    """Return the smallest part of a window around this one, of whole pixels on all levels."""
    x0, y0, x1, y1 = window
    block = 1 << (levels - 1)
    return (
        max(x0 + (part[0] - x0) // block * block, x0),
        max(y0 + (part[1] - y0) // block * block, y0),
        min(x0 - (x0 - part[2]) // block * block, x1),
        min(y0 - (y0 - part[3]) // block * block, y1),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def resolutions(
    image: NDArray[np.uint8], window: Window, part: Window, levels: int, smooth_image: bool
) -> Images:
    """Return an image, of which a part of the window is known, on some pyramid levels."""
    x0, y0, x1, y1 = window
    size = (y1 - y0, x1 - x0) if smooth_image else (0, 0)
    smooth = np.empty(size, np.uint16)
    if smooth_image:
        smooth_window(image, x0, y0, _on_level(0, part, window), smooth)
    small = _halved(image, window, part, levels)
    return Images(image, smooth, small, window, part)


@uncounted
def _on_level(level: int, part: Window, window: Window) -> Window:
    """Return the pixels of a level that a part of the window becomes."""
    x0, y0 = window[0], window[1]
    return (
        (part[0] - x0) >> level,
        (part[1] - y0) >> level,
        (part[2] - x0) >> level,
        (part[3] - y0) >> level,
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _halved(
    image: NDArray[np.uint8], window: Window, part: Window, levels: int
) -> tuple[SummedImage, SummedImage, SummedImage]:
    """Return the levels 1, 2 and 3 of the window; further ones than `levels` are empty."""
    x0, y0, x1, y1 = window
    size = (y1 - y0, x1 - x0)
    none = np.empty((0, 0), np.uint16)
    if levels < 2:
        return none, none, none
    first = np.empty((size[0] // 2, size[1] // 2), np.uint16)
    halve(image, x0, y0, _on_level(1, part, window), first)
    if levels < 3:
        return first, none, none
    second = np.empty((size[0] // 4, size[1] // 4), np.uint16)
    halve(first, 0, 0, _on_level(2, part, window), second)
    if levels < 4:
        return first, second, none
    third = np.empty((size[0] // 8, size[1] // 8), np.uint16)
    halve(second, 0, 0, _on_level(3, part, window), third)
    return first, second, third


@uncounted
def known_bounds(images: Images, k: int, out: NDArray[np.float64]) -> None:
    """Write the bounds (4,) of what may be read of a level, where the part is not the window's end.

    Samples beyond the window take the value at its border, so its ends are infinite.
    """
    level = _on_level(k, images.part, images.window)
    smooth = images.smooth.shape[0] > 0
    for axis in range(2):
        low, high = float(level[axis]), float(level[axis + 2])
        if k == 0 and smooth:  # the mask has counted the pixels at the rim again
            low, high = low + 1.0, high - 1.0
        elif k == 0:
            low, high = float(images.part[axis]), float(images.part[axis + 2])
        out[axis] = low if images.part[axis] > images.window[axis] else -np.inf
        out[axis + 2] = high if images.part[axis + 2] < images.window[axis + 2] else np.inf


@uncounted
def full_bounds(image: SummedImage, out: NDArray[np.float64]) -> None:
    """Write the bounds (4,) of a whole image."""
    out[0] = out[1] = 0.0
    out[2] = image.shape[1]
    out[3] = image.shape[0]


@uncounted
def to_pyramid_level(h: Matrix, level: int, window: Window, out: Matrix) -> None:
    """Write h, template px -> image px, converted to a level of template and window."""
    assign(h, out)
    x0, y0 = float(window[0]), float(window[1])
    for _ in range(level):
        for i in range(3):
            out[i, 2] += 0.5 * (out[i, 0] + out[i, 1])
            out[i, 0] *= 2.0
            out[i, 1] *= 2.0
        for j in range(3):
            out[0, j] = 0.5 * (out[0, j] - (x0 + 0.5) * out[2, j])
            out[1, j] = 0.5 * (out[1, j] - (y0 + 0.5) * out[2, j])
        x0 = y0 = 0.0


@uncounted
def from_pyramid_level(h: Matrix, level: int, window: Window, out: Matrix) -> None:
    """Undo `to_pyramid_level`, scaled to out[2, 2] = 1."""
    assign(h, out)
    for k in range(level, 0, -1):
        x0 = float(window[0]) if k == 1 else 0.0
        y0 = float(window[1]) if k == 1 else 0.0
        for j in range(3):
            out[0, j] = 2.0 * out[0, j] + (x0 + 0.5) * out[2, j]
            out[1, j] = 2.0 * out[1, j] + (y0 + 0.5) * out[2, j]
        for i in range(3):
            out[i, 0] *= 0.5
            out[i, 1] *= 0.5
            out[i, 2] -= 0.5 * (out[i, 0] + out[i, 1])
    last = out[2, 2]
    for i in range(3):
        for j in range(3):
            out[i, j] /= last
