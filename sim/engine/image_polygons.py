"""What is seen of quadrilaterals in an image, in px from its upper left corner."""

import cv2
import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]  # (n, 2) [px]
CORNER = 0.5  # [px] from the corner of a pixel to its centre: what Seamark's own points lack
_LEAST_AREA = 1.0  # [px²] of what counts as seen


def seen_part(corners: Points, size: tuple[int, int]) -> Points | None:
    """Return the polygon of four corners that is inside of an image; None if none is.

    Parameters
    ----------
    size
        Width and height of the image [px].
    """
    if not np.isfinite(corners).all():
        return None
    if whole(corners, size):
        return corners
    width, height = size
    image = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
    area, polygon = cv2.intersectConvexConvex(corners.astype(np.float32), image)
    if area < _LEAST_AREA or polygon is None:
        return None
    points: Points = np.clip(polygon.reshape(-1, 2).astype(np.float64), 0.0, size)
    return points


def whole(corners: Points, size: tuple[int, int]) -> bool:
    """Return whether all corners are inside of an image of this width and height."""
    return bool(((corners >= 0.0) & (corners <= size)).all())


def upright(points: Points) -> Points:
    """Return the corners (4, 2) of the upright box around points, clockwise from upper left."""
    (left, upper), (right, lower) = points.min(axis=0), points.max(axis=0)
    return np.array([[left, upper], [right, upper], [right, lower], [left, lower]])


def coco_box(points: Points) -> list[float]:
    """Return left, top, width and height of the upright box around points."""
    (left, upper), (right, lower) = points.min(axis=0), points.max(axis=0)
    return [float(one) for one in (left, upper, right - left, lower - upper)]


def coco_key_points(corners: Points, size: tuple[int, int]) -> list[list[float]]:
    """Return x, y and visibility of corners as COCO has them: 0 outside of the image, else 2."""
    width, height = size
    return [
        [float(u), float(v), 2] if 0 <= u <= width and 0 <= v <= height else [0, 0, 0]
        for u, v in corners
    ]


def area(polygon: Points) -> float:
    """Return the area by the shoelace formula [px²]."""
    u, v = polygon.T
    return float(0.5 * abs(np.dot(u, np.roll(v, -1)) - np.dot(v, np.roll(u, -1))))
