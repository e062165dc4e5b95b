"""Settings of the tracker, composed from what the trackers of the registry declare.

A setting that the chosen tracker does not have is ignored. The names are those of the trackers'
options, so nothing is translated in between.
"""

from collections.abc import Mapping
from functools import partial
from typing import Any, TypeVar

from pydantic import create_model

from seamark.sim.registry import TRACKERS, TRUTH
from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.setting import override, setting
from seamark.sim.trackers import declaration, option_errors, option_names
from seamark.sim.trackers.declaration import Option

tracker_setting = partial(setting, group="Tracker", role="solution")
Settings = TypeVar("Settings", bound=type[Configuration])


def _labels() -> dict[str, str]:
    """Return tracker -> label, with its restrictions."""
    labels = {}
    for name in TRACKERS:
        declared = declaration(name)
        inexact = "" if declared.exact else "; not bit-identical on all processors"
        missing = "; not on this machine" if declared.unavailable() else ""
        labels[name] = f"{declared.label}{inexact}{missing}"
    return labels | {TRUTH: "Ground truth (no tracker; cannot rank)"}


def declared_options() -> dict[str, Option]:
    """Return name -> option of all trackers, in the form's order.

    Raises
    ------
    ValueError
        If two trackers declare different options of the same name.
    """
    options: dict[str, Option] = {}
    for tracker in TRACKERS:
        for option in declaration(tracker).options:
            if options.setdefault(option.name, option) != option:
                raise ValueError(f"tracker {tracker}: another tracker's {option.name} differs")
    return options


def _field(option: Option) -> Any:  # as `setting`
    trackers = [name for name in TRACKERS if option.name in option_names(name)]
    return tracker_setting(
        option.default,
        title=option.title,
        help=option.help,
        unit=option.unit,
        low=option.low,
        high=option.high,
        choices=option.choices or None,
        tag=option.tag,
        source=option.source,
        advanced=option.advanced,
        applies={"tracker": trackers, **option.applies},
    )


def _with_tracker_options(settings: Settings) -> Settings:
    """Add a setting for each option that a tracker declares."""
    fields: Mapping[str, Any] = {
        name: (type(option.default), _field(option)) for name, option in declared_options().items()
    }
    extended: Any = create_model(
        settings.__name__,
        __base__=settings,
        __doc__=settings.__doc__,
        __module__=settings.__module__,
        **fields,
    )
    return extended  # type: ignore[no-any-return]  # pydantic's stubs do not know the class


@_with_tracker_options
class TrackerSettings(Configuration):
    """Which tracker, and its options."""

    tracker: str = tracker_setting(
        "esm",
        title="Tracker",
        help="Finds the target in the camera image.",
        choices=_labels(),
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
