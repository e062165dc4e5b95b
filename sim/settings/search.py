"""Settings of a search: the detector that finds the target, and where it is looked for.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from functools import partial

from seamark.sim.detectors import declaration
from seamark.sim.registry import BOX_DETECTORS
from seamark.sim.settings.declared import declarations, labels, with_options
from seamark.sim.settings.detector import ChosenDetector, detector_setting
from seamark.sim.settings.experiment import ExperimentSettings
from seamark.sim.settings.setting import setting

TARGET_LABEL = "box"  # of `patterns.CLASSES`: the answers that count
GROUP = "Search"
LONGEST_PERIOD_S = 10.0  # from one image of the detector to the next
search_setting = partial(setting, group=GROUP, role="scenario")
_DECLARED = declarations(BOX_DETECTORS, declaration)


@with_options("detector", _DECLARED, detector_setting)
class FindingSettings(ChosenDetector, ExperimentSettings):
    """Which detector finds the target for the tracker, and how often it looks."""

    detector: str = detector_setting(
        "face",
        title="Detector",
        help="Finds the target in the camera image, for the tracker to follow.",
        choices=labels(_DECLARED),
    )
    least_confidence: float = detector_setting(
        0.25,
        title="Least confidence",
        help="From which confidence of the detector on the tracker starts to follow an answer.",
        low=0,
        high=1,
        tag="E",
        source="low: a controller sees the confidence, and can go nearer to have it rise or fall",
    )
    detector_period_s: float = search_setting(
        1.0,
        title="Detector period",
        help="Time from one image that the detector gets to the next.",
        unit="s",
        low=0.05,
        high=LONGEST_PERIOD_S,
        tag="E",
        source="at 0.4 m/s the camera moves on by a sixth of its view",
        advanced=True,
    )


class SearchSettings(FindingSettings):
    """Which detector looks for the target, how often, and how far off the vehicle starts."""

    told_error_m: float = search_setting(
        2.0,
        title="Error of the position told",
        help="How far the position that programs are told may be from the true one; drawn evenly "
        "over the disc.",
        unit="m",
        low=0,
        high=5,
        tag="E",
        source="an acoustic fix in shallow water",
    )
    decoy_least_m: float = search_setting(
        1.0,
        title="Nearest decoy",
        help="Least distance of the wrong box from the right one.",
        unit="m",
        low=0.8,
        high=5,
        tag="E",
        source="the hand of an arm fits between them",
        advanced=True,
    )
    decoy_most_m: float = search_setting(
        2.2,
        title="Farthest decoy",
        help="Largest distance of the wrong box from the right one.",
        unit="m",
        low=0.8,
        high=8,
        tag="E",
        source="within the area that is searched",
        advanced=True,
    )
    litter: float = search_setting(
        0.6,
        title="Litter on the seabed",
        help="Share of the places on the seabed, 0.73 m apart, at which something lies.",
        low=0,
        high=1,
        tag="E",
        source="stones, planks, cans and what was lost",
        advanced=True,
    )

    def searches(self) -> bool:
        """Return whether what the arm works on has to be found first: always."""
        return True

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> sentence for what does not go together."""
        errors: dict[str, str] = {}
        if self.decoy_most_m < self.decoy_least_m:
            errors["decoy_most_m"] = (
                "decoy_most_m (Farthest decoy) must not be less than decoy_least_m (Nearest decoy) "
                f"of {self.decoy_least_m:g} m."
            )
        return errors | super().cross_field_errors()
