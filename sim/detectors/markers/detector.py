"""`markers`: OpenCV finds squares and reads their code; the plate is larger than the code.

OpenCV's part works on whole numbers: thresholds, contours, and corners that are pixels of the
contour. What follows is our own arithmetic, so that no result depends on the processor.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from seamark.sim.detectors.interface import Corners, Detection, Image, grey, most_confident

# Both as the painter draws them: the plate has a white margin of one module around the black one.
_DICTIONARIES = {"aruco": cv2.aruco.DICT_4X4_50, "apriltag": cv2.aruco.DICT_APRILTAG_36h11}
_LABELS = tuple(_DICTIONARIES)
_HALF_PX = 0.5  # D: from the centre of a contour's pixel to the edge of the black
_ENDS = 0.02  # share of the pixels that are black or white after stretching, E
_LEAST_SPREAD = 6  # [grey] E: an image with less between its ends shows nothing but noise
_SMALLEST = 0.03  # OpenCV's default: perimeter in longer sides of the image


class MarkerDetector:
    """Reads ArUco markers and AprilTags."""

    def __init__(self, *, marker_stretch: bool = True) -> None:
        self._stretch = marker_stretch
        books = [cv2.aruco.getPredefinedDictionary(each) for each in _DICTIONARIES.values()]
        self._modules = [int(book.markerSize) + 2 for book in books]
        self._codes = [
            [_code(book, number, side) for number in range(len(book.bytesList))]
            for book, side in zip(books, self._modules, strict=True)
        ]
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_NONE  # not the same everywhere
        parameters.minMarkerPerimeterRate = _SMALLEST
        self._reader = cv2.aruco.ArucoDetector(books, parameters)

    def detect(self, image: Image) -> list[Detection]:
        """Return the markers of an image."""
        seen = grey(image)
        if self._stretch:
            seen = _stretched(seen)
        squares, numbers, _, books = self._reader.detectMarkersMultiDict(seen)
        if numbers is None:
            return []
        found = []
        for square, number, book in zip(
            squares, map(int, numbers.ravel()), map(int, books.ravel()), strict=True
        ):
            side = self._modules[book]
            inner = _grown(np.asarray(square, np.float64).reshape(4, 2))
            centres = _mapped(inner, _grid(side))
            agreement = _agreement(seen, centres, self._codes[book][number])
            plate = _mapped(
                inner,
                np.array([[-1, -1], [side + 1, -1], [side + 1, side + 1], [-1, side + 1]]) / side,
            )
            found.append(Detection(_LABELS[book], plate, max(agreement, 0.0)))
        return most_confident(found)


def _code(book: cv2.aruco.Dictionary, number: int, side: int) -> NDArray[np.int64]:
    """Return the modules of a marker (side * side,) with its black border; 1 is white."""
    drawn = np.asarray(book.generateImageMarker(number, side, borderBits=1))
    return (drawn > 127).astype(np.int64).ravel()


def _stretched(image: Image) -> Image:
    """Return an image whose greys reach from black to white, in whole numbers."""
    below = np.cumsum(np.bincount(image.ravel(), minlength=256))
    low = int(np.searchsorted(below, _ENDS * image.size))
    high = int(np.searchsorted(below, (1.0 - _ENDS) * image.size))
    if high - low < _LEAST_SPREAD:
        return image
    greys = np.clip((np.arange(256) - low) * 255 // (high - low), 0, 255)
    return greys.astype(np.uint8)[image]


def _grown(square: Corners) -> Corners:
    """Return corners that lie on the edge of the black, not on its outermost pixels."""
    middle = square.mean(axis=0)
    off = square - middle
    return np.asarray(square + _HALF_PX * np.sign(off))


def _grid(side: int) -> NDArray[np.float64]:
    """Return the middles of all modules, row by row, in the unit square of the code."""
    at = (np.arange(side) + 0.5) / side
    return np.stack([np.tile(at, side), np.repeat(at, side)], axis=1)


def _mapped(square: Corners, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where points (n, 2) of the unit square are in an image that shows it as `square`.

    The projective map of a square to a quadrilateral in closed form (Heckbert 1989).
    """
    (x0, y0), (x1, y1), (x2, y2), (x3, y3) = square.tolist()
    sx, sy = x0 - x1 + x2 - x3, y0 - y1 + y2 - y3
    dx1, dy1, dx2, dy2 = x1 - x2, y1 - y2, x3 - x2, y3 - y2
    below = dx1 * dy2 - dx2 * dy1
    g, h = (sx * dy2 - dx2 * sy) / below, (dx1 * sy - sx * dy1) / below
    u, v = points[:, 0], points[:, 1]
    scale = g * u + h * v + 1.0
    x = ((x1 - x0 + g * x1) * u + (x3 - x0 + h * x3) * v + x0) / scale
    y = ((y1 - y0 + g * y1) * u + (y3 - y0 + h * y3) * v + y0) / scale
    return np.stack([x, y], axis=1)


def _agreement(image: Image, centres: NDArray[np.float64], code: NDArray[np.int64]) -> float:
    """Return the correlation of the pixels at the modules' middles with the code."""
    height, width = image.shape
    columns = np.clip(np.floor(centres[:, 0] + 0.5), 0, width - 1).astype(np.int64)
    rows = np.clip(np.floor(centres[:, 1] + 0.5), 0, height - 1).astype(np.int64)
    greys, n = image[rows, columns].astype(np.int64), len(code)
    common = n * int((greys * code).sum()) - int(greys.sum()) * int(code.sum())
    spread = n * int((greys * greys).sum()) - int(greys.sum()) ** 2
    ones = n * int(code.sum()) - int(code.sum()) ** 2
    return float(common / max(spread * ones, 1) ** 0.5)
