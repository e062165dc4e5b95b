"""The tracker of c_family/starter/tracker.c and tracker.cpp in Python."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

POINTS, REACH = 1200, 8


class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        height, width = image.shape
        low, high = np.ceil(corners.min(axis=0)), np.floor(corners.max(axis=0))
        self.left, self.top = max(int(low[0]), 0), max(int(low[1]), 0)
        width = min(int(high[0]), width - 1) - self.left
        height = min(int(high[1]), height - 1) - self.top
        self.pitch = 1
        while width // self.pitch * (height // self.pitch) > POINTS:
            self.pitch += 1
        self.columns, self.rows = width // self.pitch, height // self.pitch
        self.patch = self.grids(image, self.left, self.top, 1)[0, 0]
        self.contrast = np.abs(self.patch).sum()
        self.corners = corners.copy()

    def update(self, image):
        height, width = image.shape
        x = range(
            max(self.left - REACH, 0),
            min(self.left + REACH, width - self.columns * self.pitch) + 1,
        )
        y = range(
            max(self.top - REACH, 0),
            min(self.top + REACH, height - self.rows * self.pitch) + 1,
        )
        if not x or not y:
            return None
        seen = self.grids(image, x[0], y[0], max(len(x), len(y)))[: len(y), : len(x)]
        difference = np.abs(seen - self.patch).sum(axis=2)
        row, column = np.unravel_index(difference.argmin(), difference.shape)
        if 10 * difference[row, column] > 9 * self.contrast:
            return None
        self.corners += [x[column] - self.left, y[row] - self.top]
        self.left, self.top = x[column], y[row]
        return self.corners

    def grids(self, image, left, top, positions):
        """Return the pixels of the grid at adjacent positions: (rows, columns, pixels)."""
        size = (self.rows * self.pitch, self.columns * self.pitch)
        near = image[top : top + size[0] + positions - 1, left : left + size[1] + positions - 1]
        views = sliding_window_view(near, size)[..., :: self.pitch, :: self.pitch]
        pixels = views.reshape(*views.shape[:2], -1).astype(np.int64)
        return pixels.shape[2] * pixels - pixels.sum(axis=2, keepdims=True)
