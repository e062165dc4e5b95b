"""Runs the template tracker once on a made-up image: Numba then has all its code in memory."""

import numpy as np

from seamark.sim.trackers.template.tracker import TemplateTracker


def run() -> None:
    """Track a chequered patch that does not move."""
    rows, columns = np.indices((96, 128))
    image = (((rows // 5 + columns // 7) % 2) * 160 + 40).astype(np.uint8)
    corners = np.array([[34.0, 30.0], [94.0, 30.0], [94.0, 66.0], [34.0, 66.0]])
    tracker = TemplateTracker()
    tracker.start(image, corners)
    for _ in range(2):
        tracker.update(image)
