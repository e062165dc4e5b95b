"""The images that a program is given: when they are taken, and when they reach it.

The sonar counts as a camera.
"""

import math
from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.arm_camera import ArmCamera
from seamark.sim.control.observation import ARM_CAMERA, SONAR, Images
from seamark.sim.engine.program import ImageProgram
from seamark.sim.engine.world import World
from seamark.sim.numerics.arrays import Array

PERIOD_S = 0.1  # E: enough to servo a wrist by; each image costs the time of several control steps


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

    def __init__(self, world: World) -> None:
        """Set up the cameras of a level that its configuration asks for."""
        self._camera, self._sonar = world.camera, world.sonar
        self._names = world.config.cameras_of_program()
        self._every = max(1, round(PERIOD_S / world.config.control_period_s))
        self._late = world.conditions.camera_delay_steps
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
            self.newest = {name: self._render(name, taken) for name in self._names}
            self.t = taken.t

    def show_to(self, program: ImageProgram) -> None:
        """Give a program the newest images, once."""
        if self._new:
            program.show(self.newest)

    def _render(self, name: str, taken: Exposure) -> NDArray[np.uint8]:
        if name == ARM_CAMERA:
            assert isinstance(self._camera, ArmCamera)  # noqa: S101 - as the settings are checked
            image = self._camera.grey_on_arm(taken.motion, taken.frame)
            assert image is not None  # noqa: S101 - as before
        elif name == SONAR:
            assert self._sonar is not None  # noqa: S101 - as before
            image = self._sonar.image(taken.motion, taken.frame)
        else:
            image = self._camera.grey(taken.motion, taken.frame)
        image.flags.writeable = False
        return image
