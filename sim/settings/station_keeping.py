"""Settings of station keeping: levels of increasing current, and when scoring starts.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from seamark.sim.metrics.station_keeping import overall
from seamark.sim.settings.current_levels import CurrentLevels
from seamark.sim.settings.custom_score import custom_score_setting
from seamark.sim.settings.experiment import experiment_setting
from seamark.sim.settings.position_controllers import PositionControllerSettings


class StationKeepingSettings(PositionControllerSettings, CurrentLevels):
    """A vehicle in closed loop above the target, in a current that grows from level to level."""

    levels: tuple[float, ...] = experiment_setting(
        (0.0, 0.1, 0.2, 0.3, 0.4),
        title="Current levels",
        help="Mean speed of the current at each level, in increasing order.",
        unit="m/s",
        low=0,
        high=1,
        length=(1, 12),
        tag="S",
        source="Pérez et al., the published experiment",
    )
    settle_s: float = experiment_setting(
        30.0,
        title="Settle window",
        help="Time at the start of each level that the settled metrics and the score ignore.",
        unit="s",
        low=0,
        high=599,
        tag="E",
        source="the first seconds are the same for most controllers",
    )
    score: str = custom_score_setting(overall(), group="Experiment")

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings."""
        errors: dict[str, str] = {}
        if self.settle_s >= self.level_duration_s:
            errors["settle_s"] = (
                f"settle_s (Settle window) must be shorter than a level of "
                f"{self.level_duration_s:g} s, not {self.settle_s:g} s."
            )
        return errors | super().cross_field_errors() or self.grid_errors()

    def base_levels(self) -> tuple[float, ...]:
        """Return the mean speeds [m/s] without a grid."""
        return self.levels
