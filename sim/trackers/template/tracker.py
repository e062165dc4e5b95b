"""`esm`: follows a textured plane by aligning its template; all warps, criteria and methods."""

import numpy as np
from numpy.typing import NDArray

from seamark.sim.trackers.interface import Corners, Track, Window
from seamark.sim.trackers.template import alignment
from seamark.sim.trackers.template.alignment import learn
from seamark.sim.trackers.template.frame_step import cut_start, follow, memory_of, next_window
from seamark.sim.trackers.template.level_buffers import (
    Numbers,
    Search,
    empty_levels,
    level_of,
    packed,
)
from seamark.sim.trackers.template.pyramid import MOST_LEVELS
from seamark.sim.trackers.template.warps import basis, from_square, is_convex, multiply, signed_area

_FEW = ("translation", "rt", "srt")  # warps that the coarse levels take as they are
_WEIGHTS = {
    "esm": 0.5,
    "inverse_compositional": 0.0,
    "forward_additional": 1.0,
    "forward_compositional": 1.0,
}
_CRITERIA = {"ssd": alignment.SSD, "zncc": alignment.ZNCC, "mi": alignment.MI}
# Mutual information finds its target from a few pixels away only (lost in the first picture where
# the target moves 12 px); on the coarse levels correlation leads it there.
_COARSE = {"mi": "zncc"}

# [px] A template's columns and its rim of two come in multiples of it, so that no pixel is done in
# vain beyond the last.
VECTOR = 16
SMALLEST_TEMPLATE_PX = 10  # shorter sides leave too few pixels
LARGEST_TEMPLATE_PX = 1024
LEAST_ROWS = 5  # a level with fewer shows nothing


class TemplateTracker:
    """Template tracker with a pyramid and a constant-velocity prediction as an option."""

    def __init__(  # noqa: PLR0913  # one for each setting
        self,
        *,
        warp: str = "homography",
        criterion: str = "zncc",
        method: str = "esm",
        pyramid_levels: int = 2,
        coarse_iterations: int = 6,
        fine_iterations: int = 5,
        stop_px: float = 0.5,
        sampling_px: float = 1.0,
        template_margin_px: int = -3,
        predict_motion: bool = True,
        search_px: int = 20,
        reacquire_px: int = 0,
    ) -> None:
        self._search = Search(
            coarse_basis=basis(warp if warp in _FEW else "srt"),
            basis=basis(warp),
            weight=_WEIGHTS[method],
            adds=method == "forward_additional",
            coarse_criterion=_CRITERIA[_COARSE.get(criterion, criterion)],
            criterion=_CRITERIA[criterion],
            levels=pyramid_levels,
            coarse_iterations=coarse_iterations,
            fine_iterations=fine_iterations,
            stop_px=float(stop_px),
        )
        self._predict, self._margin, self._pitch = predict_motion, template_margin_px, sampling_px
        self._reach = (search_px, search_px, max(template_margin_px, 0), reacquire_px)
        self._shape = (0, 0)
        self._window: Window = (0, 0, 0, 0)

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Learn the target from a whole picture (H, W) in which its corners are known."""
        corners = np.ascontiguousarray(corners, dtype=np.float64)
        if corners.shape != (4, 2) or not is_convex(corners):
            raise ValueError("the target's corners are no convex quadrilateral (4, 2) clockwise")
        image = _plain(image)
        self._shape = image.shape
        columns, rows, home, quad = self._frame(corners)
        self._memory = self._beginning(corners, home, quad)
        self._last = memory_of(self._memory).last
        every = empty_levels(columns, rows, MOST_LEVELS)
        levels = [level_of(every, k) for k in range(MOST_LEVELS)]
        count = min(self._search.levels, len([1 for each in levels if len(each.ys) >= LEAST_ROWS]))
        search = self._search._replace(levels=max(count, 1))
        self._window = next_window(self._memory, image.shape[1], image.shape[0])
        cut_start(image, self._window, home, every, search.levels)
        learn(levels[0], search.weight, search.criterion)
        for level in levels[1 : search.levels]:
            learn(level, search.weight, search.coarse_criterion)
        self._known = (packed(search), *every)

    def window(self) -> Window:
        """Return the box around the expected target and its search margin, on even pixels.

        The margin is `search_px` at first and after a loss, when it may grow to `reacquire_px`;
        while the target is where it was expected, it is less.
        """
        return self._window

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Find the target in the next picture (H, W), of which only `window()` is read."""
        if image.shape != self._shape:
            raise ValueError(f"a picture of {image.shape} after one of {self._shape}")
        found, correlation, iterations, self._window = follow(
            _plain(image), self._window, self._memory, *self._known
        )
        return Track(self._last.copy(), found, 1.0 - correlation, iterations)

    def _beginning(
        self, corners: Corners, home: NDArray[np.float64], quad: NDArray[np.float64]
    ) -> Numbers:
        """Return what the tracker knows at first, for `memory_of`."""
        parts = (home, np.eye(3), quad, corners, self._reach, 0.0, signed_area(corners))
        return np.concatenate([np.ravel(part) for part in (*parts, self._predict)])

    def _frame(self, corners: Corners) -> tuple[int, int, NDArray[np.float64], NDArray[np.float64]]:
        """Place the template's pixels on the target.

        Returns their columns and rows, the homography (3, 3) from them to the picture, and the
        target's corners (4, 2) among them.
        """
        sides = np.sqrt(((corners[[1, 3]] - corners[0]) ** 2).sum(axis=1))
        width, height = float(sides[0]), float(sides[1])
        shorter = min(width, height)
        if shorter < SMALLEST_TEMPLATE_PX or max(width, height) > LARGEST_TEMPLATE_PX:
            raise ValueError(
                f"a target of {width:.0f}x{height:.0f} px is not within "
                f"{SMALLEST_TEMPLATE_PX}..{LARGEST_TEMPLATE_PX} px"
            )
        # Of a small target, a margin inside or wide sampling would leave too little.
        m = (
            max(self._margin, 0)
            if shorter + 2 * self._margin < SMALLEST_TEMPLATE_PX
            else self._margin
        )
        wanted = min(self._pitch, (shorter + 2 * m) / SMALLEST_TEMPLATE_PX)
        blocks = max(1, round((width + 2 * m) / (VECTOR * wanted)))
        columns = blocks * VECTOR - 2
        pitch = (width + 2 * m) / (columns - 1)
        rows = int((height + 2 * m) / pitch) + 1
        unit = np.empty((3, 3))
        if not from_square(corners, unit):
            raise ValueError("the target's corners lie on a line")
        left, far_u = m / pitch, (width + m) / pitch
        top = 0.5 * (rows - 1 - height / pitch)
        far_v = top + height / pitch
        across, down = pitch / width, pitch / height
        to_unit = np.array([[across, 0, -left * across], [0, down, -top * down], [0, 0, 1.0]])
        home = np.empty((3, 3))
        multiply(unit, to_unit, home)
        quad = np.array([[left, top], [far_u, top], [far_u, far_v], [left, far_v]])
        return columns, rows, home / home[2, 2], quad


def _plain(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the picture, or a copy if Numba would compile anew for its memory layout."""
    if image.flags.c_contiguous and image.flags.writeable:
        return image
    return np.array(image, dtype=np.uint8, order="C")
