"""Images of a sandy bottom with a few things on it whose corners are known, for detectors."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

HEIGHT, WIDTH = 240, 320  # [px]
SAND, BLACK, WHITE = 130.0, 35.0, 210.0  # grey values
SPREAD = 6.0  # standard deviation of the sand's grey values
BOX = (84.0, 27.0)  # [px] length and width
DICTIONARIES = {"aruco": cv2.aruco.DICT_4X4_50, "apriltag": cv2.aruco.DICT_APRILTAG_36h11}

Corners = NDArray[np.float64]
Image = NDArray[np.uint8]


@dataclass(frozen=True)
class Thing:
    """One thing on the bottom."""

    label: str
    corners: Corners  # (4, 2) [px] clockwise


def corners_of(centre: tuple[float, float], size: tuple[float, float], turn: float) -> Corners:
    """Return the corners (4, 2) of a rectangle that is turned by an angle [rad]."""
    length, width = size
    plain = np.array([[-length, -width], [length, -width], [length, width], [-length, width]]) / 2
    along = np.array([np.cos(turn), np.sin(turn)])
    return np.array(centre) + plain @ np.array([along, [-along[1], along[0]]])


def sand(seed: int) -> NDArray[np.float64]:
    """Return an empty bottom, (240, 320)."""
    noise = np.random.default_rng(seed).standard_normal((HEIGHT, WIDTH))
    smooth = cv2.GaussianBlur(noise, (7, 7), 1.5)
    return SAND + SPREAD * smooth / smooth.std()


def with_rectangle(bottom: NDArray[np.float64], corners: Corners, grey: float) -> None:
    cv2.fillConvexPoly(bottom, np.round(16 * corners).astype(np.int32), grey, cv2.LINE_8, 4)


def with_box(
    bottom: NDArray[np.float64], turn: float, centre: tuple[float, float], *, letters: bool = True
) -> Thing:
    """Lay a black box on the bottom; without letters it is a slab."""
    corners = corners_of(centre, BOX, turn)
    with_rectangle(bottom, corners, BLACK)
    along = np.array([np.cos(turn), np.sin(turn)])
    for at in (-24.0, -8.0, 8.0, 24.0) if letters else ():
        x, y = centre + at * along
        with_rectangle(bottom, corners_of((x, y), (4.0, 12.0), turn), WHITE)
    return Thing("box" if letters else "slab", corners)


def with_marker(
    bottom: NDArray[np.float64], label: str, turn: float, centre: tuple[float, float]
) -> Thing:
    """Lay a marker on the bottom: a white plate with one module of margin."""
    markers = cv2.aruco.getPredefinedDictionary(DICTIONARIES[label])
    modules = int(markers.markerSize) + 4
    code = np.asarray(markers.generateImageMarker(7, modules - 2, borderBits=1))
    plate = np.pad(code, 1, constant_values=255).astype(np.float64)
    corners = corners_of(centre, (48.0, 48.0), turn)
    square = np.array([[0, 0], [modules, 0], [modules, modules], [0, modules]], np.float32)
    over = cv2.getPerspectiveTransform(square * 8, corners.astype(np.float32))
    large = np.kron(plate, np.ones((8, 8)))
    size = (WIDTH, HEIGHT)
    shown = cv2.warpPerspective(large, over, size)
    cover = cv2.warpPerspective(np.ones_like(large), over, size)
    bottom[:] = bottom * (1 - cover) + cover * (BLACK + shown / 255 * (WHITE - BLACK))
    return Thing(label, corners)


def seen(bottom: NDArray[np.float64], seed: int = 0) -> Image:
    """Return the image of a camera with a little noise."""
    noisy = bottom + np.random.default_rng(seed).normal(0.0, 2.0, bottom.shape)
    return np.clip(np.round(noisy), 0, 255).astype(np.uint8)


def overlap(first: Corners, second: Corners) -> float:
    """Return the area that two convex quadrilaterals share over the area of both."""
    shapes = first.astype(np.float32), second.astype(np.float32)
    shared, _ = cv2.intersectConvexConvex(*shapes)
    return shared / (sum(map(cv2.contourArea, shapes)) - shared)
