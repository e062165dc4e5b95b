"""ArduSub in place of position and velocity controller, as the simulation calls it."""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from seamark.bridge import failures
from seamark.bridge.ardusub.link import Link, Restarted
from seamark.bridge.ardusub.motors import NEUTRAL_US, NO_PULSE, SIGNS, commands_of
from seamark.bridge.ardusub.packets import Servos, state_line
from seamark.sim.control.observation import Observation
from seamark.sim.engine.delay import STILL
from seamark.sim.engine.program import Command
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.plant import Plant


class ArduSub:
    """A `seamark.sim.engine.program.Autopilot` at the other end of a link.

    Every physics step is one frame of ArduPilot: the simulation waits for it, advances, and answers
    with the new state. Before the first step the vehicle is held at its start, so that ArduPilot
    can start, align its estimator and be armed; that time does not count.
    """

    def __init__(self, link: Link, *, wait_for_arming: bool, say: Callable[[str], None]) -> None:
        """Set up; without `wait_for_arming` the run begins with the second frame."""
        self._link, self._say = link, say
        self._wait_for_arming = wait_for_arming
        self._running = False
        self._frames = 0  # that have been answered, or will be after the present step
        self._t_s = self._altitude_m = 0.0

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Do nothing: the autopilot notices that the vehicle is back at its start."""

    def step(self, values: NDArray[np.float64]) -> Command:
        """Return that there is no velocity reference."""
        seen = Observation(values)
        self._t_s, self._altitude_m = seen.t, seen.altitude
        return STILL

    def thrusters(self, plant: Plant) -> Array:
        """Return the commands of the next frame, (8,); raises ProgramEnded."""
        try:
            if not self._running:
                return commands_of(self._first_frame(plant).pulses_us)
            self._reply(plant, held=False)
            return commands_of(self._link.receive().pulses_us)
        except Restarted:
            raise failures.disconnected(
                f"ArduPilot restarted at t = {self._t_s:g} s, before the run was over."
            ) from None

    def _first_frame(self, plant: Plant) -> Servos:
        """Hold the vehicle until the run begins, and return the frame with which it does."""
        while True:
            try:
                servos = self._link.receive()
            except Restarted:  # still being set up
                self._reply(plant, held=True)
                continue
            seen = self._frames > 0  # before its first answer it cannot know what to do
            if seen and (_drives(servos) or not self._wait_for_arming):
                break
            self._reply(plant, held=True)
        self._running = True
        self._say("The run has begun.")
        return servos

    def _reply(self, plant: Plant, *, held: bool) -> None:
        t_s = self._frames * plant.step_s
        self._frames += 1
        self._link.reply(state_line(plant, t_s=t_s, altitude_m=self._altitude_m, held=held))


def _drives(servos: Servos) -> bool:
    """Return whether any thruster is driven: ArduSub is armed and has something to do."""
    return any(pulse not in (NEUTRAL_US, NO_PULSE) for pulse in servos.pulses_us[: len(SIGNS)])
