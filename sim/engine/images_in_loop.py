"""The images that a program is given: when they are taken, and when they reach it.

The sonar counts as a camera.
"""

import math
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from numpy.typing import NDArray

from seamark.sim.camera.arm_camera import ArmCamera
from seamark.sim.control.observation import ARM_CAMERA, SONAR, Images
from seamark.sim.engine.program import ImageProgram
from seamark.sim.engine.world import World
from seamark.sim.numerics.arrays import Array

Source = Callable[[Array, int], NDArray[Any] | None]  # of motion and frame
PERIOD_S = 0.1  # E: enough to servo a wrist by; each image costs the time of several control steps


def period_steps(control_period_s: float) -> int:
    """Return how many control steps pass from one image to the next."""
    return max(1, round(PERIOD_S / control_period_s))


class Exposure(NamedTuple):
    """An instant at which all cameras take an image."""

    step: int  # control steps since the level began
    t: float  # [s] since the trial began
    motion: Array  # as `Camera` has it, with velocities and joints
    frame: int


class ImagesInLoop:
    """The newest images of one level.

    All cameras take one each PERIOD_S, or at each control step if those are longer apart, and the
    images are as many control steps late as those of the tracker. Until the first ones could have
    arrived, they are there at once, as the tracker's first result is. Nothing is rendered before
    it arrives.
    """

    def __init__(
        self, sources: Mapping[str, Source], *, control_period_s: float, late: int
    ) -> None:
        """Take what renders each camera's image, and by how many control steps that is late."""
        self._sources, self._late = sources, late
        self._every = period_steps(control_period_s)
        self._under_way: deque[Exposure] = deque()
        self.newest: Images = {}
        self.t = 0.0  # [s] at which they were taken
        self._new = False  # whether they have come at the present control step

    def step(self, now: Exposure) -> None:
        """Take images if it is time; `newest` and `t` are then what has arrived."""
        if now.step % self._every == 0:
            self._under_way.append(now)
        arrival = self._under_way[0].step + self._late if self._under_way else math.inf
        self._new = now.step == 0 or now.step >= arrival
        if self._new:
            taken = self._under_way.popleft()
            self.newest = {name: _kept(render, taken) for name, render in self._sources.items()}
            self.t = taken.t

    def show_to(self, program: ImageProgram) -> None:
        """Give a program the newest images, once."""
        if self._new:
            program.show(self.newest)


def _kept(render: Source, taken: Exposure) -> NDArray[Any]:
    image = render(taken.motion, taken.frame)
    assert image is not None  # noqa: S101 - there is an arm's camera, as the settings are checked
    image.flags.writeable = False
    return image


def images_of_program(world: World) -> ImagesInLoop:
    """Return the images of the cameras that the configuration of a level asks for."""
    sources: dict[str, Source] = {}
    for name in world.config.cameras_of_program():
        if name == ARM_CAMERA:
            assert isinstance(world.camera, ArmCamera)  # noqa: S101 - as the settings are checked
            sources[name] = world.camera.grey_on_arm
        elif name == SONAR:
            assert world.sonar is not None  # noqa: S101 - as before
            sources[name] = world.sonar.image
        else:
            sources[name] = world.camera.grey
    return ImagesInLoop(
        sources,
        control_period_s=world.config.control_period_s,
        late=world.conditions.camera_delay_steps,
    )
