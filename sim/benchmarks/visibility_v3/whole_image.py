"""Marks of visibility-v3 that look at the whole image: they follow the bottom, not the target.

In visibility-v2 the target stood on the bottom, and both held more turbid water than any tracker of
the target alone: the whole image has thirty times its pixels.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from seamark.sim.trackers import Track, Window
from seamark.sim.trackers.interface import Corners
from seamark.sim.trackers.mosse.filter import RATE, REGULARISATION, SMALLEST_RATIO
from seamark.sim.trackers.mosse.tracker import PEAK_SIGMA_PX
from seamark.sim.trackers.subpixel import peak_offset

MARGIN = 4  # a quarter of the image on each side is left for motion
LOWEST_CORRELATION = 0.05  # E: chance reaches 0.03 on 19 200 pixels of noise


class WholeImageMatch:
    """Finds the middle of the first image in each image, and moves the corners with it."""

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Keep the middle of the image (H, W)."""
        height, width = image.shape
        self._shape, self._at = image.shape, np.array([width // MARGIN, height // MARGIN])
        self._middle = image[self._at[1] : -self._at[1], self._at[0] : -self._at[0]].copy()
        self._start, self._last = corners.copy(), corners.copy()

    def window(self) -> Window:
        """Return the whole image."""
        return 0, 0, self._shape[1], self._shape[0]

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Return the corners where the middle of the first image is."""
        found = cv2.matchTemplate(image, self._middle, cv2.TM_CCOEFF_NORMED)
        scores = np.nan_to_num(np.asarray(found, dtype=np.float64))
        row, column = (int(at) for at in np.unravel_index(int(scores.argmax()), scores.shape))
        peak = float(scores[row, column])
        ok = peak > LOWEST_CORRELATION
        if ok:
            finer = peak_offset(scores[row], column), peak_offset(scores[:, column], row)
            self._last = self._start + np.array([column, row]) + finer - self._at
        return Track(self._last.copy(), ok, 1.0 - peak, 1)


class WholeImageFilter:
    """A correlation filter that learns the whole image, as `mosse` does a box, and moves with it.

    The response to the next image has its peak where the image has moved to (Bolme et al., CVPR
    2010); how far that stands out from the rest tells a loss.
    """

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Learn the image (H, W)."""
        height, width = self._shape = image.shape
        self._start, self._last = corners.copy(), corners.copy()
        self._taper = np.outer(np.hanning(height), np.hanning(width))
        rows, columns = np.fft.fftfreq(height), np.fft.rfftfreq(width)
        self._frequencies = rows[:, None], columns[None]
        squared = rows[:, None] ** 2 + columns[None] ** 2
        self._goal = np.exp(-2.0 * (np.pi * PEAK_SIGMA_PX) ** 2 * squared)
        seen = self._transformed(image)
        self._numerator, self._energy = self._goal * seen.conj(), np.abs(seen) ** 2

    def window(self) -> Window:
        """Return the whole image."""
        return 0, 0, self._shape[1], self._shape[0]

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Return the corners, moved with the image (H, W); learn it if the peak is clear."""
        seen = self._transformed(image)
        least = REGULARISATION * float(self._energy.mean())
        response = np.fft.irfft2(self._numerator / (self._energy + least) * seen, self._shape)
        middle = np.array(self._shape) // 2
        response = np.roll(response, tuple(middle), (0, 1))
        row, column = (int(at) for at in np.unravel_index(int(response.argmax()), self._shape))
        peak = float(response[row, column]) - float(response.mean())
        ok = peak > SMALLEST_RATIO * float(response.std())
        if ok:
            down = row + peak_offset(response[:, column], row) - middle[0]
            right = column + peak_offset(response[row], column) - middle[1]
            self._last = self._start + np.array([right, down])
            turns = down * self._frequencies[0] + right * self._frequencies[1]
            back = seen * np.exp(2j * np.pi * turns)
            self._numerator += RATE * (self._goal * back.conj() - self._numerator)
            self._energy += RATE * (np.abs(back) ** 2 - self._energy)
        return Track(self._last.copy(), ok, 0.0 if ok else 1.0, 1)

    def _transformed(self, image: NDArray[np.uint8]) -> NDArray[np.complex128]:
        grey = np.log(1.0 + image)
        return np.fft.rfft2((grey - grey.mean()) / max(float(grey.std()), 1e-6) * self._taper)
