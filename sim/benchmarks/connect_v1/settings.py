"""Settings of connect-v1: an arm that plugs a connector into its receptacle.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from seamark.sim.metrics.connection import METRICS
from seamark.sim.settings.custom_score import custom_score_setting
from seamark.sim.settings.experiment import experiment_setting
from seamark.sim.settings.intervention import ARMED, InterventionSettings
from seamark.sim.settings.setting import override
from seamark.sim.settings.targets import TargetShape

SHAPE = TargetShape("Roof panel with a receptacle", 0.6, 0.45, 0.6, True)  # as its file has it
MOST_TILT_RAD = 0.14  # at 0.18 rad, the smoothest connectors creep; entries were tried up to here


class ConnectConfiguration(InterventionSettings):
    """Settings of connect-v1. Seed, trials and controller are not part of it."""

    level_duration_s: float = override(
        ARMED["level_duration_s"],
        75.0,
        help="Simulated time of an attempt; then everything returns to its start and the current "
        "changes.",
        tag="E",
        source="half more than what the oracle takes",
    )
    altitude_m: float = override(
        ARMED["altitude_m"],
        1.6,
        help="Height of the camera above the panel at the start of a level.",
        tag="E",
        source="above the reach of the arm",
    )
    clearance_least_m: float = experiment_setting(
        0.003,
        title="Least clearance",
        help="The difference of the diameters of hole and peg is drawn evenly from this to the "
        "greatest.",
        unit="m",
        low=0.0005,
        high=0.02,
        tag="E",
        source="a guide sleeve of a wet-mate connector",
    )
    clearance_most_m: float = experiment_setting(
        0.008,
        title="Greatest clearance",
        help="See the least clearance.",
        unit="m",
        low=0.0005,
        high=0.02,
        tag="E",
        source="the same, worn",
    )

    score: str = custom_score_setting(METRICS, group="Experiment")

    def target_shape(self) -> TargetShape:
        """Return the panel."""
        return SHAPE

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings."""
        errors = super().cross_field_errors()
        if self.clearance_most_m < self.clearance_least_m:
            errors["clearance_most_m"] = (
                f"clearance_most_m (Greatest clearance) must be at least the least one, "
                f"{self.clearance_least_m:g} m, not {self.clearance_most_m:g} m."
            )
        if self.tilt_spread_rad > MOST_TILT_RAD:
            errors["tilt_spread_rad"] = (
                f"tilt_spread_rad (Tilt) must be at most {MOST_TILT_RAD:g} rad, not "
                f"{self.tilt_spread_rad:g} rad: on steeper panels the connector may not stand."
            )
        return errors
