"""The camera of a vehicle that has an arm, which it sees, and the camera on that arm."""

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.bodies import Bodies, Placed
from seamark.sim.camera.camera import Camera, Window
from seamark.sim.camera.effects import Effects
from seamark.sim.camera.link_camera import LinkCamera, downward, lamp_beside
from seamark.sim.camera.optics import VISIBILITY, Optics
from seamark.sim.camera.target import Target
from seamark.sim.camera.water import Water
from seamark.sim.multibody.assembly import Mounting, assemble
from seamark.sim.multibody.posture import Posture
from seamark.sim.numerics.arrays import Array
from seamark.sim.vehicles import Vehicle

ON_ARM = VISIBILITY  # E: a small camera with the field of view of the vehicle's
_OTHER_NOISE = 0x5DEECE66D  # of the camera on the arm


class ArmCamera(Camera):
    """`Camera` where the vehicle has an arm: an image depends on its joints, too.

    A pose is (12 + 2 a,): that of the vehicle with its velocities, coordinates of the joints of the
    arm's motors [rad or m], and their speeds.
    """

    def __init__(
        self,
        optics: Optics,
        water: Water,
        target: Target,
        carried: tuple[Vehicle, Mounting],
        *,
        noise_seed: int,
        effects: Effects | None = None,
    ) -> None:
        """Set up the cameras of a vehicle and of the arm that it carries."""
        super().__init__(optics, water, target, noise_seed=noise_seed, effects=effects)
        vehicle, mounting = carried
        assembly = assemble(vehicle, [mounting], bottom=False)
        links = [link.name for link in assembly.mechanism.links]
        self._posture = Posture(assembly)
        hull = len(vehicle.drawn())  # which the vehicle's camera has behind it
        bodies = Bodies(assembly.looks[hull:], links, target=target)
        self._eye = LinkCamera(
            optics,
            water,
            bodies,
            mount=downward(optics),
            seabed_m=target.seabed_m,
            noise_seed=noise_seed,
            effects=effects,
        )
        self._on_arm = None
        if assembly.camera is not None:
            self._on_arm = LinkCamera(
                ON_ARM,
                water,
                Bodies(assembly.looks, links, target=target),
                mount=assembly.camera,
                seabed_m=target.seabed_m,
                noise_seed=noise_seed ^ _OTHER_NOISE,
                lamp=lamp_beside(downward(optics)),
                effects=effects,
            )

    def colour_on_arm(self, pose: Array, frame: int) -> NDArray[np.uint8] | None:
        """Return a new image (H, W, 3) in blue, green, red; None without a camera on the arm."""
        return None if self._on_arm is None else self._on_arm.colour(self._placed(pose), frame)

    def grey_on_arm(self, pose: Array, frame: int) -> NDArray[np.uint8] | None:
        """Return a new image (H, W): the one that programs get; None without a camera there."""
        return None if self._on_arm is None else self._on_arm.grey(self._placed(pose), frame)

    def _placed(self, pose: Array) -> Placed:
        return Placed(*self._posture.place(pose))

    def _draw(
        self, pose: Array, frame: int, window: Window, number: int, out: NDArray[np.uint8]
    ) -> None:
        self._eye.draw(self._placed(pose), frame, window, number, out)
