"""Upright boxes around detections, and which detections are of one object."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.detectors.interface import Detection
from seamark.sim.vehicles.patterns import CLASSES


def first_apart(detections: list[Detection], most_overlap: float) -> list[Detection]:
    """Return the detections without those whose box overlaps more with an earlier one of the label.

    The overlap is the intersection over union of the upright boxes around the corners.
    """
    if not detections:
        return []
    corners = np.array([each.corners for each in detections])
    labels = list(CLASSES)
    numbers = np.array([labels.index(each.label) for each in detections])
    keep = _apart(corners.min(axis=1), corners.max(axis=1), numbers, most_overlap)
    return [each for each, kept in zip(detections, keep.tolist(), strict=True) if kept]


@njit(cache=True, nogil=True, error_model="numpy")
def _apart(
    low: NDArray[np.float64],
    high: NDArray[np.float64],
    labels: NDArray[np.int64],
    most_overlap: float,
) -> NDArray[np.bool_]:
    keep = np.zeros(low.shape[0], np.bool_)
    areas = (high[:, 0] - low[:, 0]) * (high[:, 1] - low[:, 1])
    for k in range(low.shape[0]):
        keep[k] = True
        for m in range(k):
            if not keep[m] or labels[k] != labels[m]:
                continue
            wide = min(high[k, 0], high[m, 0]) - max(low[k, 0], low[m, 0])
            tall = min(high[k, 1], high[m, 1]) - max(low[k, 1], low[m, 1])
            common = max(wide, 0.0) * max(tall, 0.0)
            if common > most_overlap * (areas[k] + areas[m] - common):
                keep[k] = False
                break
    return keep
