"""`klt`: corners followed by optical flow, and the warp that most of them agree on (OpenCV)."""

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from seamark.sim.trackers.interface import Corners, Track, Window
from seamark.sim.trackers.plausibility import Judge

LEAST_POINTS = 8  # E: with fewer, four wrong ones can outvote the rest
LEAST_SHARE = 0.4  # E: of the points; below it the agreement is chance
AGREES_PX = 2.0  # E: a point farther from the warp is no inlier
SURE = 0.995  # E: that RANSAC draws only inliers once, if as many as LEAST_SHARE are
# D: ln(1 - SURE) / ln(1 - LEAST_SHARE ** n) draws of n points are enough for that. OpenCV's default
# of 2000 cost 18 ms for each picture without the target, in vain; and plain RANSAC, which compares
# all points with every draw, five to twenty times as much as USAC (Raguram et al., PAMI 2013).
DRAWS = {"homography": 205, "affine": 81, "srt": 31}
LEAST_CONTRAST_GREY = 0.5  # E: less is rounding alone
WINDOW_PX = (15, 15)  # E: around a point
LEVELS = 3  # E: of the pyramid, beyond the picture itself
# E: at most 10 steps, or one below 0.03 px; 20 and 0.01 px gave the same corners more slowly.
_UNTIL = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 10, 0.03)
Points = NDArray[np.float32]  # (n, 1, 2) [px]


class KltTracker:
    """Lucas-Kanade flow of good features, then RANSAC; from the first picture or from the last."""

    def __init__(
        self, *, warp: str = "homography", klt_points: int = 80, klt_from: str = "first"
    ) -> None:
        self._warp, self._count, self._from_first = warp, klt_points, klt_from == "first"
        self._shape = (0, 0)

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Choose the points inside the corners (4, 2) of a whole picture (H, W)."""
        self._judge = Judge(corners)
        self._shape = image.shape
        self._old = image.copy()
        self._h = np.eye(3)
        self._corners = self._judge.last.copy()
        self._grey = _moments(image)
        mask = np.zeros(image.shape, np.uint8)
        cv2.fillConvexPoly(mask, np.round(corners).astype(np.int32), 255)
        found = cv2.goodFeaturesToTrack(image, self._count, 0.01, 3, mask=mask)
        self._points: Points = np.empty((0, 1, 2), np.float32)
        if found is not None:
            self._points = np.asarray(found, dtype=np.float32)
        self._was = self._points.copy()  # where they were in the old picture

    def window(self) -> Window:
        """Return the whole picture."""
        return 0, 0, self._shape[1], self._shape[0]

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Follow the points into the next picture (H, W)."""
        share, ok = 0.0, False
        if len(self._points) >= LEAST_POINTS:
            image = self._like_first(image)
            h, now, inliers = self._follow(image)
            share = float(inliers.mean())
            ok = int(inliers.sum()) >= LEAST_POINTS and share >= LEAST_SHARE
            ok = ok and self._judge.believes(_mapped(h, self._corners))
            if ok:
                self._take_over(h, now, inliers.astype(bool), image)
        return Track(self._judge.last.copy(), ok, 1.0 - share, 1)

    def _take_over(
        self,
        h: NDArray[np.float64],
        now: Points,
        keep: NDArray[np.bool_],
        image: NDArray[np.uint8],
    ) -> None:
        """Start the next search from here; also the flow, if it is from the picture before."""
        self._h = h
        if not self._from_first:
            self._points, self._was = self._points[keep], now[keep]
            self._old = image

    def _like_first(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the picture with the first one's mean and contrast.

        The flow takes a point's grey for constant. In water of optical depth 3, with the first
        picture from clear water, no point was found without this and nine of ten are with it.
        Both are of the whole picture: of the target's last place they would change as it moves.
        """
        mean, deviation = _moments(image)
        gain = self._grey[1] / max(deviation, LEAST_CONTRAST_GREY)
        greys = np.clip(np.round((np.arange(256) - mean) * gain + self._grey[0]), 0, 255)
        return np.asarray(cv2.LUT(image, greys.astype(np.uint8)), dtype=np.uint8)

    def _follow(
        self, image: NDArray[np.uint8]
    ) -> tuple[NDArray[np.float64], Points, NDArray[np.int64]]:
        """Return the new warp, where the points are now, and which of them agree with it."""
        guess = _mapped(self._h, self._points).astype(np.float32).reshape(-1, 1, 2)
        none = np.empty(0, np.uint8)
        flow = (none, none, WINDOW_PX, LEVELS, _UNTIL, cv2.OPTFLOW_USE_INITIAL_FLOW)
        found = cv2.calcOpticalFlowPyrLK(self._old, image, self._was, guess.copy(), *flow)
        now, status = np.asarray(found[0], np.float32), np.asarray(found[1])
        good = status.ravel().astype(bool) & np.isfinite(now).all(axis=(1, 2))
        inliers = np.zeros(len(good), np.int64)
        if good.sum() >= LEAST_POINTS:
            h, mask = self._fit(self._points[good], now[good])
            if h is not None and np.isfinite(h).all():
                inliers[good] = mask.ravel()
                return h, now, inliers
        return self._h, now, inliers

    def _fit(
        self, old: Points, new: Points
    ) -> tuple[NDArray[np.float64] | None, NDArray[np.int64]]:
        """Return the warp (3, 3) from the first picture to this one, and who agrees."""
        found: Sequence[Any]
        draws = DRAWS[self._warp]
        if self._warp == "homography":
            found = cv2.findHomography(old, new, cv2.USAC_FAST, AGREES_PX, None, draws, SURE)
        elif self._warp == "affine":
            found = cv2.estimateAffine2D(old, new, None, cv2.USAC_FAST, AGREES_PX, draws, SURE)
        else:  # OpenCV has no other way for this warp
            found = cv2.estimateAffinePartial2D(old, new, None, cv2.RANSAC, AGREES_PX, draws, SURE)
        h, mask = found
        if h is None:
            return None, np.zeros(len(old), np.int64)
        return np.vstack([h, np.eye(3)[len(h) :]]), np.asarray(mask, dtype=np.int64)


def _moments(image: NDArray[np.uint8]) -> tuple[float, float]:
    """Return mean and standard deviation [grey] of a picture."""
    mean, deviation = cv2.meanStdDev(image)
    return float(mean[0, 0]), float(deviation[0, 0])


def _mapped(h: NDArray[np.float64], points: NDArray[np.generic]) -> NDArray[np.float64]:
    """Return the images (n, 2) of points (n, 2) or (n, 1, 2)."""
    flat = points.reshape(-1, 2).astype(np.float64)
    x, y = flat[:, 0], flat[:, 1]
    u, v, w = (row[0] * x + row[1] * y + row[2] for row in h)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.stack([u / w, v / w], axis=-1)
