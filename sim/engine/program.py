"""The program in the loop: the user's in a box, or one of the built-in controllers."""

from collections.abc import Mapping, Sequence
from pkgutil import resolve_name
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from seamark.sim import registry
from seamark.sim.control.observation import Observation
from seamark.sim.settings.configuration import Configuration

Command = tuple[float, float, float, float]


class Program(Protocol):
    """What the loop needs of a program. A box that fails raises through it, untouched."""

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Hear that a level begins: index, count, duration_s, dt, t; never the current's truth."""

    def step(self, values: NDArray[np.float64]) -> Command:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s] for a packed observation.

        The array is the same at every step, with other values: who keeps it keeps a copy.
        """


class Controller(Protocol):
    """The public interface, the same for the built-in controllers and for uploads.

    Built-in controllers also have a `label`, for the form.
    """

    label: ClassVar[str]

    def __init__(self, config: Mapping[str, Any]) -> None: ...

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget the last level."""

    def step(self, observation: Observation) -> Sequence[float]:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s]."""


class BuiltIn:
    """A `Program` that runs a built-in controller in this process."""

    def __init__(self, name: str, config: Configuration) -> None:
        make = resolve_name(registry.CONTROLLERS[name])
        self._controller: Controller = make(config.model_dump())

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Pass the level on."""
        self._controller.reset(level)

    def step(self, values: NDArray[np.float64]) -> Command:
        """Return the controller's answer as four floats."""
        surge, sway, heave, yaw_rate = self._controller.step(Observation(values))
        return float(surge), float(sway), float(heave), float(yaw_rate)
