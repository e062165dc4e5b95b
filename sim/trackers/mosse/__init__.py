"""`mosse`: the correlation filter that started them, which follows an upright box."""

from seamark.sim.trackers.declaration import TrackerDeclaration

TRACKER = TrackerDeclaration(
    label="Minimum output sum of squared error (MOSSE; an upright box)",
    path="seamark.sim.trackers.mosse.tracker:MosseTracker",
)
