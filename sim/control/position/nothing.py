"""Nothing: the velocity reference is zero. A mark at the bottom of the leaderboard."""

from collections.abc import Mapping, Sequence
from typing import Any

from seamark.sim.control.observation import Observation


class Controller:
    """No station keeping: only the velocity controller works against the current."""

    label = "Nothing"

    def __init__(self, config: Mapping[str, Any]) -> None:
        """Read no setting."""

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Do nothing: there is no state."""

    def step(self, observation: Observation) -> Sequence[float]:
        """Return zero velocity."""
        return [0.0, 0.0, 0.0, 0.0]
