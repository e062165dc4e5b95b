"""`klt`: sparse optical flow of corners, and a robust fit of the warp (OpenCV)."""

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from seamark.sim.trackers.interface import Corners, Track, Window
from seamark.sim.trackers.options import LARGEST_JUMP
from seamark.sim.trackers.plausibility import PlausibilityGate

MIN_POINTS = 8  # E: among fewer, four outliers can outvote the rest
MIN_INLIER_SHARE = 0.4  # E: below it the agreement is chance
INLIER_PX = 2.0  # E: largest residual of an inlier
CONFIDENCE = 0.995  # E: that RANSAC draws inliers alone at least once
# D: ln(1 - CONFIDENCE) / ln(1 - MIN_INLIER_SHARE ** n) draws of n points are enough. OpenCV's
# default of 2000 takes 18 ms for each image without the target; plain RANSAC, which compares all
# points with every draw, takes 5 to 20 times as long as USAC (Raguram et al., PAMI 2013).
MAX_DRAWS = {"homography": 205, "affine": 81, "srt": 31}
MIN_CONTRAST_GREY = 0.5  # E: below it there is only rounding
WINDOW_PX = (15, 15)  # E: around a point
PYRAMID_LEVELS = 3  # E: above the image itself
# E: at most 10 iterations, or a step below 0.03 px; 20 and 0.01 px gave the same corners.
_UNTIL = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 10, 0.03)
Points = NDArray[np.float32]  # (n, 1, 2) [px]


class KltTracker:
    """Lucas-Kanade flow of good features, then RANSAC; from the first or the previous image."""

    def __init__(
        self,
        *,
        warp: str = "homography",
        klt_points: int = 80,
        klt_from: str = "first",
        max_jump: float = LARGEST_JUMP,
    ) -> None:
        self._max_jump = max_jump
        self._warp, self._max_points, self._from_first = warp, klt_points, klt_from == "first"
        self._shape = (0, 0)

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Choose the points inside the corners (4, 2) of a whole image (H, W)."""
        self._gate = PlausibilityGate(corners, max_jump=self._max_jump)
        self._shape = image.shape
        self._old = image.copy()
        self._h = np.eye(3)
        self._corners = self._gate.last.copy()
        self._grey = _moments(image)
        mask = np.zeros(image.shape, np.uint8)
        cv2.fillConvexPoly(mask, np.round(corners).astype(np.int32), 255)
        features = cv2.goodFeaturesToTrack(image, self._max_points, 0.01, 3, mask=mask)
        self._points: Points = np.empty((0, 1, 2), np.float32)
        if features is not None:
            self._points = np.asarray(features, dtype=np.float32)
        self._reference_points = self._points.copy()  # in the image that the flow starts from

    def window(self) -> Window:
        """Return the whole image."""
        return 0, 0, self._shape[1], self._shape[0]

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Track the points into the next image (H, W)."""
        share, ok = 0.0, False
        if len(self._points) >= MIN_POINTS:
            image = self._match_first_image(image)
            h, now, inliers = self._fit_flow(image)
            share = float(inliers.mean())
            ok = int(inliers.sum()) >= MIN_POINTS and share >= MIN_INLIER_SHARE
            ok = ok and self._gate.accept(_mapped(h, self._corners))
            if ok:
                self._accept(h, now, inliers.astype(bool), image)
        return Track(self._gate.last.copy(), ok, 1.0 - share, 1)

    def _accept(
        self,
        h: NDArray[np.float64],
        now: Points,
        keep: NDArray[np.bool_],
        image: NDArray[np.uint8],
    ) -> None:
        """Start the next search here; and the flow, if it is from the previous image."""
        self._h = h
        if not self._from_first:
            self._points, self._reference_points = self._points[keep], now[keep]
            self._old = image

    def _match_first_image(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the image with the mean and the contrast of the first one.

        Optical flow assumes constant brightness. In water of optical depth 3, with the first image
        from clear water, no point is found without this and nine of ten are found with it. Both
        are of the whole image: those of the target's region would change as it moves.
        """
        mean, deviation = _moments(image)
        gain = self._grey[1] / max(deviation, MIN_CONTRAST_GREY)
        greys = np.clip(np.round((np.arange(256) - mean) * gain + self._grey[0]), 0, 255)
        return np.asarray(cv2.LUT(image, greys.astype(np.uint8)), dtype=np.uint8)

    def _fit_flow(
        self, image: NDArray[np.uint8]
    ) -> tuple[NDArray[np.float64], Points, NDArray[np.int64]]:
        """Return the new warp, the present points, and which of them are inliers."""
        guess = _mapped(self._h, self._points).astype(np.float32).reshape(-1, 1, 2)
        none = np.empty(0, np.uint8)
        flow = (none, none, WINDOW_PX, PYRAMID_LEVELS, _UNTIL, cv2.OPTFLOW_USE_INITIAL_FLOW)
        ends = cv2.calcOpticalFlowPyrLK(
            self._old, image, self._reference_points, guess.copy(), *flow
        )
        now, status = np.asarray(ends[0], np.float32), np.asarray(ends[1])
        good = status.ravel().astype(bool) & np.isfinite(now).all(axis=(1, 2))
        inliers = np.zeros(len(good), np.int64)
        if good.sum() >= MIN_POINTS:
            h, mask = self._fit(self._points[good], now[good])
            if h is not None and np.isfinite(h).all():
                inliers[good] = mask.ravel()
                return h, now, inliers
        return self._h, now, inliers

    def _fit(
        self, old: Points, new: Points
    ) -> tuple[NDArray[np.float64] | None, NDArray[np.int64]]:
        """Return the warp (3, 3) from the first image to this one, and its inliers."""
        fit: Sequence[Any]
        draws = MAX_DRAWS[self._warp]
        if self._warp == "homography":
            fit = cv2.findHomography(old, new, cv2.USAC_FAST, INLIER_PX, None, draws, CONFIDENCE)
        elif self._warp == "affine":
            fit = cv2.estimateAffine2D(old, new, None, cv2.USAC_FAST, INLIER_PX, draws, CONFIDENCE)
        else:  # OpenCV has no USAC for this warp
            fit = cv2.estimateAffinePartial2D(
                old, new, None, cv2.RANSAC, INLIER_PX, draws, CONFIDENCE
            )
        h, mask = fit
        if h is None:
            return None, np.zeros(len(old), np.int64)
        return np.vstack([h, np.eye(3)[len(h) :]]), np.asarray(mask, dtype=np.int64)


def _moments(image: NDArray[np.uint8]) -> tuple[float, float]:
    """Return mean and standard deviation [grey] of an image."""
    mean, deviation = cv2.meanStdDev(image)
    return float(mean[0, 0]), float(deviation[0, 0])


def _mapped(h: NDArray[np.float64], points: NDArray[np.generic]) -> NDArray[np.float64]:
    """Return the images (n, 2) of points (n, 2) or (n, 1, 2)."""
    flat = points.reshape(-1, 2).astype(np.float64)
    x, y = flat[:, 0], flat[:, 1]
    u, v, w = (row[0] * x + row[1] * y + row[2] for row in h)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.stack([u / w, v / w], axis=-1)
