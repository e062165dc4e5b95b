"""Settings of recover-v1: an arm that takes a box from the seabed.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from seamark.sim.settings.intervention import ARMED, InterventionSettings
from seamark.sim.settings.setting import override
from seamark.sim.settings.targets import TargetShape

SHAPE = TargetShape("Black box with a handle", 0.3, 0.2, 0.2, True)  # as its file has it


class RecoverConfiguration(InterventionSettings):
    """Settings of recover-v1. Seed, trials and controller are not part of it."""

    altitude_m: float = override(
        ARMED["altitude_m"],
        1.6,
        help="Height of the camera above the box at the start of a level.",
        tag="E",
        source="above the reach of the arm",
    )

    def target_shape(self) -> TargetShape:
        """Return the box."""
        return SHAPE
