"""`ecc`: OpenCV's enhanced correlation coefficient (Evangelidis & Psarakis, PAMI 2008)."""

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.trackers.interface import Corners, Track, Window
from sim.trackers.judging import Judge

LOWEST_CORRELATION = 0.5  # E: as for the template tracker
SMOOTHING = 3  # [px] width of the Gaussian that OpenCV puts over both pictures
_MOTIONS = {
    "translation": cv2.MOTION_TRANSLATION,
    "rt": cv2.MOTION_EUCLIDEAN,
    "affine": cv2.MOTION_AFFINE,
    "homography": cv2.MOTION_HOMOGRAPHY,
}


class EccTracker:
    """Aligns the target's surroundings in the first picture with each next one."""

    def __init__(self, *, warp: str = "homography", ecc_iterations: int = 20) -> None:
        self._motion = _MOTIONS[warp]
        self._until = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, ecc_iterations, 1e-3)
        self._shape = (0, 0)

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Cut the box around the corners (4, 2) out of a whole picture (H, W)."""
        self._judge = Judge(corners)
        self._shape = image.shape
        height, width = image.shape
        low, high = np.floor(corners.min(axis=0)), np.ceil(corners.max(axis=0)) + 1
        x0, y0 = int(max(low[0], 0)), int(max(low[1], 0))
        x1, y1 = int(min(high[0], width)), int(min(high[1], height))
        if min(x1 - x0, y1 - y0) < 2 * SMOOTHING:
            raise ValueError("the target is too small or outside the picture")
        self._all = np.full(image.shape, 255, np.uint8)
        self._template = image[y0:y1, x0:x1].copy()
        self._corners = self._judge.last - (x0, y0)
        self._warp = np.eye(3, dtype=np.float32)
        self._warp[:2, 2] = x0, y0
        if self._motion != cv2.MOTION_HOMOGRAPHY:
            self._warp = self._warp[:2].copy()

    def window(self) -> Window:
        """Return the whole picture."""
        return 0, 0, self._shape[1], self._shape[0]

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Align the template with the next picture (H, W), from the last place on."""
        alike, ok = 0.0, False
        try:
            alike, warp = cv2.findTransformECC(
                self._template,
                image,
                self._warp.copy(),
                self._motion,
                self._until,
                self._all,
                SMOOTHING,
            )
        except cv2.error:  # it throws where it does not converge: the target is lost
            return Track(self._judge.last.copy(), False, 1.0, 0)
        if np.isfinite(warp).all() and alike >= LOWEST_CORRELATION:
            h = np.eye(3)
            h[: len(warp)] = warp
            points = self._corners @ h[:, :2].T + h[:, 2]
            ok = self._judge.believes(points[:, :2] / points[:, 2:])
        if ok:
            self._warp = np.asarray(warp, dtype=np.float32)
        return Track(self._judge.last.copy(), ok, 1.0 - float(alike), 1)
