"""Runs every detector once on a made-up image: Numba then has all its code in memory."""

import numpy as np

from seamark.sim.detectors import make
from seamark.sim.registry import BOX_DETECTORS, DETECTORS, REFERENCE_DETECTORS


def run() -> None:
    """Look for objects in a chequered image."""
    rows, columns = np.indices((240, 320))
    image = (((rows // 12 + columns // 17) % 2) * 160 + 40).astype(np.uint8)
    for name in (*DETECTORS, *REFERENCE_DETECTORS, *BOX_DETECTORS):
        make(name).detect(image)
