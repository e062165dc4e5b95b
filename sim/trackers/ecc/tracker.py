"""`ecc`: OpenCV's enhanced correlation coefficient (Evangelidis & Psarakis, PAMI 2008).

Set up to make the comparison with the template tracker fair: only the target's face counts as the
template (surroundings lie in another plane and biased the corners by 1 px), and the search starts
where the target is predicted from its last motion, at coarser resolutions first. Without these it
is lost at 4 to 6 px per image.
"""

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from seamark.sim.trackers.interface import Corners, Track, Window
from seamark.sim.trackers.options import LARGEST_JUMP
from seamark.sim.trackers.plausibility import PlausibilityGate

LOWEST_CORRELATION = 0.5  # E: as for the template tracker
SMOOTHING = 3  # [px] width of the Gaussian that OpenCV applies to both images
INSET_PX = 2  # E: pixels at the rim mix target and surroundings
SURROUNDINGS_PX = 4  # E: included on the coarse level
MAX_LEVELS = 2  # E: a third one did not help in fast motion and took 50 % longer
MIN_ROWS = 8  # E: of a level; fewer do not show the target
MIN_FACE_PX = 16  # E: of a side; a smaller target keeps its rim
STOP = 1e-3  # E: change of the correlation; 1e-4 gave the same errors
_MOTIONS = {
    "translation": cv2.MOTION_TRANSLATION,
    "rt": cv2.MOTION_EUCLIDEAN,
    "affine": cv2.MOTION_AFFINE,
    "homography": cv2.MOTION_HOMOGRAPHY,
}
# From pixel coordinates to those of an image of half the size.
_HALF = np.array([[0.5, 0.0, -0.25], [0.0, 0.5, -0.25], [0.0, 0.0, 1.0]])
_DOUBLE = np.array([[2.0, 0.0, 0.5], [0.0, 2.0, 0.5], [0.0, 0.0, 1.0]])
Image = NDArray[np.uint8]
Matrix = NDArray[np.float64]  # (3, 3)


class _PyramidLevel(NamedTuple):
    """The template at one resolution."""

    template: Image
    face: Image  # mask: 255 where the template shows the target
    everywhere: Image  # (H, W) mask that includes all pixels


class EccTracker:
    """Aligns the target's face in the first image with each following image."""

    def __init__(
        self,
        *,
        warp: str = "homography",
        ecc_iterations: int = 20,
        predict_motion: bool = True,
        max_jump: float = LARGEST_JUMP,
    ) -> None:
        self._max_jump = max_jump
        self._motion, self._predict = _MOTIONS[warp], predict_motion
        self._until = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, ecc_iterations, STOP)
        self._shape = (0, 0)

    def start(self, image: Image, corners: Corners) -> None:
        """Extract the box around the corners (4, 2) from a whole image (H, W)."""
        self._gate = PlausibilityGate(corners, max_jump=self._max_jump)
        self._shape = image.shape
        height, width = image.shape
        low = np.floor(corners.min(axis=0)) - SURROUNDINGS_PX
        high = np.ceil(corners.max(axis=0)) + SURROUNDINGS_PX
        x0, y0 = (int(max(value, 0)) // 2 * 2 for value in low)
        x1, y1 = int(min(high[0], width)), int(min(high[1], height))
        if min(x1 - x0, y1 - y0) < 2 * SMOOTHING:
            raise ValueError("the target is too small or outside the image")
        template = image[y0:y1, x0:x1].copy()
        self._corners = self._gate.last - (x0, y0)
        face = _face(template.shape, self._corners)
        # The surroundings help from a distance; the finest level removes the bias they cause.
        self._levels = [_PyramidLevel(template, face, np.full(image.shape, 255, np.uint8))]
        while len(self._levels) < MAX_LEVELS and min(template.shape) >= 2 * MIN_ROWS:
            template = _halve(template)
            whole = np.full(template.shape, 255, np.uint8)
            self._levels.append(_PyramidLevel(template, whole, _halve(self._levels[-1].everywhere)))
        self._homography = np.eye(3)
        self._homography[:2, 2] = x0, y0
        self._previous_homography = self._homography.copy()

    def window(self) -> Window:
        """Return the whole image."""
        return 0, 0, self._shape[1], self._shape[0]

    def update(self, image: Image) -> Track:
        """Align the template with the next image (H, W), starting from the predicted position."""
        expected = self._homography
        if self._predict:
            expected = _normalise(
                self._homography @ np.linalg.inv(self._previous_homography) @ self._homography
            )
        images = [image]
        for _ in self._levels[1:]:
            images.append(_halve(images[-1]))
            expected = _HALF @ expected @ _DOUBLE
        similarity, h = 0.0, expected
        for k in range(len(images) - 1, -1, -1):
            similarity, h = self._align(self._levels[k], images[k], h)
            if k > 0:
                h = _DOUBLE @ h @ _HALF
        ok = False
        if similarity >= LOWEST_CORRELATION:
            points = self._corners @ h[:, :2].T + h[:, 2]
            ok = self._gate.accept(points[:, :2] / points[:, 2:])
        # A lost target is predicted to stand still.
        self._previous_homography, self._homography = (
            (self._homography, h) if ok else (self._homography, self._homography)
        )
        return Track(self._gate.last.copy(), ok, 1.0 - similarity, 1)

    def _align(self, level: _PyramidLevel, image: Image, start: Matrix) -> tuple[float, Matrix]:
        """Return correlation and warp (3, 3); 0 and the start if OpenCV finds none."""
        rows = 3 if self._motion == cv2.MOTION_HOMOGRAPHY else 2
        first = _normalise(start)[:rows].astype(np.float32)
        settings = (self._motion, self._until, SMOOTHING)
        try:
            similarity, warp = cv2.findTransformECCWithMask(
                level.template, image, level.face, level.everywhere, first, *settings
            )
        except cv2.error:  # raised if it does not converge
            return 0.0, start
        if not (similarity >= LOWEST_CORRELATION and np.isfinite(warp).all()):
            return 0.0, start
        h = np.eye(3)
        h[:rows] = warp
        return float(similarity), h


def _face(shape: tuple[int, ...], corners: Corners) -> Image:
    """Return a mask (H, W): 255 on the target's face without its rim."""
    face = np.zeros(shape, np.uint8)
    cv2.fillConvexPoly(face, np.round(corners).astype(np.int32), 255)
    if min(shape) < MIN_FACE_PX:
        return face
    side = 2 * INSET_PX + 1
    inner = cv2.erode(face, np.ones((side, side), np.uint8), borderValue=0)
    return np.asarray(inner, dtype=np.uint8)


def _halve(image: Image) -> Image:
    """Return means of 2x2 pixels; an odd last row or column is dropped."""
    height, width = image.shape
    even = image[: height // 2 * 2, : width // 2 * 2]
    small = cv2.resize(even, (width // 2, height // 2), interpolation=cv2.INTER_AREA)
    return np.asarray(small, dtype=np.uint8)


def _normalise(h: Matrix) -> Matrix:
    return np.asarray(h / h[2, 2], dtype=np.float64)
