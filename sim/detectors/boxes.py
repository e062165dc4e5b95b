"""Upright boxes around detections, and which detections are of one object."""

import numpy as np

from seamark.sim.detectors.interface import Corners, Detection


def overlap(one: Corners, other: Corners) -> float:
    """Return the intersection over union of the upright boxes around two quadrilaterals."""
    low = np.maximum(one.min(axis=0), other.min(axis=0))
    high = np.minimum(one.max(axis=0), other.max(axis=0))
    common = float(np.prod(np.maximum(high - low, 0.0)))
    areas = float(np.prod(np.ptp(one, axis=0)) + np.prod(np.ptp(other, axis=0)))
    return common / max(areas - common, 1e-9)


def first_apart(detections: list[Detection], most_overlap: float) -> list[Detection]:
    """Return the detections without those whose box overlaps more with an earlier one."""
    kept: list[Detection] = []
    for each in detections:
        if all(overlap(each.corners, other.corners) <= most_overlap for other in kept):
            kept.append(each)
    return kept
