"""Settings of valve-v1: an arm that turns a valve on a panel.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from seamark.sim.metrics.valve_turning import METRICS
from seamark.sim.settings.custom_score import custom_score_setting
from seamark.sim.settings.experiment import experiment_setting
from seamark.sim.settings.intervention import ARMED, InterventionSettings
from seamark.sim.settings.setting import override
from seamark.sim.settings.targets import TargetShape

SHAPE = TargetShape("Roof panel with a valve", 0.6, 0.45, 0.6, True)  # as its file has it


class ValveConfiguration(InterventionSettings):
    """Settings of valve-v1. Seed, trials and controller are not part of it."""

    altitude_m: float = override(
        ARMED["altitude_m"],
        1.6,
        help="Height of the camera above the panel at the start of a level.",
        tag="E",
        source="above the reach of the arm",
    )
    torque_least_n_m: float = experiment_setting(
        2.0,
        title="Least torque",
        help="The torque that breaks the valve away is drawn evenly from this to the greatest.",
        unit="N m",
        low=0.1,
        high=50,
        tag="E",
        source="a valve that was moved last month",
    )
    torque_most_n_m: float = experiment_setting(
        8.0,
        title="Greatest torque",
        help="See the least torque.",
        unit="N m",
        low=0.1,
        high=50,
        tag="E",
        source="a third of what the wrist of the arm gives",
    )

    score: str = custom_score_setting(METRICS, group="Experiment")

    def target_shape(self) -> TargetShape:
        """Return the panel."""
        return SHAPE

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings."""
        errors = super().cross_field_errors()
        if self.torque_most_n_m < self.torque_least_n_m:
            errors["torque_most_n_m"] = (
                f"torque_most_n_m (Greatest torque) must be at least the least one, "
                f"{self.torque_least_n_m:g} N m, not {self.torque_most_n_m:g} N m."
            )
        return errors
