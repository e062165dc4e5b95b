"""`box`: an upright box moved to where its pixels correlate best (OpenCV): a baseline."""

from seamark.sim.trackers.declaration import TrackerDeclaration
from seamark.sim.trackers.options import SEARCH_PX

TRACKER = TrackerDeclaration(
    label="Upright box by correlation (OpenCV; a baseline)",
    path="seamark.sim.trackers.box.tracker:BoxTracker",
    options=(SEARCH_PX,),
    exact=False,
)
