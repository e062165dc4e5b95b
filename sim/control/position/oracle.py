"""Oracle: knows the true state, the water and the vehicle; limited by thrust alone. A mark."""

from collections.abc import Mapping, Sequence
from pkgutil import resolve_name
from typing import Any

from seamark.sim.control.observation import Observation
from seamark.sim.numerics.arrays import Array


class Controller:
    """The inverse dynamics of the true plant, see `seamark.sim.control.inverse_dynamics`.

    The engine shows it the plant (`attach`) and lets it command the thrusters itself (`commands`),
    past the velocity controller and all latencies. No program of a user has such methods called.
    """

    label = "Oracle (knows the truth)"

    def __init__(self, config: Mapping[str, Any]) -> None:
        self._dt = config["control_period_s"]
        self._law: Any = None  # an InverseDynamics, which is compiled

    def attach(self, plant: Any, station: Array, point: tuple[float, float] | None) -> None:
        """Take the plant of a level, and the pose or point to hold; see `InverseDynamics`."""
        law = resolve_name("seamark.sim.control.inverse_dynamics:InverseDynamics")
        self._law = law(plant, station, self._dt, point)

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Do nothing: the law has no state."""

    def step(self, observation: Observation) -> Sequence[float]:
        """Return zero: the velocity controller is not used."""
        return [0.0, 0.0, 0.0, 0.0]

    def commands(self) -> Array:
        """Return the thrusters' commands, (n,) in [-1, 1]."""
        commands: Array = self._law.commands()
        return commands
