"""`klt`: corners followed by optical flow, and the warp that most of them agree on (OpenCV)."""

from seamark.sim.trackers.declaration import (
    Errors,
    Option,
    OptionValues,
    TrackerDeclaration,
    number_option,
)
from seamark.sim.trackers.options import MAX_JUMP, WARP


def _unsupported(values: OptionValues) -> Errors:
    warp = values.get("warp")
    if warp not in ("translation", "rt"):
        return {}
    return {
        "warp": f"klt does not support warp {warp}: OpenCV cannot fit a rigid motion without scale "
        "to points. Choose srt, affine or homography."
    }


TRACKER = TrackerDeclaration(
    label="Corners and optical flow (KLT + RANSAC, OpenCV)",
    path="seamark.sim.trackers.klt.tracker:KltTracker",
    options=(
        WARP,
        number_option(
            "klt_points",
            80,
            low=8,
            high=1000,
            title="Points",
            help="KLT: maximum number of corners that are tracked.",
        ),
        Option(
            name="klt_from",
            default="first",
            title="Flow from",
            help="KLT: the first image does not drift, the previous one tolerates larger changes.",
            choices={"first": "The first image", "previous": "The previous image"},
            advanced=True,
        ),
        MAX_JUMP,
    ),
    exact=False,
    unsupported=_unsupported,
)
