"""ArduPilot's side of its JSON interface, re-created: what SITL sends and how it reads the answer.

It follows libraries/SITL/SIM_JSON.cpp: it waits for each state, sends the same frame again if none
comes, and finds values by searching the text for their keys.
"""

import re
import socket
import struct
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Self

import numpy as np

from seamark.bridge.ardusub.motors import SIGNS
from seamark.bridge.ardusub.packets import rotation_of
from seamark.sim.camera.optics import MOUNT_M
from seamark.sim.camera.target import Target
from seamark.sim.control.observation import STARTS, Observation, empty
from seamark.sim.control.position.pi import Controller
from seamark.sim.control.velocity_controller import VelocityController
from seamark.sim.numerics.arrays import Array
from seamark.sim.settings.experiment import ExperimentSettings
from seamark.sim.vehicles import load

MAGIC, RATE_HZ = 18458, 400
KEYS = {  # name -> section and key, as SIM_JSON.h has them
    "timestamp": ("", "timestamp"),
    "gyro": ("imu", "gyro"),
    "accel_body": ("imu", "accel_body"),
    "position": ("", "position"),
    "attitude": ("", "attitude"),
    "quaternion": ("", "quaternion"),
    "velocity": ("", "velocity"),
    "rng_1": ("", "rng_1"),
}
State = Mapping[str, Array]
Pilot = Callable[[State], list[int]]  # from a state to the pulses of the motors [µs]


def read_state(data: bytes) -> dict[str, Array]:
    """Return the values of the last complete line."""
    assert data.startswith(b"\n")
    assert data.endswith(b"\n")
    text = data.decode("ascii").strip()
    return {name: _value(text, *where) for name, where in KEYS.items()}


def _value(text: str, section: str, key: str) -> Array:
    at = text.index(key, text.index(section) + len(section)) + len(key) + 2  # quote and colon
    numbers = re.match(r"\[?([^]}]*)", text[at:].replace(',"', "}"))
    assert numbers
    return np.array([float(part) for part in numbers[1].split(",")])


class Sitl:
    """Runs frames in a thread, until the end of the context."""

    def __init__(self, port: int, pilot: Pilot, *, repeat: bool = False) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect(("127.0.0.1", port))
        self._socket.settimeout(0.05)
        self._pilot, self._repeat = pilot, repeat
        self.states: list[dict[str, Array]] = []
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()
        self._socket.close()

    def _run(self) -> None:
        pulses = [1500] * 16
        frame = 0
        while True:
            packet = struct.pack("<HHI16H", MAGIC, RATE_HZ, frame, *pulses)
            self._socket.send(packet)
            answer = self._answer()
            if not answer:
                return
            if self._repeat:  # as if the answer had been lost
                self._socket.send(packet)
                assert self._answer() == answer
            self.states.append(read_state(answer))
            frame += 1
            motors = self._pilot(self.states[-1])
            pulses = [*motors, *[1500] * (16 - len(motors))]

    def _answer(self) -> bytes:
        """Wait for an answer; return none at the end of the context."""
        while not self._over.is_set():
            with suppress(TimeoutError):
                return self._socket.recv(65000)
        return b""


class BuiltInPilot:
    """The built-in PI and velocity controller, on what ArduPilot is told."""

    def __init__(self, config: ExperimentSettings) -> None:
        vehicle = load(config.vehicle)
        self._dt = config.control_period_s
        self._steps = config.physics_steps_per_control_step
        self._position = Controller(config.for_program())
        self._velocity = VelocityController(vehicle, config)
        self._observation = empty(len(vehicle.thrusters))
        self._frame = 0
        self._motors = [1500] * len(SIGNS)

    def __call__(self, state: State) -> list[int]:
        """Return the pulses; they change once in a control step."""
        if self._frame % self._steps == 0:
            self._measure(state)
            if self._frame == 0:
                self._velocity.reset()
            reference = self._position.step(Observation(self._observation))
            surge, sway, heave, yaw_rate = reference
            commands = self._velocity.step((surge, sway, heave, yaw_rate), self._dt)
            efforts = [sign * effort for sign, effort in zip(SIGNS, commands, strict=True)]
            self._motors = [round(1500 + 400 * effort) for effort in efforts]
        self._frame += 1
        return self._motors

    def _measure(self, state: State) -> None:
        rotation = rotation_of(state["quaternion"])
        camera = state["position"] + rotation @ np.array(MOUNT_M)
        to_target = Target().top_centre() - camera
        yaw = float(state["attitude"][2])
        c, s = np.cos(yaw), np.sin(yaw)
        error = (c * to_target[0] + s * to_target[1], c * to_target[1] - s * to_target[0], 0.0)
        observation, measured = self._observation, self._velocity.measured[0]
        observation[STARTS["error"] : STARTS["error"] + 3] = error
        observation[STARTS["dt"]], observation[STARTS["target_visible"]] = self._dt, 1.0
        measured["velocity"] = rotation.T @ state["velocity"]
        measured["depth"] = state["position"][2]
        measured["yaw"], measured["yaw_rate"] = yaw, state["gyro"][2]
        measured["tilt"], measured["tilt_rates"] = state["attitude"][:2], state["gyro"][:2]
        measured["fresh"] = 1.0
