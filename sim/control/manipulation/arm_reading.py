"""What controllers know of an arm, from its file and that of its vehicle."""

from seamark.sim.control.manipulation.arm_data import ArmData, Link, Motor, Place, Vector
from seamark.sim.vehicles import Vehicle, model
from seamark.sim.vehicles.linkage import Linkage, LinkData

ENDLESS_RAD = 10.0  # range of a joint without ends


def mount_of(vehicle: Vehicle, arm: str) -> Place:
    """Return where an arm sits on a vehicle that carries it."""
    return _plain(vehicle.mounts[arm])


def data_of(arm: Linkage) -> ArmData:
    """Return what is known of an arm whose joints up to its tool turn or are fixed.

    Raises
    ------
    ValueError
        The arm has no tool, or a joint slides.
    """
    if arm.tool is None:
        raise ValueError(f"{arm.name} has no tool")
    motors, chain = arm.motors(), list[Link]()
    name: str | None = arm.tool.link
    while name is not None:
        link = arm.link(name)
        if link.joint.kind not in ("fixed", "revolute"):
            raise ValueError(f"the joint of {name} does not turn")
        number = motors.index(name) if name in motors else -1
        chain.insert(0, Link(name, _plain(link.joint.place), link.joint.axis, number))
        name = link.parent
    return ArmData(
        motors=tuple(_motor(arm.link(name)) for name in motors),
        chain=tuple(chain),
        tool=_plain(arm.tool.place),
    )


def _motor(link: LinkData) -> Motor:
    joint = link.joint
    low, high = joint.range.value if joint.range else (-ENDLESS_RAD, ENDLESS_RAD)
    fastest = joint.speed.scalar if joint.speed else 0.0
    return Motor(link.name, low, high, fastest, joint.home.scalar if joint.home else 0.0)


def _plain(place: model.Place) -> Place:
    return _vector(place.point.value), _vector(place.turn.value)


def _vector(values: tuple[float, ...]) -> Vector:
    x, y, z = values
    return x, y, z
