"""The camera of a vehicle without an arm above a target among things that stand on the seabed."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.bodies import Bodies, Placed
from seamark.sim.camera.camera import Camera, Window
from seamark.sim.camera.effects import Effects
from seamark.sim.camera.link_camera import LinkCamera, downward
from seamark.sim.camera.optics import Optics
from seamark.sim.camera.target import Target
from seamark.sim.camera.water import Water
from seamark.sim.multibody.assembly import Frame, Mounting, assemble
from seamark.sim.multibody.posture import VEHICLE_MOTION, Posture
from seamark.sim.multibody.workpiece import Workpiece
from seamark.sim.numerics.arrays import Array
from seamark.sim.vehicles import Vehicle


class StandingCamera(Camera):
    """`Camera` where the target is a part of things that stand there, which may hide it."""

    def __init__(
        self,
        optics: Optics,
        water: Water,
        target: Target,
        things: Sequence[Mounting],
        vehicle: Vehicle,
        *,
        noise_seed: int,
        effects: Effects | None = None,
    ) -> None:
        """Set up the camera of a vehicle; no link of the things moves."""
        super().__init__(optics, water, target, noise_seed=noise_seed, effects=effects)
        axes = np.column_stack([*target.axes(), [0.0, 0.0, 1.0]])
        # As scenes show it: nothing of it moves, and its face is the target.
        self.workpiece = Workpiece(
            things=tuple(things),
            link="",
            shapes=(),
            grip=(0.0, 0.0, 0.0),
            face=Frame(None, target.top_centre(), axes),
            size_m=(target.length_m, target.width_m),
        )
        assembly = assemble(vehicle, things, bottom=False)
        self._posture, self._moving = Posture(assembly), np.zeros(VEHICLE_MOTION)
        hull = len(vehicle.drawn())  # which the camera has behind it
        links = [link.name for link in assembly.mechanism.links]
        self._eye = LinkCamera(
            optics,
            water,
            Bodies(assembly.looks[hull:], links),
            mount=downward(optics),
            seabed_m=target.seabed_m,
            noise_seed=noise_seed,
            effects=effects,
        )

    def _draw(
        self, pose: Array, frame: int, window: Window, number: int, out: NDArray[np.uint8]
    ) -> None:
        self._moving[:] = 0.0  # a pose without velocities is one at rest
        self._moving[: len(pose)] = pose
        self._eye.draw(Placed(*self._posture.place(self._moving)), frame, window, number, out)
