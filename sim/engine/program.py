"""The program in the loop: the user's in a box, or one of the built-in controllers."""

from collections.abc import Callable, Mapping, Sequence
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from seamark.sim import registry
from seamark.sim.control.observation import ArmSize, Images, Observation
from seamark.sim.numerics.arrays import Array
from seamark.sim.settings.configuration import Configuration

if TYPE_CHECKING:  # the service, which speaks of commands, does without Numba
    from seamark.sim.physics.plant import Plant

Command = tuple[float, ...]  # the vehicle's four, then the speeds of an arm's joints


class Program(Protocol):
    """A controller as the closed loop calls it. The exceptions of a failing box pass through."""

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Start a level: index, count, duration_s, dt, t; never the true current."""

    def step(self, values: NDArray[np.float64]) -> Command:
        """Return surge, sway, heave [m/s], yaw rate [rad/s], and the speeds of an arm's joints.

        The array is reused at every step: copy what must be kept.
        """


class Controller(Protocol):
    """The public interface, the same for the built-in controllers and for uploads.

    Built-in controllers also have a `label`, for the form.
    """

    label: ClassVar[str]

    def __init__(self, config: Mapping[str, Any]) -> None: ...

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Reset the state at the start of a level."""

    def step(self, observation: Observation) -> Sequence[float]:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s]."""


@runtime_checkable
class Oracle(Protocol):
    """A reference controller that sees the truth and commands the thrusters itself."""

    def attach(self, plant: "Plant", station: Array, point: tuple[float, float] | None) -> None:
        """Take the plant of a level and the pose, (6,) [m, rad], to hold; before `reset`.

        `point`, (2,) [m] forward and starboard in the body, is the point that counts, if the
        heading does not.
        """

    def commands(self) -> Array:
        """Return the thrusters' commands, (n,) in [-1, 1], after `step`."""


@runtime_checkable
class RouteOracle(Protocol):
    """An `Oracle` that is given the true route."""

    def follow(self, route: Array) -> None:
        """Take the points of a level's route, (k, 3) NED [m]; after `attach`, before `reset`."""


@runtime_checkable
class CameraProgram(Protocol):
    """A `Program` that looks through the camera; one in a box has no such method."""

    def look_through(self, camera: Callable[[], NDArray[np.uint8]]) -> None:
        """Take the function that renders an image, (H, W, 3) in blue, green, red; before `reset`.

        It is the one behind the observation of the present step, so as late as that.
        """


@runtime_checkable
class ImageProgram(Protocol):
    """A `Program` that is given images, where the settings ask for them."""

    def show(self, images: Images) -> None:
        """Take the newest images, before the `step` whose observation is the first with them."""


@runtime_checkable
class Autopilot(Protocol):
    """A `Program` that commands the thrusters itself, in place of the velocity controller."""

    def thrusters(self, plant: "Plant") -> Array:
        """Return the commands, (n,) in [-1, 1], until the next physics step."""


class BuiltIn:
    """A `Program` that runs a built-in controller in this process.

    `oracle` is the controller itself if it is one that sees the truth, else None. A program in a
    box has no such attribute, whatever its methods are called.
    """

    def __init__(
        self,
        name: str,
        config: Configuration,
        arm: ArmSize | None = None,
        *,
        task: str = "",
        search: bool = False,
        route: bool = False,
        dock: bool = False,
    ) -> None:
        """Load a controller; `task` is what it does, if that is not to keep station.

        `search` is whether it is told where the target is to be found, `route` whether it is
        given one to follow, `dock` whether there is one to enter.
        """
        controller = resolve_name(registry.controller_path(name, task))
        self.controller: Controller = controller(config.for_program())
        reference = name in registry.reference_controllers(task)
        sees = reference and isinstance(self.controller, Oracle)
        self.oracle: Oracle | None = self.controller if sees else None
        self._arm = arm
        self._told = {"search": search, "route": route, "dock": dock}
        self._images: Images | None = None

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Reset the controller."""
        self.controller.reset(level)

    def show(self, images: Images) -> None:
        """Take the newest images, which the controller finds in its observation."""
        self._images = images

    def step(self, values: NDArray[np.float64]) -> Command:
        """Return the controller's command as floats: four, and perhaps the speeds of joints."""
        observation = Observation(values, self._arm, self._images, **self._told)
        return tuple(map(float, self.controller.step(observation)))
