"""`esm`: follows a textured plane by aligning its template; all warps, criteria and methods."""

import numpy as np
from numpy.typing import NDArray

from sim.trackers.alignment import Level, Search, cut_start, empty_level, learn
from sim.trackers.following import Memory, follow, next_window
from sim.trackers.interface import Corners, Track, Window
from sim.trackers.warps import WARPS, basis, from_square, is_convex, multiply, signed_area

CRITERIA = {
    "ssd": "Sum of squared differences",
    "zncc": "Zero-mean normalised cross-correlation",
}
METHODS = {
    "esm": "Efficient second-order minimisation",
    "inverse_compositional": "Inverse compositional",
    "forward_compositional": "Forward compositional",
}
_FEW = ("translation", "rt", "srt")  # warps that the coarse level takes as they are
_WEIGHTS = {"esm": 0.5, "inverse_compositional": 0.0, "forward_compositional": 1.0}
_REASONS = {
    "mi": "mutual information needs a logarithm with the same bits on every processor, "
    "which is not there yet",
    "forward_additional": "for homographies it takes the same steps as forward_compositional to "
    "first order and is not offered apart",
}

VECTOR = 16  # [px] columns come in multiples of it, so that no pixel is done outside a vector
SMALLEST_TEMPLATE_PX = 12  # shorter sides leave too few pixels on the coarse level
LARGEST_TEMPLATE_PX = 1024
STOP_PX = 0.1  # after a step of that size about a tenth of it is left: convergence is quadratic


class TemplateTracker:
    """Template tracker with two pyramid levels and a constant-velocity prediction as an option."""

    def __init__(
        self,
        *,
        warp: str = "homography",
        criterion: str = "zncc",
        method: str = "esm",
        coarse_iterations: int = 6,
        fine_iterations: int = 5,
        predict: bool = True,
        margin_px: int = -2,
        search_px: int = 20,
    ) -> None:
        _choose("warp", warp, WARPS)
        _choose("criterion", criterion, CRITERIA)
        _choose("method", method, METHODS)
        _within("coarse_iterations", coarse_iterations, 0, 100)
        _within("fine_iterations", fine_iterations, 1, 100)
        _within("margin_px", margin_px, -2, 40)
        _within("search_px", search_px, 4, 200)
        self._search = Search(
            basis(warp if warp in _FEW else "srt"),
            basis(warp),
            _WEIGHTS[method],
            criterion == "zncc",
            coarse_iterations,
            fine_iterations,
            STOP_PX,
        )
        self._predict, self._margin, self._reach = predict, margin_px, search_px
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
        memory = Memory(
            home=home,
            motion=np.eye(3),
            quad=quad,
            last=corners.copy(),
            reach=np.array([self._reach, self._reach, max(self._margin, 0)], dtype=np.float64),
            area=float(signed_area(corners)),
            predict=self._predict,
        )
        self._last, self._memory = memory.last, tuple(memory)
        coarse, fine = self._levels(columns, rows)
        self._window = next_window(self._memory, image.shape[1], image.shape[0])
        cut_start(image, self._window, home, coarse, fine)
        for level in (coarse, fine):
            learn(level, weight=self._search.weight)
        self._packed = (tuple(coarse), tuple(fine), tuple(self._search))

    def window(self) -> Window:
        """Return the box around the expected target and its search margin, on even pixels.

        The margin is `search_px` at first and after a loss; while the target is where it was
        expected, it is less.
        """
        return self._window

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Find the target in the next picture (H, W), of which only `window()` is read."""
        if image.shape != self._shape:
            raise ValueError(f"a picture of {image.shape} after one of {self._shape}")
        found, correlation, iterations, self._window = follow(
            _plain(image), self._window, self._memory, self._packed
        )
        return Track(self._last.copy(), found, 1.0 - correlation, iterations)

    def _frame(self, corners: Corners) -> tuple[int, int, NDArray[np.float64], NDArray[np.float64]]:
        """Place the template's pixels on the target.

        Returns their columns and rows, the homography (3, 3) from them to the picture, and the
        target's corners (4, 2) among them.
        """
        m = self._margin
        sides = np.sqrt(((corners[[1, 3]] - corners[0]) ** 2).sum(axis=1))
        width, height = float(sides[0]), float(sides[1])
        if (
            min(width, height) + 2 * m < SMALLEST_TEMPLATE_PX
            or max(width, height) > LARGEST_TEMPLATE_PX
        ):
            raise ValueError(
                f"a template of {width:.0f}x{height:.0f} px with a margin of {m} px is not within "
                f"{SMALLEST_TEMPLATE_PX}..{LARGEST_TEMPLATE_PX} px"
            )
        columns = max(VECTOR, round((width + 2 * m) / VECTOR) * VECTOR)
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

    @staticmethod
    def _levels(columns: int, rows: int) -> tuple[Level, Level]:
        """Return the coarse and the fine level for a template of that size."""
        scale, column, row = max(columns, rows) / 2, (columns - 1) / 2, (rows - 1) / 2
        coarse = empty_level(
            columns // 2,
            rows // 2,
            scale=scale / 2,
            column=(column - 0.5) / 2,
            row=(row - 0.5) / 2,
        )
        return coarse, empty_level(columns, rows, scale=scale, column=column, row=row)


def _plain(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the picture, or a copy if Numba would compile anew for its memory layout."""
    if image.flags.c_contiguous and image.flags.writeable:
        return image
    return np.array(image, dtype=np.uint8, order="C")


def _choose(field: str, value: str, offered: dict[str, str]) -> None:
    if value not in offered:
        reason = _REASONS.get(value, f"choose one of {', '.join(offered)}")
        raise ValueError(f"{field} {value!r} is not offered: {reason}")


def _within(field: str, value: int, low: int, high: int) -> None:
    if not low <= value <= high:
        raise ValueError(f"{field} is {value}; it must be {low}..{high}")
