"""The messages of ArduPilot's JSON interface for physics.

Source: ArduPilot, libraries/SITL/examples/JSON/readme.md and libraries/SITL/SIM_JSON.cpp. ArduPilot
sends outputs of servos in binary and waits for the state, one line of JSON between line feeds. Its
parser searches for keys as text, so there must be no space after a colon.
"""

import struct
from dataclasses import dataclass

import numpy as np
import orjson

from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.plant import Plant

# magic number -> format: u16 magic, u16 frame rate [Hz], u32 frame count, u16 pulses [µs]
FORMATS = {18458: struct.Struct("<HHI16H"), 29569: struct.Struct("<HHI32H")}
LONGEST_PACKET = 1024  # [B] read of a packet; the longer of the two has 72
GRAVITY = 9.80665  # [m/s²] GRAVITY_MSS of ArduPilot
_MAGIC = struct.Struct("<H")


class NoServos(Exception):
    """A packet that is not one with outputs of servos; the text says why."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Servos:
    """The outputs of ArduPilot's servos in one frame."""

    rate_hz: int  # the frame rate that ArduPilot asks for
    frame: int
    pulses_us: tuple[int, ...]


def read_servos(packet: bytes) -> Servos:
    """Return the outputs of a packet.

    Raises
    ------
    NoServos
        Magic number or length are wrong.
    """
    if len(packet) < _MAGIC.size:
        raise NoServos(f"a packet of {len(packet)} bytes")
    (magic,) = _MAGIC.unpack_from(packet)
    form = FORMATS.get(magic)
    if form is None:
        raise NoServos(f"a packet with the magic number {magic}")
    if len(packet) != form.size:
        raise NoServos(f"a packet of {len(packet)} bytes in place of {form.size}")
    _magic, rate_hz, frame, *pulses_us = form.unpack(packet)
    return Servos(rate_hz=rate_hz, frame=frame, pulses_us=tuple(pulses_us))


def state_line(plant: Plant, *, t_s: float, altitude_m: float, held: bool) -> bytes:
    """Return the state of a vehicle as ArduPilot reads it.

    Parameters
    ----------
    t_s : float [s]
        Time since the connection began; it never goes back.
    altitude_m : float [m]
        Height above the bottom, for the first rangefinder.
    held
        The vehicle is held where it is: its accelerometer measures gravity alone.
    """
    position, quaternion = plant.state[:3], plant.state[3:7]
    velocity, rates = plant.state[7:10], plant.state[10:13]
    rotation = rotation_of(quaternion)
    over_ground = np.zeros(3) if held else plant.acceleration()[:3] + _cross(rates, velocity)
    state = {
        "timestamp": t_s,
        "imu": {
            "gyro": rates.tolist(),
            "accel_body": (over_ground - GRAVITY * rotation[2]).tolist(),
        },
        "position": position.tolist(),
        "attitude": plant.pose()[3:].tolist(),
        "quaternion": quaternion.tolist(),
        "velocity": [_dot(row, velocity) for row in rotation],
        "rng_1": altitude_m,
    }
    return b"\n" + orjson.dumps(state) + b"\n"


def rotation_of(quaternion: Array) -> Array:
    """Return the rotation matrix from body to world, (3, 3), of a quaternion w x y z."""
    w, x, y, z = quaternion.tolist()
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def _cross(a: Array, b: Array) -> Array:
    """Return the cross product of two vectors, (3,), without BLAS."""
    (p, q, r), (u, v, w) = a.tolist(), b.tolist()
    return np.array([q * w - r * v, r * u - p * w, p * v - q * u])


def _dot(a: Array, b: Array) -> float:
    (p, q, r), (u, v, w) = a.tolist(), b.tolist()
    return float(p * u + q * v + r * w)
