"""The arms with a tool that vehicles carry, as plain data."""

from typing import NamedTuple

from seamark.sim import registry
from seamark.sim.control.manipulation.arm_data import ArmData, Place
from seamark.sim.control.manipulation.arm_reading import data_of, mount_of
from seamark.sim.vehicles import load
from seamark.sim.vehicles.linkage_reading import load_linkage


class KnownArms(NamedTuple):
    """Arms by their name, and where a vehicle carries one, by the names of both."""

    arms: dict[str, ArmData]
    mounts: dict[tuple[str, str], Place]


def known_arms() -> KnownArms:
    """Return all of the registry; loads neither Numba nor OpenCV."""
    arms = {name: data_of(arm) for name in registry.ARMS if (arm := load_linkage(name)).tool}
    vehicles = map(load, registry.VEHICLES)
    mounts = {
        (vehicle.name, arm): mount_of(vehicle, arm)
        for vehicle in vehicles
        for arm in vehicle.mounts
        if arm in arms
    }
    return KnownArms(arms, mounts)
