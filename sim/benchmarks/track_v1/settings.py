"""Settings of track-v1: a route to follow, in levels of increasing current.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from typing import Self

from seamark.sim.control.observation import PIPE
from seamark.sim.metrics.following import METRICS
from seamark.sim.settings.current_levels import CurrentLevels
from seamark.sim.settings.custom_score import custom_score_setting
from seamark.sim.settings.experiment import experiment_setting
from seamark.sim.settings.route import RouteSettings
from seamark.sim.settings.setting import override, setting
from seamark.sim.settings.sonar import SonarSettings
from seamark.sim.settings.targets import TargetShape
from seamark.sim.settings.trial_spreads import TrialSpreadSettings
from seamark.sim.settings.two_vehicles import TwoVehicles, two_vehicles_setting

MARK = TargetShape("Concrete weight", 1.0, 0.6, 0.4, True)  # on the bottom, below the start
PIPE_RADIUS_M = 0.2  # E: half of a trunk line of 16 inches
# The piece of a pipe below the start; images show the pipe instead.
PIPE_MARK = TargetShape("Pipe", 2.0 * PIPE_RADIUS_M, 2.0 * PIPE_RADIUS_M, PIPE_RADIUS_M, False)
SEABED_M = 20.0  # [m] depth, E: inshore
_SCENE = TrialSpreadSettings.model_fields


class TrackConfiguration(
    RouteSettings, CurrentLevels, TrialSpreadSettings, SonarSettings, TwoVehicles
):
    """Settings of track-v1. Seed, trials and controller are not part of it."""

    unused_groups = frozenset({"Tracker", "Station keeper", "Water and camera"})

    vehicle: str = two_vehicles_setting()
    levels: tuple[float, ...] = experiment_setting(
        (0.0, 0.2, 0.4, 0.6, 0.8),
        title="Current levels",
        help="Mean speed of the current at each level, in increasing order; they run in an order "
        "that is drawn.",
        unit="m/s",
        low=0,
        high=1,
        length=(1, 12),
        tag="E",
        source="beyond what the oracle follows; see docs/benchmarks.md",
    )
    level_duration_s: float = override(
        _SCENE["level_duration_s"],
        120.0,
        help="Simulated time before the vehicle returns to its start and the current changes.",
        tag="E",
        source="the route at 0.25 m/s on average",
    )
    altitude_m: float = override(
        _SCENE["altitude_m"],
        5.0,
        help="Height of the camera above the weight on the bottom at the start of a level.",
        tag="E",
        source="room for routes that rise and fall by 2 m",
    )
    # Of the camera above a pipe, that of visibility-v2: half the pixels of currents-v2 each way.
    camera_width_px: int = override(_SCENE["camera_width_px"], 320)
    camera_height_px: int = override(_SCENE["camera_height_px"], 240)
    camera_focal_px: float = override(_SCENE["camera_focal_px"], 257.3)
    # Of a tracker, which this benchmark does not have.
    start_error_px: float = override(_SCENE["start_error_px"], 0.0, group="Tracker")
    start_heading_rad: float = override(_SCENE["start_heading_rad"], 0.8)
    control_heave: bool = override(
        _SCENE["control_heave"],
        True,
        help="Whether PI also acts on z, so that it follows the depth of the route.",
    )
    speed_m_s: float = setting(
        0.5,
        title="Speed along the route",
        help="That the built-in controllers aim at.",
        group="Guidance",
        role="solution",
        unit="m/s",
        low=0.05,
        high=1,
        tag="E",
        source="twice what the time needs on average",
        applies={"controller": ("los", "ilos", "into-flow", "l1", "mpc", "blind", "upload")},
    )
    lookahead_m: float = setting(
        0.6,
        title="Lookahead distance",
        help="How far ahead of the nearest point of the route the vehicle aims.",
        group="Guidance",
        role="solution",
        unit="m",
        low=0.1,
        high=5,
        tag="E",
        source="scan on seeds that no benchmark uses",
        applies={"controller": ("los", "ilos", "into-flow", "l1", "blind", "upload")},
    )
    integral_gain: float = setting(
        0.1,
        title="Integral gain",
        help="Of the cross-track error, by which the integral line of sight corrects its course.",
        group="Guidance",
        role="solution",
        unit="m/s",
        low=0,
        high=2,
        tag="E",
        source="scan on seeds that no benchmark uses",
        applies={"controller": ("ilos", "into-flow", "upload")},
    )
    score: str = custom_score_setting(METRICS, group="Experiment")

    def target_shape(self) -> TargetShape:
        """Return the weight on the bottom, below the start, or what of a pipe is there."""
        return PIPE_MARK if self.route == PIPE else MARK

    def base_levels(self) -> tuple[float, ...]:
        """Return the mean speeds [m/s] without a grid."""
        return self.levels

    def for_trial(self, trial: int) -> Self:
        """Return the configuration of one trial, with its vehicle and its kind of route."""
        kind = self.route_kind(trial)
        # From where it is to be followed.
        height = {"altitude_m": self.pipe_height_m} if kind == PIPE else {}
        return super().for_trial(trial).model_copy(update={"route": kind, **height})

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings."""
        return super().cross_field_errors() or self.grid_errors()
