"""The image as a fan, as people look at it: ahead is up, starboard is right."""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from seamark.sim.sonar.device import SECTOR_RAD, Device

# From dark water over copper to white, as operators of imaging sonars have it: blue, green, red.
_STOPS = ((0, (26, 16, 8)), (64, (30, 70, 140)), (144, (60, 150, 235)), (255, (215, 245, 255)))
_OUTSIDE = (18, 12, 10)


def fan_shape(height: int) -> tuple[int, int]:
    """Return height and width [px] of a fan as high as this."""
    return height, 2 * math.ceil(height * math.sin(0.5 * SECTOR_RAD)) + 1


def to_fan(image: NDArray[np.uint8], device: Device, *, height: int) -> NDArray[np.uint8]:
    """Return an image (bins, beams) as a fan (H, W); 0 outside.

    The sonar is in the middle of the lower edge, its range from there to the upper one.
    """
    if image.shape != (device.bins, device.beams):
        raise ValueError(f"an image of this sonar is not {image.shape[0]} x {image.shape[1]}")
    inside, at, shares = _lookup(device.bins, device.beams, height)
    row, column = at
    down, right = shares
    values = image.astype(np.float32)
    below = np.minimum(row + 1, device.bins - 1)
    beside = np.minimum(column + 1, device.beams - 1)
    near = values[row, column] + right * (values[row, beside] - values[row, column])
    far = values[below, column] + right * (values[below, beside] - values[below, column])
    fan = np.zeros(inside.shape, np.uint8)
    fan[inside] = (near + down * (far - near) + np.float32(0.5)).astype(np.uint8)
    return fan


def in_colour(image: NDArray[np.uint8], device: Device, *, height: int) -> NDArray[np.uint8]:
    """Return a fan in colour, (H, W, 3) in blue, green, red."""
    table = np.empty((256, 3), np.uint8)
    levels = [level for level, _ in _STOPS]
    for k in range(3):
        shades = [colour[k] for _, colour in _STOPS]
        table[:, k] = np.interp(np.arange(256), levels, shades).round()
    inside, _, _ = _lookup(device.bins, device.beams, height)
    coloured: NDArray[np.uint8] = table[to_fan(image, device, height=height)]
    coloured[~inside] = _OUTSIDE
    return coloured


@lru_cache(maxsize=4)
def _lookup(
    bins: int, beams: int, height: int
) -> tuple[NDArray[np.bool_], NDArray[np.int64], NDArray[np.float32]]:
    """Return which pixels are in the fan, row and column of each (2, n), and shares of the next."""
    rows, columns = fan_shape(height)
    ahead = (rows - 0.5 - np.arange(rows))[:, None] / rows
    aside = (np.arange(columns) - 0.5 * (columns - 1))[None] / rows
    away, azimuth = np.hypot(ahead, aside), np.arctan2(aside, ahead)
    inside = (away < 1.0) & (np.abs(azimuth) < 0.5 * SECTOR_RAD)
    row = np.clip(away[inside] * bins - 0.5, 0.0, bins - 1.0)
    column = np.clip((azimuth[inside] / SECTOR_RAD + 0.5) * beams - 0.5, 0.0, beams - 1.0)
    whole = np.stack([row, column]).astype(np.int64)
    return inside, whole, (np.stack([row, column]) - whole).astype(np.float32)
