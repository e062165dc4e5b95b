"""The messages of ArduPilot's JSON interface, as its documentation has them."""

import json
import math
import struct

import numpy as np
import pytest

from seamark.bridge.ardusub.motors import SIGNS, commands_of
from seamark.bridge.ardusub.packets import NoServos, read_servos, state_line
from seamark.sim.physics.current import Current
from seamark.sim.physics.plant import Plant
from seamark.sim.vehicles import load
from tests.seamark.bridge.ardusub.sitl import read_state

# A frame of 16 servos, byte by byte as readme.md lays it out: magic number 18458, 400 frames per
# second, frame 7, pulses of 1500 µs but for the first, of 1900 µs.
PACKET = bytes.fromhex("1a489001070000006c07" + 15 * "dc05")
# The state that readme.md gives as an example.
EXAMPLE = (
    '{"timestamp":2500,"imu":{"gyro":[0,0,0],"accel_body":[0,0,0]},'
    '"position":[0,0,0],"attitude":[0,0,0],"velocity":[0,0,0]}'
)
# Of SUB_FRAME_VECTORED_6DOF in AP_Motors6DOF.cpp: roll, pitch, yaw, throttle, forward, lateral.
FACTORS = (
    (0, 0, 1, 0, -1, 1),
    (0, 0, -1, 0, -1, -1),
    (0, 0, -1, 0, 1, 1),
    (0, 0, 1, 0, 1, -1),
    (1, -1, 0, -1, 0, 0),
    (-1, -1, 0, -1, 0, 0),
    (1, 1, 0, -1, 0, 0),
    (-1, 1, 0, -1, 0, 0),
)


def _plant() -> Plant:
    still = Current(0.0, rng=np.random.Generator(np.random.PCG64(0)))
    return Plant(load("bluerov2-heavy"), still, step_s=0.0025)


def test_a_frame_of_16_servos_is_read_byte_by_byte() -> None:
    servos = read_servos(PACKET)

    assert (servos.rate_hz, servos.frame) == (400, 7)
    assert servos.pulses_us == (1900, *[1500] * 15)


def test_a_frame_of_32_servos_is_read() -> None:
    packet = struct.pack("<HHI32H", 29569, 1200, 2**32 - 1, *range(1500, 1532))

    servos = read_servos(packet)

    assert (servos.rate_hz, servos.frame) == (1200, 2**32 - 1)
    assert servos.pulses_us == (*range(1500, 1532),)


@pytest.mark.parametrize("packet", [b"", b"\x1a", PACKET[:-1], PACKET + b"\0", b"{}" + PACKET[2:]])
def test_other_packets_are_refused(packet: bytes) -> None:
    with pytest.raises(NoServos):
        read_servos(packet)


def test_the_state_has_the_form_of_the_published_example() -> None:
    line = state_line(_plant(), t_s=2500.0, altitude_m=1.5, held=True).decode()

    assert line.startswith("\n{")
    assert line.endswith("}\n")
    ours, example = json.loads(line), json.loads(EXAMPLE)
    assert {*example} <= {*ours}
    assert {*example["imu"]} == {*ours["imu"]}
    assert all(len(ours[key]) == len(example[key]) for key in ("position", "attitude", "velocity"))
    assert ours["timestamp"] == example["timestamp"]
    assert " " not in line
    assert read_state(line.encode())["rng_1"] == [1.5]


def test_at_rest_the_accelerometer_measures_gravity_upwards_in_every_attitude() -> None:
    plant = _plant()
    for attitude in ((0.0, 0.0, 0.0), (0.3, 0.0, 1.0), (0.0, -0.4, 2.0)):
        plant.reset(np.array([1.0, 2.0, 3.0, *attitude]))
        state = read_state(state_line(plant, t_s=0.0, altitude_m=0.0, held=True))
        roll, pitch, _yaw = attitude
        up = (
            math.sin(pitch),
            -math.sin(roll) * math.cos(pitch),
            -math.cos(roll) * math.cos(pitch),
        )
        assert np.allclose(state["accel_body"], 9.80665 * np.array(up), atol=1e-12)
        assert np.allclose(state["attitude"], attitude, atol=1e-12)


def test_the_state_agrees_with_its_own_derivatives() -> None:
    plant = _plant()
    plant.reset(np.array([0.0, 0.0, 3.0, 0.2, 0.1, 0.7]))
    command = commands_of([1700, 1450, 1550, 1600, 1580, 1500, 1500, 1620])
    plant.advance(0, command, 400)  # 1 s: it moves and turns
    states = []
    for step in range(400, 402):
        line = state_line(plant, t_s=step * plant.step_s, altitude_m=0.0, held=False)
        states.append(read_state(line) | {"rotation": _rotation(plant)})
        plant.advance(step, command, 1)

    before, after = states
    dt = after["timestamp"] - before["timestamp"]
    mean = 0.5 * (before["velocity"] + after["velocity"])
    assert np.allclose((after["position"] - before["position"]) / dt, mean, atol=1e-5)
    change = (after["velocity"] - before["velocity"]) / dt
    felt = before["rotation"] @ before["accel_body"] + np.array([0.0, 0.0, 9.80665])
    assert np.allclose(change, felt, atol=0.02)
    assert np.linalg.norm(change) > 0.05


def _rotation(plant: Plant) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    from scipy.spatial.transform import Rotation

    w, x, y, z = plant.state[3:7]
    matrix: np.ndarray[tuple[int, ...], np.dtype[np.float64]] = Rotation.from_quat(
        [x, y, z, w]
    ).as_matrix()
    return matrix


@pytest.mark.parametrize("motor", range(8))
def test_a_positive_output_pushes_as_the_factors_of_ardusub_say(motor: int) -> None:
    allocation = load("bluerov2-heavy").allocation()
    x, y, z, k, m, n = SIGNS[motor] * allocation[:, motor]

    roll, pitch, yaw, throttle, forward, lateral = FACTORS[motor]

    assert np.array_equal(np.sign([x, y]), [forward, lateral])
    assert np.sign(z) == -throttle  # throttle is upwards
    if throttle:
        assert np.array_equal(np.sign([k, m]), [roll, pitch])
    else:
        assert np.sign(n) == yaw


def test_pulses_become_commands_within_their_span() -> None:
    assert commands_of([1500, 0, 1900, 2200, 1100, 900, 1700, 1400, 1999]).tolist() == [
        *(-0.0, 0.0, 1.0, 1.0, -1.0, -1.0, 0.5, -0.25)
    ]
    assert commands_of([1900, 1100, *[1500] * 6]).tolist()[:2] == [-1.0, 1.0]
