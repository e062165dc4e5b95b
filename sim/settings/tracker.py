"""Settings of the tracker, composed from what the trackers of the registry declare."""

from functools import partial

from seamark.sim.registry import TRACKERS, TRUTH
from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.declared import declarations, labels, with_options
from seamark.sim.settings.setting import override, setting
from seamark.sim.trackers import declaration, option_errors, option_names

tracker_setting = partial(setting, group="Tracker", role="solution")


_DECLARED = declarations(TRACKERS, declaration)


@with_options("tracker", _DECLARED, tracker_setting)
class TrackerSettings(Configuration):
    """Which tracker, and its options."""

    tracker: str = tracker_setting(
        "esm",
        title="Tracker",
        help="Finds the target in the camera image.",
        choices=labels(_DECLARED) | {TRUTH: "Ground truth (no tracker; cannot rank)"},
    )

    def tracker_options(self) -> dict[str, object]:
        """Return the options of the chosen tracker."""
        return {name: getattr(self, name) for name in option_names(self.tracker)}

    def exact(self) -> bool:
        """Return whether every processor gives the same bits."""
        if self.tracker == TRUTH:
            return True
        # A stored run may name a tracker that no longer exists.
        return self.tracker in TRACKERS and declaration(self.tracker).exact

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> sentence for combinations that the tracker does not support."""
        return option_errors(self.tracker, self.tracker_options())


INHERITED = TrackerSettings.model_fields
_MEASURED = "docs/trackers.md: convergence basin and yaw error on photographs"


class RobustTrackerSettings(TrackerSettings):
    """The tracker of the second versions of the benchmarks: it finds targets that moved farther.

    The first versions keep the defaults that their results were obtained with.
    """

    fine_iterations: int = override(INHERITED["fine_iterations"], 10, source=_MEASURED)
    stop_px: float = override(INHERITED["stop_px"], 0.2, source=_MEASURED)
    smoothing: str = override(INHERITED["smoothing"], "image")
    second_search: bool = override(INHERITED["second_search"], True)
    max_jump: float = override(INHERITED["max_jump"], 1.0, source=_MEASURED)
    visp_predict: bool = override(INHERITED["visp_predict"], True)


# What these settings give the template tracker beside its own defaults.
ROBUST = {
    name: RobustTrackerSettings.model_fields[name].default
    for name in option_names("esm")
    if RobustTrackerSettings.model_fields[name].default != INHERITED[name].default
}
