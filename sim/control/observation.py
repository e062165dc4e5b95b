"""The observation that a program gets at each control step, and how it is packed into numbers.

The layout is data: the simulator packs by it and the sandbox unpacks by it, in every language.
Ground truth is never part of an observation.
"""

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamark.sim.vehicles import load
from seamark.sim.vehicles.linkage import Linkage

# As many numbers as the vehicle has thrusters, as its arm has motors, or as its hand has feelers.
PER_THRUSTER, PER_MOTOR, PER_FEELER = -1, -2, -3

# name, count (0: a single number), unit, meaning
FIELDS: tuple[tuple[str, int, str, str], ...] = (
    ("t", 0, "s", "simulated time since the trial began"),
    ("dt", 0, "s", "time between two steps"),
    (
        "error",
        3,
        "m",
        "position error: how far to move, body frame (x forward, y starboard, z down); on a route, "
        "to a point ahead, by the built-in navigation",
    ),
    ("error_px", 2, "px", "tracked target minus image centre (x right, y down)"),
    (
        "target_visible",
        0,
        "",
        "whether the tracker has the target now; of a pipe, the detector; always on another route",
    ),
    ("target_age", 0, "s", "time since the tracker last had the target"),
    ("velocity", 3, "m/s", "last velocity over ground from the DVL, body frame"),
    ("velocity_valid", 0, "", "whether the last DVL measurement was good"),
    ("depth", 0, "m", "depth of the vehicle"),
    ("altitude", 0, "m", "height of the vehicle above the bottom"),
    ("attitude", 3, "rad", "roll, pitch, yaw"),
    ("rates", 3, "rad/s", "p, q, r"),
    ("thrust", PER_THRUSTER, "N", "last thrust of each thruster; as many as the vehicle has"),
)
# What follows for a vehicle with an arm.
ARM_FIELDS: tuple[tuple[str, int, str, str], ...] = (
    ("corners", 8, "px", "corners of the target by the tracker, x0 y0 to x3 y3, as letters read"),
    ("joints", PER_MOTOR, "rad", "coordinate of each joint with a motor; m if it slides"),
    ("joint_speeds", PER_MOTOR, "rad/s", "speed of each of these joints"),
    ("joint_efforts", PER_MOTOR, "N m", "torque of each motor, from its current; N if it slides"),
    ("wrist_force", 3, "N", "force of the arm on its hand, axes of the force sensor"),
    ("wrist_torque", 3, "N m", "torque of the arm on its hand, axes of the force sensor"),
    ("touch", PER_FEELER, "", "1 for each part of the hand that touches something, else 0"),
)
# What follows where the target has to be found first.
SEARCH_FIELDS: tuple[tuple[str, int, str, str], ...] = (
    ("told", 2, "m", "about where the target is: north and east of where the vehicle started"),
    ("confidence", 0, "", "by the detector, that what the tracker has is the target; 0 to 1"),
)
SEARCH_NUMBERS = sum(count or 1 for _name, count, _unit, _meaning in SEARCH_FIELDS)
ROUTE_POINTS = 32
PIPE = "pipe"  # the kind of a route that is not told, but has to be seen
# What follows where a route has to be followed.
ROUTE_FIELDS: tuple[tuple[str, int, str, str], ...] = (
    (
        "route",
        3 * ROUTE_POINTS,
        "m",
        f"{ROUTE_POINTS} points, the same over a level, joined by straight lines: north and east "
        "of where the vehicle is said to have started, and depth of each; of a pipe, how it would "
        "go on straight",
    ),
    ("fix", 2, "m", "position by the last acoustic fix: north and east of the same place"),
    ("fix_age", 0, "s", "time since it was there; -1 before the first fix"),
    ("fix_sigma", 0, "m", "standard deviation of each of its two numbers"),
    (
        "pipe_offset",
        0,
        "m",
        "how far to starboard of its own direction the pipe is, by where the detector last saw it; "
        "0 on another route",
    ),
    ("pipe_angle", 0, "rad", "of this direction from the bow, clockwise"),
)
ROUTE_NUMBERS = sum(count or 1 for _name, count, _unit, _meaning in ROUTE_FIELDS)
# What follows where a dock has to be entered.
DOCK_FIELDS: tuple[tuple[str, int, str, str], ...] = (
    (
        "dock",
        3,
        "m",
        "where the dock is by its last acoustic answer: north, east and down of where the vehicle "
        "was then",
    ),
    ("dock_age", 0, "s", "time since it was asked; -1 before the first answer"),
    ("dock_sigma", 0, "m", "standard deviation of each of the first two numbers"),
    ("dock_heading", 0, "rad", "heading in which the dock takes a vehicle, from north, clockwise"),
    ("light", 2, "px", "the dock's lamps in the image, minus its centre; the last ones seen"),
    ("light_visible", 0, "", "1 while they are in the image and bright enough, else 0"),
)
DOCK_NUMBERS = sum(count or 1 for _name, count, _unit, _meaning in DOCK_FIELDS)
# What follows where a program is given images (`Observation.images`).
IMAGE_FIELDS: tuple[tuple[str, int, str, str], ...] = (
    ("image_t", 0, "s", "simulated time at which the newest images were taken"),
)
EVERY_FIELD = (*FIELDS, *ARM_FIELDS, *SEARCH_FIELDS, *ROUTE_FIELDS, *DOCK_FIELDS, *IMAGE_FIELDS)
BOOLEANS = ("target_visible", "velocity_valid")
COMMAND = ("surge", "sway", "heave", "yaw_rate")
VEHICLE_CAMERA, ARM_CAMERA = "vehicle", "arm"
SONAR = "sonar"  # its image, (bins, beams), comes as those of cameras do
Images = Mapping[str, NDArray[np.uint8]]  # camera -> its newest image (H, W), grey, read-only


class ArmSize(NamedTuple):
    """How many numbers an arm adds to observation and command."""

    motors: int
    feelers: int

    def count(self, of: int) -> int:
        """Return how many numbers a field has, given its entry in `ARM_FIELDS`."""
        return {PER_MOTOR: self.motors, PER_FEELER: self.feelers}.get(of, of)


def arm_size(arm: Linkage) -> ArmSize:
    """Return how many motors and feelers an arm has."""
    return ArmSize(len(arm.motors()), len(arm.outer))


def _further(
    arm: ArmSize | None, *, images: bool, search: bool, route: bool, dock: bool
) -> Iterator[tuple[str, int]]:
    """Yield name and count of the fields that follow those of every vehicle."""
    for name, of, _unit, _meaning in ARM_FIELDS if arm else ():
        yield name, arm.count(of) if arm else 0
    for name, count, _unit, _meaning in SEARCH_FIELDS if search else ():
        yield name, count
    for name, count, _unit, _meaning in ROUTE_FIELDS if route else ():
        yield name, count
    for name, count, _unit, _meaning in DOCK_FIELDS if dock else ():
        yield name, count
    for name, count, _unit, _meaning in IMAGE_FIELDS if images else ():
        yield name, count


def layout(
    vehicle: str,
    arm: Linkage | None = None,
    images: Mapping[str, tuple[int, int]] | None = None,
    *,
    search: bool = False,
    route: bool = False,
    dock: bool = False,
) -> dict[str, Any]:
    """Return how observations and commands of a vehicle are packed, as plain JSON values.

    `images` are the cameras whose images a program is given, with height and width [px]; `search`
    is whether the target has to be found first, `route` whether one has to be followed, `dock`
    whether one has to be entered.
    """
    thrusters = len(load(vehicle).thrusters)
    fields = [
        [name, thrusters if count == PER_THRUSTER else count]
        for name, count, _unit, _meaning in FIELDS
    ]
    size = None if arm is None else arm_size(arm)
    told = {"search": search, "route": route, "dock": dock}
    fields += map(list, _further(size, images=bool(images), **told))
    packed = {"observation": fields, "command": list(COMMAND), "booleans": list(BOOLEANS)}
    if arm is not None:
        packed |= {"command": [*COMMAND, *arm.motors()], "joint_limits": joint_limits(arm)}
    if images:
        packed |= {"images": [[camera, *size] for camera, size in images.items()]}
    return packed


def joint_limits(arm: Linkage) -> list[float]:
    """Return the fastest speed of each motor of an arm [rad/s or m/s]."""
    speeds = [link.joint.speed for link in arm.links]
    return [speed.scalar for speed in speeds if speed]


def _starts() -> dict[str, int]:
    starts, start = {}, 0
    for name, count, _unit, _meaning in FIELDS:
        starts[name] = start
        start += max(count, 1)
    return starts


STARTS = _starts()  # name -> index of its first number


@cache
def _positions(
    arm: ArmSize | None, *, images: bool, search: bool, route: bool, dock: bool
) -> dict[str, int | slice]:
    """Return name -> index of a single number, or slice of a vector; further ones from the end."""
    after = 0
    further: dict[str, int | slice] = {}
    told = {"search": search, "route": route, "dock": dock}
    for name, count in reversed([*_further(arm, images=images, **told)]):
        further[name] = slice(-after - count, -after or None) if count else -after - 1
        after += count or 1
    ends = {PER_THRUSTER: -after or None}
    own = {
        name: slice(STARTS[name], ends.get(count, STARTS[name] + count)) if count else STARTS[name]
        for name, count, _unit, _meaning in FIELDS
    }
    return own | dict(reversed(further.items()))


def empty(
    thrusters: int,
    arm: ArmSize | None = None,
    *,
    images: bool = False,
    search: bool = False,
    route: bool = False,
    dock: bool = False,
) -> NDArray[np.float64]:
    """Return a packed observation of zeros, (size,), for a vehicle with this many thrusters."""
    further = _further(arm, images=images, search=search, route=route, dock=dock)
    more = sum(count or 1 for _name, count in further)
    return np.zeros(STARTS["thrust"] + thrusters + more)


class Observation(Mapping[str, Any]):
    """One observation by name: `observation.error` and `observation["error"]` are the same.

    Numbers are floats, vectors are read-only arrays of float64, the fields in BOOLEANS are bool.
    `thrust` has one number per thruster of the vehicle. It copies the numbers, so that a
    program may keep it. `images` is there if the program is given images: camera -> image.
    """

    __slots__ = ("_images", "_numbers", "_positions")

    def __init__(
        self,
        values: NDArray[np.float64],
        arm: ArmSize | None = None,
        images: Images | None = None,
        *,
        search: bool = False,
        route: bool = False,
        dock: bool = False,
    ) -> None:
        told = {"search": search, "route": route, "dock": dock}
        self._positions = _positions(arm, images=images is not None, **told)
        self._images = images
        self._numbers = values.copy()
        self._numbers.flags.writeable = False

    def __getitem__(self, name: str) -> Any:  # float, bool, array or images, by the layout
        """Return a field by its name."""
        if name == "images" and self._images is not None:
            return self._images
        field = self._positions[name]
        if isinstance(field, slice):
            return self._numbers[field]
        value = self._numbers.item(field)
        return value != 0.0 if name in BOOLEANS else value

    def __getattr__(self, name: str) -> Any:
        """Return a field by its name."""
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"an observation has no {name}") from None

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names in the order of the layout."""
        yield from self._positions
        if self._images is not None:
            yield "images"

    def __len__(self) -> int:
        """Return the number of fields."""
        return len(self._positions) + (self._images is not None)
