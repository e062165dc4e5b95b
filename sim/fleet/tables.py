"""The state of a fleet as structures of arrays: the first index is the vehicle.

What the equations of motion read is in blocks of eight vehicles instead: first the block, last the
lane, which is the vehicle's number modulo eight.

A vehicle with fewer thrusters than another one of the fleet has zeros in their place: a thruster
that gives no thrust adds zeros to sums, which change no bit of a result.
"""

from typing import NamedTuple

import numpy as np

from seamark.sim.control.observation import STARTS
from seamark.sim.control.station_keeper import KEEPER
from seamark.sim.control.velocity_law import AXIS, HOLD, MEASURED, SETTINGS, Records, Thrusters
from seamark.sim.engine.perception import SensorNoises, SensorRecords
from seamark.sim.numerics.arrays import Array, Flags, Integers
from seamark.sim.numerics.lanes import LANES
from seamark.sim.physics.current import Water
from seamark.sim.physics.dynamics import RIGID
from seamark.sim.recording.telemetry import width_for
from seamark.sim.sensors.sensor import SENSOR

COMMAND_NUMBERS = 4  # of a velocity reference; a command for thrusters has one per thruster
WATER_NUMBERS = tuple(name for name in Water._fields if name not in ("law", "drift"))


class Bodies(NamedTuple):
    """The vehicles' parameters in blocks of lanes: `dynamics.Body`, and their thrusters'."""

    mass: Array  # (blocks, 6, 6, 8)
    inverse_mass: Array  # (blocks, 6, 6, 8)
    added: Array  # (blocks, 6, 6, 8)
    linear: Array  # (blocks, 6, 8)
    quadratic: Array  # (blocks, 6, 8)
    allocation: Array  # (blocks, 6, k, 8)
    net_weight: Array  # (blocks, 8)
    moment: Array  # (blocks, 3, 8)
    lag_rate: Array  # (blocks, 8)
    gains: Array  # (blocks, k, 8)
    curve: Array  # (blocks, 16, 8)


class Motion(NamedTuple):
    """Where the vehicles are, the water around them, and how deep they may go without contact."""

    state: Array  # (n, 13 + k)
    command: Array  # (n, k)
    thrust: Array  # (n, k) [N] what the velocity controller wants
    gate: Array  # (blocks, 8) [m]
    water: Array  # (blocks, WATER_NUMBERS, 8)
    law: Integers  # (n,)
    drift: Array  # (n, rows, grid)


class Instruments(NamedTuple):
    """Sensors with the noise of all their readings, and the station keepers."""

    records: SensorRecords  # (n,) each
    noises: SensorNoises  # (n, readings, values)
    keeper: Records  # (n,)


class Controllers(NamedTuple):
    """The velocity controllers, and what they know of the thrusters."""

    measured: Records  # (n,)
    settings: Records  # (n,)
    axes: Records  # (n, 3)
    holds: Records  # (n, 4)
    thrusters: Thrusters  # each with a first index of n
    limits: Array  # (n, 2) [N] most thrust forward, reverse
    thruster_count: Integers  # (n,)


class Progress(NamedTuple):
    """How far the vehicles are, and what is on its way with a delay."""

    step: Integers  # (n,) control steps since the level began
    trial_level: Integers  # (n, 2)
    start_s: Array  # (n,) time at which the level begins
    late: Integers  # (n, 2) control steps by which images and commands are late
    images: Array  # (n, slots, 9) corners and whether the tracker had the target
    commands: Array  # (n, slots, 4 or k)
    start_error: Array  # (n, 8) [px] of the corners with which the tracker starts


class Outputs(NamedTuple):
    """What a control step gives."""

    corners: Array  # (n, 8) [px] by the tracker
    visible: Flags  # (n,) whether it has the target
    rows: Array  # (n, width) of telemetry
    observation: Array  # (n, size)
    reward: Array  # (n,)
    diverged: Flags  # (n,)
    touching: Flags  # (n,) to be advanced again by the plant, which knows contacts
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


class Sizes(NamedTuple):
    """Lengths that all vehicles of a fleet share."""

    vehicles: int
    thrusters: int  # of the vehicle with most
    command: int  # numbers
    image_slots: int
    command_slots: int
    drift: tuple[int, int]  # rows and grid of the gusts, or of the table
    readings: tuple[int, int, int, int]  # of DVL, depth gauge, AHRS, altimeter

    def blocks(self) -> int:
        """Return how many blocks of lanes hold the vehicles."""
        return -(-self.vehicles // LANES)


def empty_tables(sizes: Sizes) -> Tables:
    """Return tables of zeros."""
    n, k, blocks = sizes.vehicles, sizes.thrusters, sizes.blocks()
    return Tables(
        _bodies(blocks, k),
        Motion(
            state=np.zeros((n, RIGID + k)),
            command=np.zeros((n, k)),
            thrust=np.zeros((n, k)),
            gate=np.zeros((blocks, LANES)),
            water=np.zeros((blocks, len(WATER_NUMBERS), LANES)),
            law=np.zeros(n, np.int64),
            drift=np.zeros((n, *sizes.drift)),
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


def _bodies(blocks: int, k: int) -> Bodies:
    return Bodies(
        mass=np.zeros((blocks, 6, 6, LANES)),
        inverse_mass=np.zeros((blocks, 6, 6, LANES)),
        added=np.zeros((blocks, 6, 6, LANES)),
        linear=np.zeros((blocks, 6, LANES)),
        quadratic=np.zeros((blocks, 6, LANES)),
        allocation=np.zeros((blocks, 6, k, LANES)),
        net_weight=np.zeros((blocks, LANES)),
        moment=np.zeros((blocks, 3, LANES)),
        lag_rate=np.zeros((blocks, LANES)),
        gains=np.zeros((blocks, k, LANES)),
        curve=np.zeros((blocks, 16, LANES)),
    )


def _instruments(n: int, readings: tuple[int, int, int, int]) -> Instruments:
    dvl, depth, ahrs, altimeter = readings
    return Instruments(
        records=SensorRecords(
            dvl=np.zeros(n, SENSOR),
            depth=np.zeros(n, SENSOR),
            ahrs=np.zeros(n, SENSOR),
            altimeter=np.zeros(n, SENSOR),
        ),
        noises=SensorNoises(
            dvl=np.zeros((n, dvl, 4)),
            depth=np.zeros((n, depth, 1)),
            ahrs=np.zeros((n, ahrs, 6)),
            altimeter=np.zeros((n, altimeter, 1)),
        ),
        keeper=np.zeros(n, KEEPER),
    )


def _controllers(n: int, k: int) -> Controllers:
    return Controllers(
        measured=np.zeros(n, MEASURED),
        settings=np.zeros(n, SETTINGS),
        axes=np.zeros((n, 3), AXIS),
        holds=np.zeros((n, 4), HOLD),
        thrusters=Thrusters(
            allocator=np.zeros((n, k, 6)),
            directions=np.zeros((n, k, 3)),
            efforts=np.zeros((n, k, 3)),
            curve=np.zeros((n, 16)),
        ),
        limits=np.zeros((n, 2)),
        thruster_count=np.zeros(n, np.int64),
    )


def _progress(sizes: Sizes) -> Progress:
    n = sizes.vehicles
    return Progress(
        step=np.zeros(n, np.int64),
        trial_level=np.zeros((n, 2), np.int64),
        start_s=np.zeros(n),
        late=np.zeros((n, 2), np.int64),
        images=np.zeros((n, sizes.image_slots, 9)),
        commands=np.zeros((n, sizes.command_slots, sizes.command)),
        start_error=np.zeros((n, 8)),
    )
