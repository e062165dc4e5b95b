"""Settings of the tracker. A setting that the chosen tracker does not have is left alone.

The names are those of the trackers' own options (sim/trackers), so nothing is translated between.
Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from collections.abc import Sequence
from functools import partial
from typing import Any

from seamark.sim.registry import TRACKERS, TRUTH
from seamark.sim.settings.configuration import Configuration, setting
from seamark.sim.trackers import visp
from seamark.sim.trackers.choices import (
    CRITERIA,
    KLT_FROM,
    METHODS,
    RANGES,
    WARPS,
    options_of,
    refusals,
)

tracker_setting = partial(setting, group="Tracker", role="solution")


def tracking(name: str, default: object, *, warps: Sequence[str] = (), **words: Any) -> Any:
    """Return the setting of an option, which only the trackers that have it look at."""
    having = [each for each, entry in TRACKERS.items() if name in entry.options]
    only = {"warp": warps} if warps else {}
    return tracker_setting(default, applies={"tracker": having, **only}, **words)


def _number(name: str, default: float, *, title: str, help: str, unit: str = "") -> Any:
    low, high = RANGES[name]
    return tracking(
        name,
        default,
        title=title,
        help=help,
        unit=unit,
        low=low,
        high=high,
        tag="E",
        source="chosen for our own tracker, by speed and precision",
        advanced=True,
    )


def _offered() -> dict[str, str]:
    """Return tracker -> label, with what is to be said of it."""
    marks = {True: "", False: "; bits depend on the processor"}
    found = {name: entry.label + marks[entry.exact] for name, entry in TRACKERS.items()}
    if visp.why_not():
        found["visp"] += "; not on this machine"
    return found | {TRUTH: "Ground truth (no tracker; cannot rank)"}


class TrackerSettings(Configuration):
    """Which tracker, and how it works."""

    tracker: str = tracker_setting(
        "esm",
        title="Tracker",
        help="Finds the target in the camera's picture.",
        choices=_offered(),
    )
    warp: str = tracking(
        "warp",
        "homography",
        title="Warp",
        help="What movement of the target in the picture the tracker can follow.",
        choices=WARPS,
    )
    criterion: str = tracking(
        "criterion",
        "zncc",
        title="Similarity",
        help="What the tracker compares pictures by.",
        choices=CRITERIA,
    )
    method: str = tracking(
        "method",
        "esm",
        title="Method",
        help="How the tracker searches.",
        choices=METHODS,
    )
    pyramid_levels: int = _number(
        "pyramid_levels",
        2,
        title="Pyramid levels",
        help="Resolutions at most, each half the one before; more reach farther.",
    )
    coarse_iterations: int = _number(
        "coarse_iterations",
        6,
        title="Iterations on coarse levels",
        help="At most, on each level but the finest.",
    )
    fine_iterations: int = _number(
        "fine_iterations",
        5,
        title="Iterations on the finest level",
        help="At most, on the picture itself.",
    )
    stop_px: float = _number(
        "stop_px",
        0.5,
        title="Stop below",
        help="A step that moves every corner less is the last; of ssd and mi, less than a fifth.",
        unit="px",
    )
    sampling_px: float = _number(
        "sampling_px",
        1.0,
        title="Sampling",
        help="Distance between the template's pixels in the first picture.",
        unit="px",
    )
    template_margin_px: int = _number(
        "template_margin_px",
        -3,
        title="Margin of the template",
        help="How far it reaches beyond the target; a target without texture needs its edges.",
        unit="px",
    )
    predict_motion: bool = tracking(
        "predict_motion",
        True,
        title="Predict the motion",
        help="Whether the search starts where the target would be at constant speed.",
        advanced=True,
    )
    search_px: int = _number(
        "search_px",
        20,
        title="Search margin",
        help="How far around the last place the picture is looked at, at most.",
        unit="px",
    )
    reacquire_px: int = _number(
        "reacquire_px",
        0,
        title="Look again within",
        help="How far a lost target is looked for, farther with each picture; 0 does not.",
        unit="px",
    )

    klt_points: int = _number(
        "klt_points", 80, title="Points", help="KLT: how many corners are followed at most."
    )
    klt_from: str = tracking(
        "klt_from",
        "first",
        title="Flow from",
        help="KLT: the first picture does not drift, the one before stands larger changes.",
        choices=KLT_FROM,
        advanced=True,
    )
    ecc_iterations: int = _number(
        "ecc_iterations", 20, title="Iterations of ECC", help="ECC: at most, for each picture."
    )

    visp_iterations: int = _number(
        "visp_iterations", 60, title="Iterations of ViSP", help="ViSP: at most, for each picture."
    )
    visp_sl3: bool = tracking(
        "visp_sl3",
        True,
        title="Homography as SL(3)",
        help="ViSP: the group's eight parameters; if not, the entries of the matrix.",
        warps=("homography",),
        advanced=True,
    )

    def tracker_options(self) -> dict[str, object]:
        """Return the options of the chosen tracker."""
        return {name: getattr(self, name) for name in options_of(self.tracker)}

    def exact(self) -> bool:
        """Return whether every processor gives the same bits."""
        known = TRACKERS.get(self.tracker)  # a stored run may name one that no longer exists
        return self.tracker == TRUTH or (known is not None and known.exact)

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> sentence for combinations that the tracker does not do."""
        return refusals(self.tracker, self.tracker_options())
