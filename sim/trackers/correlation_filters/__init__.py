"""`kcf` and `csrt`: OpenCV's correlation filters, which follow an upright box."""

from seamark.sim.trackers.declaration import TrackerDeclaration

KCF = TrackerDeclaration(
    label="Kernelised correlation filter (KCF, OpenCV; an upright box)",
    path="seamark.sim.trackers.correlation_filters.tracker:KcfTracker",
    exact=False,
)
CSRT = TrackerDeclaration(
    label="Filter with channel and spatial reliability (CSRT, OpenCV; an upright box)",
    path="seamark.sim.trackers.correlation_filters.tracker:CsrtTracker",
    exact=False,
)
