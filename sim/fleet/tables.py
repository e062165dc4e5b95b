"""The state of a fleet as structures of arrays: the first index is always the vehicle.

A vehicle with fewer thrusters than another one of the fleet has zeros in their place: a thruster
that gives no thrust adds zeros to sums, which change no bit of a result.
"""

from typing import Any, NamedTuple

import numpy as np

from seamark.sim.control.observation import STARTS
from seamark.sim.control.station_keeper import KEEPER
from seamark.sim.control.velocity_law import AXIS, HOLD, MEASURED, SETTINGS, Records
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.current import Water
from seamark.sim.physics.dynamics import RIGID
from seamark.sim.recording.telemetry import width_for
from seamark.sim.sensors.sensor import SENSOR

COMMAND_NUMBERS = 4  # of a velocity reference; a command for thrusters has one per thruster
WATER_NUMBERS = tuple(name for name in Water._fields if name not in ("law", "drift"))


class Bodies(NamedTuple):
    """The vehicles' parameters: those of `dynamics.Body`, and what belongs to their thrusters."""

    mass: Array  # (n, 6, 6)
    inverse_mass: Array  # (n, 6, 6)
    added: Array  # (n, 6, 6)
    linear: Array  # (n, 6)
    quadratic: Array  # (n, 6)
    allocation: Array  # (n, 6, k)
    net_weight: Array  # (n,)
    moment: Array  # (n, 3)
    lag_rate: Array  # (n,)
    gains: Array  # (n, k)
    curve: Array  # (n, 16)
    limits: Array  # (n, 2) [N] most thrust forward, reverse
    thrusters: Any  # (n,) int64: how many there are


class Motion(NamedTuple):
    """Where the vehicles are, the water around them, and how deep they may go without contact."""

    state: Array  # (n, 13 + k)
    before: Array  # (n, 13 + k) at the start of the control step
    target: Array  # (n, k) [N] steady thrusts
    command: Array  # (n, k)
    thrust: Array  # (n, k) [N] what the velocity controller wants
    gate: Array  # (n,) [m]
    water: Array  # (n, WATER_NUMBERS)
    law: Any  # (n,) int64
    drift: Array  # (n, 2, grid)


class Instruments(NamedTuple):
    """Sensors with the noise of all their readings, and the station keepers."""

    dvl: Records
    depth: Records
    ahrs: Records
    altimeter: Records
    dvl_noise: Array
    depth_noise: Array
    ahrs_noise: Array
    altimeter_noise: Array
    keeper: Records  # (n,)


class Controllers(NamedTuple):
    """The velocity controllers."""

    measured: Records  # (n,)
    settings: Records  # (n,)
    axes: Records  # (n, 3)
    holds: Records  # (n, 4)
    allocator: Array  # (n, k, 6)
    directions: Array  # (n, k, 3)
    efforts: Array  # (n, k, 3)


class Progress(NamedTuple):
    """How far the vehicles are, and what is on its way with a delay."""

    step: Any  # (n,) int64: control steps since the level began
    place: Any  # (n, 2) int64: trial and level
    start_s: Array  # (n,) time at which the level begins
    late: Any  # (n, 2) int64: control steps by which images and commands are late
    images: Array  # (n, slots, 9) corners and whether the tracker had the target
    commands: Array  # (n, slots, 4 or k)
    start_error: Array  # (n, 8) [px] of the corners with which the tracker starts


class Outputs(NamedTuple):
    """What a control step gives."""

    corners: Array  # (n, 8) [px] by the tracker
    visible: Any  # (n,) bool: whether it has the target
    rows: Array  # (n, width) of telemetry
    observation: Array  # (n, size)
    reward: Array  # (n,)
    diverged: Any  # (n,) bool
    touching: Any  # (n,) bool: to be advanced again by the plant, which knows contacts
    contact_n: Array  # (n,) [N]
    pose: Array  # (n, 6)


class Tables(NamedTuple):
    """All of it."""

    bodies: Bodies
    motion: Motion
    instruments: Instruments
    controllers: Controllers
    progress: Progress
    outputs: Outputs

    def plain(self) -> tuple[tuple[Any, ...], ...]:
        """Return plain tuples: passing named ones to Numba takes several times as long."""
        return tuple(tuple(group) for group in self)


class Sizes(NamedTuple):
    """Lengths that all vehicles of a fleet share."""

    vehicles: int
    thrusters: int  # of the vehicle with most
    command: int  # numbers
    image_slots: int
    command_slots: int
    grid: int  # of the gusts
    readings: tuple[int, int, int, int]  # of DVL, depth gauge, AHRS, altimeter


def empty_tables(sizes: Sizes) -> Tables:
    """Return tables of zeros."""
    n, k = sizes.vehicles, sizes.thrusters
    return Tables(
        _bodies(n, k),
        Motion(
            state=np.zeros((n, RIGID + k)),
            before=np.zeros((n, RIGID + k)),
            target=np.zeros((n, k)),
            command=np.zeros((n, k)),
            thrust=np.zeros((n, k)),
            gate=np.zeros(n),
            water=np.zeros((n, len(WATER_NUMBERS))),
            law=np.zeros(n, np.int64),
            drift=np.zeros((n, 2, sizes.grid)),
        ),
        _instruments(n, sizes.readings),
        _controllers(n, k),
        _progress(sizes),
        Outputs(
            corners=np.zeros((n, 8)),
            visible=np.zeros(n, np.bool_),
            rows=np.zeros((n, width_for(k))),
            observation=np.zeros((n, STARTS["thrust"] + k)),
            reward=np.zeros(n),
            diverged=np.zeros(n, np.bool_),
            touching=np.zeros(n, np.bool_),
            contact_n=np.zeros(n),
            pose=np.zeros((n, 6)),
        ),
    )


def _bodies(n: int, k: int) -> Bodies:
    return Bodies(
        mass=np.zeros((n, 6, 6)),
        inverse_mass=np.zeros((n, 6, 6)),
        added=np.zeros((n, 6, 6)),
        linear=np.zeros((n, 6)),
        quadratic=np.zeros((n, 6)),
        allocation=np.zeros((n, 6, k)),
        net_weight=np.zeros(n),
        moment=np.zeros((n, 3)),
        lag_rate=np.zeros(n),
        gains=np.zeros((n, k)),
        curve=np.zeros((n, 16)),
        limits=np.zeros((n, 2)),
        thrusters=np.zeros(n, np.int64),
    )


def _instruments(n: int, readings: tuple[int, int, int, int]) -> Instruments:
    dvl, depth, ahrs, altimeter = readings
    return Instruments(
        dvl=np.zeros(n, SENSOR),
        depth=np.zeros(n, SENSOR),
        ahrs=np.zeros(n, SENSOR),
        altimeter=np.zeros(n, SENSOR),
        dvl_noise=np.zeros((n, dvl, 4)),
        depth_noise=np.zeros((n, depth, 1)),
        ahrs_noise=np.zeros((n, ahrs, 6)),
        altimeter_noise=np.zeros((n, altimeter, 1)),
        keeper=np.zeros(n, KEEPER),
    )


def _controllers(n: int, k: int) -> Controllers:
    return Controllers(
        measured=np.zeros(n, MEASURED),
        settings=np.zeros(n, SETTINGS),
        axes=np.zeros((n, 3), AXIS),
        holds=np.zeros((n, 4), HOLD),
        allocator=np.zeros((n, k, 6)),
        directions=np.zeros((n, k, 3)),
        efforts=np.zeros((n, k, 3)),
    )


def _progress(sizes: Sizes) -> Progress:
    n = sizes.vehicles
    return Progress(
        step=np.zeros(n, np.int64),
        place=np.zeros((n, 2), np.int64),
        start_s=np.zeros(n),
        late=np.zeros((n, 2), np.int64),
        images=np.zeros((n, sizes.image_slots, 9)),
        commands=np.zeros((n, sizes.command_slots, sizes.command)),
        start_error=np.zeros((n, 8)),
    )
