"""Images as JPEG."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

QUALITY = 88


def jpeg(image: NDArray[np.uint8]) -> bytes:
    """Return an image (H, W, 3) in blue, green, red as JPEG."""
    import cv2

    done, encoded = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    if not done:
        raise RuntimeError("OpenCV could not encode the image")
    data: bytes = encoded.tobytes()
    return data
