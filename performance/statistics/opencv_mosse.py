"""OpenCV's MOSSE, a peer of ours: it is only measured, nobody can choose it.

It is in `cv2.legacy`, which OpenCV keeps for those who still need it.
"""

import cv2

from seamark.sim.trackers.correlation_filters.tracker import BoxFilter, UprightBoxTracker


class OpenCvMosse(UprightBoxTracker):
    """The correlation filter of Bolme et al. as OpenCV has it: in whole pixels."""

    def _create_filter(self) -> BoxFilter:
        made: BoxFilter = cv2.legacy.TrackerMOSSE.create()
        return made
