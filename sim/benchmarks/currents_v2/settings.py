"""Settings of currents-v2: those of station keeping, and what is drawn per trial.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from seamark.sim.metrics import tool_point
from seamark.sim.metrics.station_keeping import overall
from seamark.sim.settings.arm import ArmSettings
from seamark.sim.settings.custom_score import custom_score_setting
from seamark.sim.settings.setting import override
from seamark.sim.settings.station_keeping import StationKeepingSettings
from seamark.sim.settings.tracker import RobustTrackerSettings
from seamark.sim.settings.trial_spreads import TrialSpreadSettings
from seamark.sim.settings.two_vehicles import TwoVehicles, two_vehicles_setting

ALTERNATING = ("girona500", "bluerov2-heavy")  # in even, in odd trials
SINGLE = (*ALTERNATING, "bluerov2-heavy-v2")  # in all trials of a practice run

INHERITED = StationKeepingSettings.model_fields


class CurrentsConfiguration(
    RobustTrackerSettings, ArmSettings, StationKeepingSettings, TrialSpreadSettings, TwoVehicles
):
    """Settings of currents-v2. Seed, trials and controller are not part of it."""

    alternating = ALTERNATING

    vehicle: str = two_vehicles_setting(SINGLE)
    levels: tuple[float, ...] = override(
        INHERITED["levels"],
        (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0),
        help="Mean speed of the current at each level, in increasing order; they run in an order "
        "that is drawn.",
        tag="D",
        source="beyond the static limit of both vehicles; see docs/benchmarks.md",
    )
    level_duration_s: float = override(
        INHERITED["level_duration_s"],
        60.0,
        help="Simulated time before the vehicle returns to its start and the current changes.",
        tag="E",
        source="two periods of the direction of the current",
    )
    settle_s: float = override(
        INHERITED["settle_s"],
        15.0,
        help="Time at the start of each level that the settled metrics ignore; the score counts "
        "whole levels.",
        source="a quarter of a level",
    )
    images: str = override(ArmSettings.model_fields["images"], "none", role="solution")
    score: str = custom_score_setting((*overall(), *tool_point.METRICS), group="Experiment")
