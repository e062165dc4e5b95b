"""The interface of a detector: it gets an image and returns what lies on the bottom, and where."""

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]  # (H, W) grey, or (H, W, 3) red, green, blue
Corners = NDArray[np.float64]  # (4, 2) [px]
MOST = 64  # detections in one image; the less confident ones are left out
_GREEN = 1


class Detection(NamedTuple):
    """One object that a detector says to see."""

    label: str  # of `patterns.CLASSES`
    corners: Corners  # of its plan rectangle, in the order of `bottom.things.Thing.corners`
    confidence: float  # from 0 to 1


class Detector(Protocol):
    """Finds the objects in single images."""

    def detect(self, image: Image) -> list[Detection]:
        """Return what is in an image, most confident first, at most MOST."""
        ...


def grey(image: Image) -> Image:
    """Return the grey image (H, W): of a colour image its green channel, as the camera's is."""
    return image if image.ndim == 2 else np.ascontiguousarray(image[:, :, _GREEN])


def most_confident(detections: list[Detection], *, most: int = MOST) -> list[Detection]:
    """Return the detections in the order of an answer, without those that are too many.

    Those outside any image are left out too: corners are finite and confidences from 0 to 1.
    """
    sound = [d for d in detections if np.isfinite(d.corners).all() and 0.0 <= d.confidence <= 1.0]
    return sorted(sound, key=lambda d: -d.confidence)[:most]  # stable: equal ones keep their order
