"""Runs every detector once on a made-up image: Numba then has all its code in memory."""

import numpy as np

from seamark.sim.detectors import make
from seamark.sim.registry import BOX_DETECTORS, DETECTORS, REFERENCE_DETECTORS


def run() -> None:
    """Look for objects in an image with a chequered corner."""
    image = np.full((240, 320), 40, np.uint8)
    # Chequered all over, it took twice as long: OpenCV tries to read each square as a marker.
    rows, columns = np.indices((60, 85))
    image[:60, :85] += (((rows // 12 + columns // 17) % 2) * 160).astype(np.uint8)
    for name in (*DETECTORS, *REFERENCE_DETECTORS, *BOX_DETECTORS):
        make(name).detect(image)
