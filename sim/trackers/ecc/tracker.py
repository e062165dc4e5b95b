"""`ecc`: OpenCV's enhanced correlation coefficient (Evangelidis & Psarakis, PAMI 2008).

Set up as fairly as our own tracker: of the template the target's face alone counts (what is beside
it lies in another plane and pulled the corners 1 px off), and the search starts where the target is
expected by its last motion, at coarser resolutions first. Without these it is lost at 4 to 6 px a
picture.
"""

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from seamark.sim.trackers.interface import Corners, Track, Window
from seamark.sim.trackers.plausibility import Judge

LOWEST_CORRELATION = 0.5  # E: as for the template tracker
SMOOTHING = 3  # [px] width of the Gaussian that OpenCV puts over both pictures
INSET_PX = 2  # E: the rim mixes with what is beside the target
BESIDE_PX = 4  # E: of the surroundings, for the coarse level
MOST_LEVELS = 2  # E: a third made it no surer in fast motion, and half as slow again
LEAST_ROWS = 8  # E: of a level; fewer show nothing
LEAST_FACE_PX = 16  # E: of a side; of a smaller target the rim is part of the template
STOP = 1e-3  # E: less change of the correlation; 1e-4 gave the same errors
_MOTIONS = {
    "translation": cv2.MOTION_TRANSLATION,
    "rt": cv2.MOTION_EUCLIDEAN,
    "affine": cv2.MOTION_AFFINE,
    "homography": cv2.MOTION_HOMOGRAPHY,
}
# Where a pixel of the whole picture is in one of half the size.
_HALF = np.array([[0.5, 0.0, -0.25], [0.0, 0.5, -0.25], [0.0, 0.0, 1.0]])
_DOUBLE = np.array([[2.0, 0.0, 0.5], [0.0, 2.0, 0.5], [0.0, 0.0, 1.0]])
Picture = NDArray[np.uint8]
Matrix = NDArray[np.float64]  # (3, 3)


class _Level(NamedTuple):
    """What is compared at one resolution."""

    template: Picture
    face: Picture  # 255 where the template shows the target
    everywhere: Picture  # (H, W): nothing of the pictures is left out


class EccTracker:
    """Aligns the target's face in the first picture with each next one."""

    def __init__(
        self,
        *,
        warp: str = "homography",
        ecc_iterations: int = 20,
        predict_motion: bool = True,
    ) -> None:
        self._motion, self._predict = _MOTIONS[warp], predict_motion
        self._until = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, ecc_iterations, STOP)
        self._shape = (0, 0)

    def start(self, image: Picture, corners: Corners) -> None:
        """Cut the box around the corners (4, 2) out of a whole picture (H, W)."""
        self._judge = Judge(corners)
        self._shape = image.shape
        height, width = image.shape
        low = np.floor(corners.min(axis=0)) - BESIDE_PX
        high = np.ceil(corners.max(axis=0)) + BESIDE_PX
        x0, y0 = (int(max(value, 0)) // 2 * 2 for value in low)
        x1, y1 = int(min(high[0], width)), int(min(high[1], height))
        if min(x1 - x0, y1 - y0) < 2 * SMOOTHING:
            raise ValueError("the target is too small or outside the picture")
        template = image[y0:y1, x0:x1].copy()
        self._corners = self._judge.last - (x0, y0)
        face = _face(template.shape, self._corners)
        # What is beside the target leads to it from afar; the finest level makes up for its pull.
        self._levels = [_Level(template, face, np.full(image.shape, 255, np.uint8))]
        while len(self._levels) < MOST_LEVELS and min(template.shape) >= 2 * LEAST_ROWS:
            template = _halved(template)
            whole = np.full(template.shape, 255, np.uint8)
            self._levels.append(_Level(template, whole, _halved(self._levels[-1].everywhere)))
        self._home = np.eye(3)
        self._home[:2, 2] = x0, y0
        self._before = self._home.copy()

    def window(self) -> Window:
        """Return the whole picture."""
        return 0, 0, self._shape[1], self._shape[0]

    def update(self, image: Picture) -> Track:
        """Align the template with the next picture (H, W), from its expected place on."""
        expected = self._home
        if self._predict:
            expected = _scaled(self._home @ np.linalg.inv(self._before) @ self._home)
        pictures = [image]
        for _ in self._levels[1:]:
            pictures.append(_halved(pictures[-1]))
            expected = _HALF @ expected @ _DOUBLE
        alike, h = 0.0, expected
        for k in range(len(pictures) - 1, -1, -1):
            alike, h = self._aligned(self._levels[k], pictures[k], h)
            if k > 0:
                h = _DOUBLE @ h @ _HALF
        ok = False
        if alike >= LOWEST_CORRELATION:
            points = self._corners @ h[:, :2].T + h[:, 2]
            ok = self._judge.believes(points[:, :2] / points[:, 2:])
        # While it is lost the target is expected to stand still.
        self._before, self._home = (self._home, h) if ok else (self._home, self._home)
        return Track(self._judge.last.copy(), ok, 1.0 - alike, 1)

    def _aligned(self, level: _Level, image: Picture, start: Matrix) -> tuple[float, Matrix]:
        """Return correlation and warp (3, 3); 0 and the start where OpenCV finds none."""
        rows = 3 if self._motion == cv2.MOTION_HOMOGRAPHY else 2
        first = _scaled(start)[:rows].astype(np.float32)
        settings = (self._motion, self._until, SMOOTHING)
        try:
            alike, warp = cv2.findTransformECCWithMask(
                level.template, image, level.face, level.everywhere, first, *settings
            )
        except cv2.error:  # it throws where it does not converge
            return 0.0, start
        if not (alike >= LOWEST_CORRELATION and np.isfinite(warp).all()):
            return 0.0, start
        h = np.eye(3)
        h[:rows] = warp
        return float(alike), h


def _face(shape: tuple[int, ...], corners: Corners) -> Picture:
    """Return 255 where a picture (H, W) shows the target's face, without its rim."""
    face = np.zeros(shape, np.uint8)
    cv2.fillConvexPoly(face, np.round(corners).astype(np.int32), 255)
    if min(shape) < LEAST_FACE_PX:
        return face
    side = 2 * INSET_PX + 1
    inner = cv2.erode(face, np.ones((side, side), np.uint8), borderValue=0)
    return np.asarray(inner, dtype=np.uint8)


def _halved(image: Picture) -> Picture:
    """Return means of 2x2 pixels; an odd last row or column is left out."""
    height, width = image.shape
    even = image[: height // 2 * 2, : width // 2 * 2]
    small = cv2.resize(even, (width // 2, height // 2), interpolation=cv2.INTER_AREA)
    return np.asarray(small, dtype=np.uint8)


def _scaled(h: Matrix) -> Matrix:
    return np.asarray(h / h[2, 2], dtype=np.float64)
