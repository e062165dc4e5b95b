"""`esm`: tracks a textured plane by aligning a template; all warps, criteria and methods."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamark.sim.numerics.arrays import Integers
from seamark.sim.trackers.interface import Corners, Track, Window
from seamark.sim.trackers.options import LARGEST_JUMP
from seamark.sim.trackers.template import alignment
from seamark.sim.trackers.template.alignment import set_template
from seamark.sim.trackers.template.frame_step import (
    FOUND,
    MIN_SEARCH_PX,
    next_window,
    track_frame,
    unpack_state,
)
from seamark.sim.trackers.template.level_buffers import (
    UNIT,
    Numbers,
    PlaneStore,
    SearchSettings,
    allocate_levels,
    bench_for,
    bench_size,
    pack_search,
    pyramid_level,
)
from seamark.sim.trackers.template.patches import SMOOTH_SUM, Matrix
from seamark.sim.trackers.template.pyramid import MAX_LEVELS
from seamark.sim.trackers.template.pyramid_alignment import extract_template
from seamark.sim.trackers.template.warps import basis, from_square, is_convex, multiply, signed_area


class Memory(NamedTuple):
    """What a tracker has learned and keeps in mind; `track_frame` updates state and window."""

    state: Numbers
    search: Numbers
    levels: Matrix
    store: PlaneStore
    window: Integers  # (4,) of the next image


_SIMPLE_WARPS = ("translation", "rt", "srt")  # warps that the coarse levels use too
_WEIGHTS = {
    "esm": 0.5,
    "inverse_compositional": 0.0,
    "forward_additional": 1.0,
    "forward_compositional": 1.0,
}
_CRITERIA = {"ssd": alignment.SSD, "zncc": alignment.ZNCC, "mi": alignment.MI}
# Mutual information converges only from a few pixels away (a motion of 12 px loses the target), so
# the coarse levels use correlation.
_COARSE = {"mi": "zncc"}

# [px] Columns of a template with its rim of two are a multiple of it, so that no lane is wasted.
VECTOR = 16
SMALLEST_TEMPLATE_PX = 10  # shorter sides have too few pixels
LARGEST_TEMPLATE_PX = 1024
MIN_ROWS = 5  # a level with fewer does not show the target


class TemplateTracker:
    """Template tracker with an image pyramid and optional constant-velocity prediction."""

    def __init__(  # noqa: PLR0913  # one per setting
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
        smoothing: str = "patch",
        second_search: bool = False,
        max_jump: float = LARGEST_JUMP,
    ) -> None:
        self._search = SearchSettings(
            coarse_basis=basis(warp if warp in _SIMPLE_WARPS else "srt"),
            basis=basis(warp),
            weight=_WEIGHTS[method],
            is_additive=method == "forward_additional",
            coarse_criterion=_CRITERIA[_COARSE.get(criterion, criterion)],
            criterion=_CRITERIA[criterion],
            levels=pyramid_levels,
            coarse_iterations=coarse_iterations,
            fine_iterations=fine_iterations,
            stop_px=float(stop_px),
            second_levels=MAX_LEVELS if second_search else 0,
            smooth_image=smoothing == "image",
        )
        self._predict, self._margin, self._pitch = predict_motion, template_margin_px, sampling_px
        # A second search needs pixels that a good prediction would make superfluous.
        least_px = search_px if second_search else MIN_SEARCH_PX
        self._reach = (search_px, search_px, max(template_margin_px, 0), reacquire_px, least_px)
        self._max_jump = max_jump
        self._shape = (0, 0)
        self._window = np.zeros(4, np.int64)

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Learn the target from a whole image (H, W) in which its corners are known."""
        corners = np.ascontiguousarray(corners, dtype=np.float64)
        if corners.shape != (4, 2) or not is_convex(corners):
            raise ValueError("the target's corners are no convex quadrilateral (4, 2) clockwise")
        image = _contiguous(image)
        self._shape = image.shape
        columns, rows, homography, template_corners = self._frame(corners)
        self._state = self._initial_state(corners, homography, template_corners)
        self._last = unpack_state(self._state).last
        known = allocate_levels(columns, rows, MAX_LEVELS)
        every = (*known, bench_for(bench_size(known[0])))
        levels = [pyramid_level(every, k) for k in range(MAX_LEVELS)]
        useful = max(1, len([1 for each in levels if len(each.ys) >= MIN_ROWS]))
        search = self._search._replace(
            levels=min(self._search.levels, useful),
            second_levels=min(self._search.second_levels, useful),
        )
        if search.smooth_image:
            levels[0].frame[UNIT] = 1.0 / SMOOTH_SUM
        window = next_window(self._state, image.shape[1], image.shape[0])
        self._window[:] = window
        for k, level in enumerate(levels[: max(search.levels, search.second_levels)]):
            extract_template(image, window, k, homography, every, search.smooth_image)
            criterion = search.coarse_criterion if k else search.criterion
            set_template(level, criterion)
        self._known, self._bench = (pack_search(search), *known), every[-1]

    def memory(self) -> Memory:
        """Return what it has learned and keeps in mind, for compiled loops over many trackers."""
        return Memory(self._state, *self._known, self._window)

    def window(self) -> Window:
        """Return the box around the predicted target with the search margin, on even pixels.

        The margin is `search_px` at first and after a loss, when it may grow to `reacquire_px`.
        Without a second search it is smaller while predictions are accurate.
        """
        x0, y0, x1, y1 = self._window.tolist()
        return x0, y0, x1, y1

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Find the target in the next image (H, W), of which only `window()` is read."""
        if image.shape != self._shape:
            raise ValueError(f"an image of {image.shape} after one of {self._shape}")
        found, correlation, iterations = track_frame(
            _contiguous(image), self.window(), self._window, self._state, *self._known, self._bench
        )
        return Track(self._last.copy(), found == FOUND, 1.0 - correlation, iterations)

    def _initial_state(
        self,
        corners: Corners,
        homography: NDArray[np.float64],
        template_corners: NDArray[np.float64],
    ) -> Numbers:
        """Return the state after the start, for `unpack_state`."""
        parts = (
            homography,
            np.eye(3),
            template_corners,
            corners,
            self._reach,
            0.0,
            1.0,
            signed_area(corners),
            self._max_jump,
        )
        return np.concatenate([np.ravel(part) for part in (*parts, self._predict)])

    def _frame(self, corners: Corners) -> tuple[int, int, NDArray[np.float64], NDArray[np.float64]]:
        """Lay out the template on the target.

        Returns columns and rows of the template, the homography (3, 3) from it to the image, and
        the target's corners (4, 2) in it.
        """
        sides = np.sqrt(((corners[[1, 3]] - corners[0]) ** 2).sum(axis=1))
        width, height = float(sides[0]), float(sides[1])
        shorter = min(width, height)
        if shorter < SMALLEST_TEMPLATE_PX or max(width, height) > LARGEST_TEMPLATE_PX:
            raise ValueError(
                f"a target of {width:.0f}x{height:.0f} px is not within "
                f"{SMALLEST_TEMPLATE_PX}..{LARGEST_TEMPLATE_PX} px"
            )
        # A small target keeps its rim and is sampled more finely.
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
        homography = np.empty((3, 3))
        multiply(unit, to_unit, homography)
        template_corners = np.array([[left, top], [far_u, top], [far_u, far_v], [left, far_v]])
        return columns, rows, homography / homography[2, 2], template_corners


def _contiguous(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the image, or a copy if Numba would compile again for its memory layout."""
    if image.flags.c_contiguous and image.flags.writeable:
        return image
    return np.array(image, dtype=np.uint8, order="C")
