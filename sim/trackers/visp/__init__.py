"""ViSP's template trackers, where Debian's library is installed: through a bridge program.

ViSP is licensed under the GPL, so it stays in a separate process (bridge.cpp), which is built on
this machine and never distributed.
"""

from seamark.sim.trackers.declaration import (
    Errors,
    Option,
    OptionValues,
    TrackerDeclaration,
    number_option,
)
from seamark.sim.trackers.options import (
    CRITERION,
    MAX_JUMP,
    METHOD,
    PYRAMID_LEVELS,
    SAMPLING_PX,
    TEMPLATE_MARGIN_PX,
    WARP,
)
from seamark.sim.trackers.visp.installation import unavailable_reason


def _unsupported(values: OptionValues) -> Errors:
    errors: Errors = {}
    method = values.get("method", "inverse_compositional")
    if values.get("criterion") == "zncc" and method in ("esm", "forward_compositional"):
        errors["criterion"] = (
            f"visp does not support criterion zncc with {method}: ViSP has zncc only as "
            "inverse_compositional and forward_additional."
        )
    warp = values.get("warp", "homography")
    sl3 = warp == "homography" and values.get("visp_sl3", True)
    if method == "esm" and warp != "translation" and not sl3:
        errors["method"] = (
            f"visp does not support method esm with warp {warp}: ViSP has esm only for the warps "
            "translation and homography (SL3)."
        )
    return errors


TRACKER = TrackerDeclaration(
    label="ViSP's template trackers",
    path="seamark.sim.trackers.visp.tracker:VispTracker",
    options=(
        WARP,
        CRITERION,
        METHOD,
        PYRAMID_LEVELS,
        SAMPLING_PX,
        TEMPLATE_MARGIN_PX,
        number_option(
            "visp_iterations",
            60,
            low=1,
            high=1000,
            title="Iterations of ViSP",
            help="ViSP: maximum for each image.",
        ),
        Option(
            name="visp_sl3",
            default=True,
            title="Homography as SL(3)",
            help="ViSP: the eight parameters of the group; otherwise the entries of the matrix.",
            advanced=True,
            applies={"warp": ("homography",)},
        ),
        Option(
            name="visp_predict",
            default=False,
            title="Predict the motion for ViSP",
            help="ViSP: start where the target would be at constant velocity, not where it was.",
            advanced=True,
        ),
        MAX_JUMP,
    ),
    exact=False,
    unavailable=unavailable_reason,
    unsupported=_unsupported,
)
