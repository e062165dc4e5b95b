"""`orb`: ORB features (Rublee et al. 2011) matched with those of painted views.

The camera looks almost straight down, so a similarity takes a view to the image.
"""

import cv2
import numpy as np

from seamark.sim.camera.bottom.things import NAMES
from seamark.sim.detectors.boxes import first_apart
from seamark.sim.detectors.interface import Detection, Image, grey, most_confident
from seamark.sim.detectors.orb.matching import nearest, similarity
from seamark.sim.detectors.orb.views import features, views

_LEAST = 4  # matches that agree, E: two agree always
_FAST_THRESHOLD = 8  # [grey] E: lower than OpenCV's 20, for turbid water
_SAME = 0.4  # intersection over union from which two answers of a label are one


class OrbDetector:
    """Finds things whose lettering, code or edges resemble those of a painted view."""

    def __init__(self, *, orb_features: int = 400) -> None:
        self._finder = cv2.ORB.create(orb_features, fastThreshold=_FAST_THRESHOLD, edgeThreshold=16)
        self._views = views()

    def detect(self, image: Image) -> list[Detection]:
        """Return the views that enough features of an image agree on."""
        known = self._views
        points, words = features(self._finder, grey(image))
        which, distances = nearest(words, known.words)
        order = np.argsort(distances, kind="stable")
        order = order[which[order] >= 0]
        owners = known.views[which[order]]
        found = []
        for view in np.unique(owners).tolist():
            mine = order[owners == view]
            agreeing, fit = similarity(known.points[which[mine]], points[mine])
            if agreeing >= _LEAST:
                p, q = known.corners[view].T
                a, b, x, y = fit.tolist()
                corners = np.stack([a * p - b * q + x, b * p + a * q + y], axis=1)
                label = NAMES[known.kinds[view]]
                found.append(Detection(label, corners, 1.0 - 2.0 / agreeing))
        return first_apart(most_confident(found), _SAME)
