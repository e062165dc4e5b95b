"""A two-step template tracker as a starting point.

It first searches around the last position by normalised cross-correlation in a downsampled image,
then refines an affine warp by inverse compositional alignment (Baker and Matthews, IJCV 56, 2004).
Both steps are invariant to brightness and contrast, since turbid water reduces the contrast.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

REACH = 8  # search radius of the first step, in pixels of the downsampled image
POINTS = 1000  # maximum number of template pixels in the second step
ITERATIONS = 10
SIMILAR = 0.35  # minimum correlation at which the target counts as found


class Tracker:
    def __init__(self, config):
        # config: the configuration of the run, without the seed of the trial
        pass

    def start(self, image, corners):
        # called at the start of each level with an image (height, width), 0 to 255, and the
        # corners (4, 2) of the target: upper left, upper right, lower right, lower left
        centre = corners.mean(axis=0)
        low, high = np.ceil(corners.min(axis=0)), np.floor(corners.max(axis=0))
        pitch = max(1.0, np.sqrt(np.prod(high - low) / POINTS))
        x, y = np.meshgrid(np.arange(low[0], high[0], pitch), np.arange(low[1], high[1], pitch))
        self.x, self.y = x.ravel() - centre[0], y.ravel() - centre[1]
        self.corners = corners - centre
        self.warp = np.array([[1.0, 0.0, centre[0]], [0.0, 1.0, centre[1]]])
        image = image.astype(float)
        patch = sample(image, self.warp, self.x, self.y)
        gx = sample(image, self.warp, self.x + 0.5, self.y) - sample(
            image, self.warp, self.x - 0.5, self.y
        )
        gy = sample(image, self.warp, self.x, self.y + 0.5) - sample(
            image, self.warp, self.x, self.y - 0.5
        )
        slopes = np.stack([gx * self.x, gx * self.y, gx, gy * self.x, gy * self.y, gy], axis=1)
        self.patch = normalised(patch)
        self.inverse = np.linalg.pinv((slopes - slopes.mean(axis=0)) / patch.std())
        # For the first step: a small upright image of the target, and its centre.
        self.scale = max(2, round(2 * pitch))
        first, last = (low / self.scale).astype(int), (high / self.scale).astype(int)
        small = shrunk(image, self.scale)[first[1] : last[1], first[0] : last[0]]
        self.size, self.small = small.shape, normalised(small.ravel())
        self.offset = first - centre / self.scale

    def update(self, image):
        # called with each following image, 20 per simulated second; returns the corners, or
        # None if the target is lost
        image = image.astype(float)
        warp = self.warp.copy()
        warp[:, 2] += self.search(shrunk(image, self.scale), warp[:, 2])
        for _ in range(ITERATIONS):
            patch = normalised(sample(image, warp, self.x, self.y))
            a, b, tx, c, d, ty = self.inverse @ (patch - self.patch)
            step = np.array([[1 + a, b, tx], [c, 1 + d, ty], [0, 0, 1]])
            warp = warp @ np.linalg.inv(step)
            if abs(tx) + abs(ty) < 0.01:
                break
        correlation = float(self.patch @ patch) / len(patch)
        if correlation < SIMILAR or not 0.5 < np.linalg.det(warp[:, :2]) < 2:
            return None
        self.warp = warp
        return self.corners @ warp[:, :2].T + warp[:, 2]

    def search(self, small, centre):
        """Return the displacement of the target [px]."""
        height, width = self.size
        column, row = np.round(centre / self.scale + self.offset).astype(int) - REACH
        column = min(max(column, 0), small.shape[1] - width - 2 * REACH)
        row = min(max(row, 0), small.shape[0] - height - 2 * REACH)
        near = small[row : row + height + 2 * REACH, column : column + width + 2 * REACH]
        views = sliding_window_view(near, (height, width)).reshape(-1, height * width)
        variance = (views * views).mean(axis=1) - views.mean(axis=1) ** 2
        likeness = (views @ self.small) / np.sqrt(np.maximum(variance, 1e-9))
        best = np.unravel_index(likeness.argmax(), (2 * REACH + 1, 2 * REACH + 1))
        position = np.array([column + best[1], row + best[0]])
        return self.scale * (position - self.offset) - centre


def normalised(patch):
    return (patch - patch.mean()) / (patch.std() + 1e-9)


def shrunk(image, scale):
    """Return the downsampled image: means of `scale` by `scale` pixels."""
    height, width = (side // scale for side in image.shape)
    blocks = image[: height * scale, : width * scale].reshape(height, scale, width, scale)
    return blocks.mean(axis=(1, 3))


def sample(image, warp, x, y):
    """Return the image interpolated at the warped points."""
    height, width = image.shape
    u = np.clip(warp[0, 0] * x + warp[0, 1] * y + warp[0, 2], 0, width - 1.001)
    v = np.clip(warp[1, 0] * x + warp[1, 1] * y + warp[1, 2], 0, height - 1.001)
    column, row = u.astype(int), v.astype(int)
    u, v = u - column, v - row
    upper = image[row, column] * (1 - u) + image[row, column + 1] * u
    lower = image[row + 1, column] * (1 - u) + image[row + 1, column + 1] * u
    return upper * (1 - v) + lower * v
