"""Load the compiled code of all trackers: each follows a few images."""

import numpy as np

from seamark.sim.trackers.median_flow.tracker import MedianFlowTracker
from seamark.sim.trackers.mosse.tracker import MosseTracker
from seamark.sim.trackers.template import warm_up as template

IMAGE = (np.indices((64, 64)).sum(axis=0) * 5 % 256).astype(np.uint8)
CORNERS = np.array([[20.0, 20], [40, 20], [40, 40], [20, 40]])


def run() -> None:
    """Load what runs need."""
    template.run()
    for tracker in (MosseTracker(), MedianFlowTracker()):
        tracker.start(IMAGE, CORNERS)
        tracker.update(IMAGE)
