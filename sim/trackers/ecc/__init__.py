"""`ecc`: OpenCV's enhanced correlation coefficient."""

from seamark.sim.trackers.declaration import (
    Errors,
    OptionValues,
    TrackerDeclaration,
    number_option,
)
from seamark.sim.trackers.options import MAX_JUMP, PREDICT_MOTION, WARP


def _unsupported(values: OptionValues) -> Errors:
    if values.get("warp") != "srt":
        return {}
    return {
        "warp": "ecc does not support warp srt: OpenCV's ECC has no warp with a uniform scale. "
        "Choose rt, affine or homography."
    }


TRACKER = TrackerDeclaration(
    label="Enhanced correlation coefficient (ECC, OpenCV)",
    path="seamark.sim.trackers.ecc.tracker:EccTracker",
    options=(
        WARP,
        number_option(
            "ecc_iterations",
            20,
            low=1,
            high=200,
            title="Iterations of ECC",
            help="ECC: maximum for each image.",
        ),
        PREDICT_MOTION,
        MAX_JUMP,
    ),
    exact=False,
    unsupported=_unsupported,
)
