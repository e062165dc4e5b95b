"""Settings of dock-v1: a dock that a vehicle enters from above, in levels of increasing current.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from typing import Any

from seamark.sim.metrics.docking import METRICS
from seamark.sim.settings.current_levels import CurrentLevels
from seamark.sim.settings.custom_score import custom_score_setting
from seamark.sim.settings.docking import DockSettings
from seamark.sim.settings.experiment import experiment_setting
from seamark.sim.settings.setting import override
from seamark.sim.settings.sonar import SonarSettings
from seamark.sim.settings.targets import TargetShape
from seamark.sim.settings.tracker import RobustTrackerSettings
from seamark.sim.settings.trial_spreads import TrialSpreadSettings
from seamark.sim.settings.two_vehicles import TwoVehicles, two_vehicles_setting
from seamark.sim.vehicles import Vehicle, load

MARKER = TargetShape("Lettered marker of the dock", 0.3, 0.2, 0.1, True)  # below its middle
RAILS_M = 0.75  # E: what the keel rests on, above the seabed: the camera still sees the marker
_SCENE = TrialSpreadSettings.model_fields


def keel_m(vehicle: Vehicle) -> float:
    """Return how far the lowest part of a hull is below the body's origin [m]."""
    return max(piece.centre.value[2] + 0.5 * piece.size.value[2] for piece in vehicle.hull)


class DockConfiguration(
    RobustTrackerSettings,
    DockSettings,
    CurrentLevels,
    TrialSpreadSettings,
    SonarSettings,
    TwoVehicles,
):
    """Settings of dock-v1. Seed, trials and controller are not part of it."""

    vehicle: str = two_vehicles_setting(own="its own defaults and a dock of its size")
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
        source="beyond what the oracle docks in; see docs/benchmarks.md",
    )
    level_duration_s: float = override(
        _SCENE["level_duration_s"],
        60.0,
        help="Simulated time before the vehicle is put to another start and the current changes.",
        tag="E",
        source="twice what the oracle takes",
    )
    altitude_m: float = override(
        _SCENE["altitude_m"],
        2.3,
        help="Least height of the camera above the marker at the start of a level.",
        tag="E",
        source="the keel is a metre above the mouth of the dock",
    )
    camera_width_px: int = override(_SCENE["camera_width_px"], 320)
    camera_height_px: int = override(_SCENE["camera_height_px"], 240)
    camera_focal_px: float = override(
        _SCENE["camera_focal_px"],
        190.0,
        tag="S",
        source="field of view of 80 degrees, like the camera of a BlueROV2",
    )
    range_from: str = override(_SCENE["range_from"], "size")
    # Of benchmarks that begin above their target, which this one does not.
    start_offset_m: float = override(_SCENE["start_offset_m"], 0.0, group="Tracker start")
    start_heading_rad: float = override(_SCENE["start_heading_rad"], 0.0, group="Tracker start")
    start_error_px: float = override(_SCENE["start_error_px"], 0.0, group="Tracker start")
    score: str = custom_score_setting(METRICS, group="Experiment")

    unused_groups = frozenset({"Tracker start"})

    def target_shape(self) -> TargetShape:
        """Return the marker on the seabed, below the middle of the dock."""
        return MARKER

    def camera_mount_m(self) -> tuple[float, float, float]:
        """Return where the camera is on the body [m]: below its origin, level with the keel."""
        return 0.0, 0.0, keel_m(load(self.vehicles()[0]))

    def base_levels(self) -> tuple[float, ...]:
        """Return the mean speeds [m/s] without a grid."""
        return self.levels

    def for_program(self) -> dict[str, Any]:
        """Return the settings that a program is given, and what it knows of dock and camera."""
        known = {"camera_mount_m": self.camera_mount_m(), "rails_m": RAILS_M}
        known |= {"marker_m": (MARKER.length_m, MARKER.width_m, MARKER.height_m)}
        return super().for_program() | known

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings."""
        return super().cross_field_errors() or self.grid_errors()
