"""The imaging sonar of a vehicle: what it sees, and its image of a pose."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.bodies import Bodies, Placed
from seamark.sim.camera.camera import Camera
from seamark.sim.camera.geometry import camera_pose
from seamark.sim.camera.pipe_camera import PipeCamera
from seamark.sim.camera.standing_camera import StandingCamera
from seamark.sim.camera.target import Target
from seamark.sim.multibody.assembly import VEHICLE, Frame, Look, Mounting, assemble
from seamark.sim.multibody.posture import VEHICLE_MOTION, Posture
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.random_streams import Streams
from seamark.sim.physics.pipe import Pipe
from seamark.sim.settings.experiment import ExperimentSettings
from seamark.sim.sonar.acoustics import HARD_DB, power_of_ten
from seamark.sim.sonar.device import Device
from seamark.sim.sonar.display import in_colour
from seamark.sim.sonar.sonar import Sonar, mounted
from seamark.sim.vehicles import Vehicle, load
from seamark.sim.vehicles.matrices import multiplied
from seamark.sim.vehicles.solids import DARK, Solid

FAN_HEIGHT_PX = 480  # as high as an image of the usual camera
_NO_POINT = (0.0, 0.0, 0.0)


class VehicleSonar:
    """A sonar on a vehicle among things that do not move, all of them hard.

    A pose is (6,) north, east, down [m], roll, pitch, yaw [rad]; what follows has no effect.
    """

    def __init__(
        self,
        device: Device,
        target: Target | None,
        things: Sequence[Look] = (),
        *,
        seabed_m: float,
        noise_seed: int,
    ) -> None:
        self.device = device
        bodies = Bodies(things, (VEHICLE,), target=target)
        self._sonar = Sonar(
            *(device, bodies, np.full(len(bodies.shapes.kind), power_of_ten(0.1 * HARD_DB))),
            mount=mounted(device, VEHICLE),
            seabed_m=seabed_m,
            noise_seed=noise_seed,
        )
        self._pose, self._axes = np.zeros(6), np.zeros((3, 3))
        self._placed = Placed(np.zeros((1, 3, 3)), np.zeros((1, 3)), np.zeros((1, 6)))

    def image(self, pose: Array, frame: int) -> NDArray[np.uint8]:
        """Return a new image (bins, beams): the one that programs get."""
        self._pose[:] = pose[:6]
        camera_pose(self._pose, _ORIGIN, self._axes, self._placed.position[0])
        starboard, aft, down = self._axes  # of a camera that looks down
        for column, axis in enumerate((-aft, starboard, down)):
            self._placed.rotation[0, :, column] = axis
        return self._sonar.image(self._placed, frame)

    def fan(self, pose: Array, frame: int) -> NDArray[np.uint8]:
        """Return the image as a fan in colour, (H, W, 3) in blue, green, red, for people."""
        return in_colour(self.image(pose, frame), self.device, height=FAN_HEIGHT_PX)


_ORIGIN = np.zeros(3)


def build_sonar(config: ExperimentSettings, camera: Camera, random: Streams) -> VehicleSonar | None:
    """Return the sonar of a level, if the settings ask for one; it sees what the camera sees."""
    device = config.sonar_device()
    if device is None:
        return None
    target: Target | None = camera.target
    things: Sequence[Look] = ()
    if isinstance(camera, PipeCamera):
        target, things = None, pipe_looks(camera.pipe)
    elif isinstance(camera, StandingCamera):  # the target is a part of what stands there
        target, things = None, standing_looks(load(config.vehicle), camera.workpiece.things)
    return VehicleSonar(
        *(device, target, things),
        seabed_m=camera.target.seabed_m,
        noise_seed=int(random.sonar.integers(2**63)),
    )


def pipe_looks(pipe: Pipe) -> list[Look]:
    """Return what of a pipe is not wholly below the sand; round ends leave no gaps at bends."""
    looks = []
    for k, (start, end) in enumerate(pairwise(pipe.starts_m.tolist())):
        first, last = pipe.axis_m[k], pipe.axis_m[k + 1]
        north, east = ((last - first) / (end - start)).tolist()
        turn = np.array([[north, -east, 0.0], [east, north, 0.0], [0.0, 0.0, 1.0]])
        for begin, stop in _bare(pipe, start, end):
            middle = first + (0.5 * (begin + stop) - start) * np.array([north, east])
            wide = 2.0 * pipe.radius_m
            solid = Solid("capsule", (stop - begin + wide, wide, wide), _NO_POINT, DARK)
            looks.append(Look(Frame(None, np.array([*middle, pipe.seabed_m]), turn), solid))
    return looks


def standing_looks(vehicle: Vehicle, things: Sequence[Mounting]) -> list[Look]:
    """Return what things that do not move look like, in the axes of the world."""
    assembly = assemble(vehicle, things, bottom=False)
    names = [link.name for link in assembly.mechanism.links]
    rotation, position, _ = Posture(assembly).place(np.zeros(VEHICLE_MOTION))
    looks = []
    for look in assembly.looks[len(vehicle.drawn()) :]:
        on = look.on
        if on.link is not None:
            link = names.index(on.link)
            placed = Frame(None, position[link], rotation[link])
            on = Frame(None, placed.at(on.point.tolist()), multiplied(placed.turn, on.turn))
        looks.append(Look(on, look.solid))
    return looks


def _bare(pipe: Pipe, start: float, end: float) -> Iterator[tuple[float, float]]:
    """Yield the parts of a piece, from and to arc lengths, that are not covered."""
    at = start
    for begin, stop in sorted(pipe.covered_m.tolist()):
        if begin < end and stop > at:
            if begin > at:
                yield at, begin
            at = stop
    if at < end:
        yield at, end
