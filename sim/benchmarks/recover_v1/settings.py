"""Settings of recover-v1: an arm that takes a box from the seabed.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from seamark.sim.metrics.recovery import METRICS
from seamark.sim.settings.custom_score import custom_score_setting
from seamark.sim.settings.intervention import ARMED, InterventionSettings
from seamark.sim.settings.setting import override
from seamark.sim.settings.targets import RECOVERED_BOX, TargetShape


class RecoverConfiguration(InterventionSettings):
    """Settings of recover-v1. Seed, trials and controller are not part of it."""

    levels: tuple[float, ...] = override(
        InterventionSettings.model_fields["levels"],
        (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7),
        tag="E",
        source="beyond what the oracle holds; see docs/benchmarks.md",
    )
    altitude_m: float = override(
        ARMED["altitude_m"],
        1.6,
        help="Height of the camera above the box at the start of a level.",
        tag="E",
        source="above the reach of the arm",
    )

    score: str = custom_score_setting(METRICS, group="Experiment")

    def target_shape(self) -> TargetShape:
        """Return the box."""
        return RECOVERED_BOX
