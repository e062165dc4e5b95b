"""`median-flow`: points of a grid that are followed there and back, and their median."""

from seamark.sim.trackers.declaration import TrackerDeclaration

TRACKER = TrackerDeclaration(
    label="Median flow (forward-backward error; an upright box with scale)",
    path="seamark.sim.trackers.median_flow.tracker:MedianFlowTracker",
)
