"""ArduPilot's side, re-created, flies the plant over its protocol."""

import socket
import struct
from typing import Any

import numpy as np
import pytest

from seamark.bridge.ardusub.link import Link
from seamark.bridge.ardusub.program import ArduSub
from seamark.programs.failure_reasons import FailureReason
from seamark.sim import registry
from seamark.sim.numerics.arrays import Array
from seamark.sim.recording.telemetry import INDEX
from seamark.worker.evaluation.local import Callbacks, evaluate_locally
from tests.seamark.bridge.ardusub.sitl import BuiltInPilot, Sitl, State
from tests.seamark.bridge.conftest import BENCHMARK, SEED, Running, configuration

NOISE = dict.fromkeys(("dvl_sigma_m_s", "depth_sigma_m", "ahrs_sigma_rad"), 0)
ALIKE: dict[str, Any] = {
    "vehicle": "bluerov2-heavy",
    "levels": [0.3],
    "level_duration_s": 20,
    "settle_s": 5,
    "dvl_rate_hz": 20,  # ArduPilot is told everything in every step
    **NOISE,
}
PLACE = slice(INDEX["x"], INDEX["z"] + 1)


def _link(said: list[str], answer_within_s: float = 30.0) -> Link:
    return Link("127.0.0.1", 0, answer_within_s=answer_within_s, say=said.append)


def _built_in(name: str) -> Array:
    """Return the path of a built-in controller, (n, 3) [m]."""
    rows: list[Array] = []
    evaluate_locally(
        BENCHMARK,
        configuration(**ALIKE),
        seed=SEED,
        controller=name,
        callbacks=Callbacks(rows=lambda some: rows.append(some.copy())),
    )
    return np.concatenate(rows)[:, PLACE]


@pytest.mark.slow
def test_the_built_in_pi_behind_the_protocol_has_the_path_of_the_built_in_one() -> None:
    config: Any = registry.benchmark(BENCHMARK).restore(configuration(**ALIKE))
    rows: list[Array] = []
    with _link([]) as link:
        program = ArduSub(link, wait_for_arming=False, say=lambda _sentence: None)
        running = Running(program, rows=lambda some: rows.append(some.copy()), **ALIKE)
        with Sitl(link.port, BuiltInPilot(config)):
            outcome = running.outcome()

    path, expected, without = np.concatenate(rows)[:, PLACE], _built_in("pi"), _built_in("nothing")
    assert outcome.failure is None
    assert len(path) == len(expected)
    apart_m = np.abs(path - expected).max()
    assert apart_m < 0.005  # pulses are whole microseconds, 1/400 of the span
    assert np.abs(without - expected).max() > 20 * apart_m


def _push(state: State) -> list[int]:
    return [1600] * 4 if state["timestamp"][0] >= 0.05 else [1500] * 4


def test_the_vehicle_is_held_until_a_thruster_is_driven_and_lost_answers_are_repeated() -> None:
    digests = set()
    for repeat in (False, True):
        said: list[str] = []
        with _link(said) as link:
            program = ArduSub(link, wait_for_arming=True, say=said.append)
            running = Running(program, vehicle="bluerov2-heavy", levels=[0.3])
            with Sitl(link.port, _push, repeat=repeat) as sitl:
                outcome = running.outcome()
        digests.add(outcome.digest)
        held = sitl.states[:6]
        times = [float(state["timestamp"][0]) for state in sitl.states]
        assert np.allclose(np.diff(times), 0.01)
        assert all(np.array_equal(s["position"], held[0]["position"]) for s in held)
        assert not np.array_equal(sitl.states[7]["position"], held[0]["position"])
        assert len(sitl.states) == 6 + 200 - 1  # the last step has no answer any more
        assert said[-1] == "The run has begun."

    assert len(digests) == 1


def test_other_packets_and_other_senders_are_ignored() -> None:
    said: list[str] = []
    with _link(said) as link, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        program = ArduSub(link, wait_for_arming=False, say=lambda _sentence: None)

        def pilot(_state: State) -> list[int]:
            stranger.sendto(b"hello", ("127.0.0.1", link.port))
            late = struct.pack("<HHI16H", 18458, 400, 10**6, *[1900] * 16)
            stranger.sendto(late, ("127.0.0.1", link.port))
            return [1500] * 8

        running = Running(program, vehicle="bluerov2-heavy", levels=[0.3])
        with Sitl(link.port, pilot) as sitl:
            assert running.outcome().failure is None

    assert len(sitl.states) == 200
    assert [line for line in said if "Ignored" in line] == [
        "Ignored a packet with the magic number 25960: not from ArduPilot's JSON interface."
    ]


@pytest.mark.slow
def test_an_autopilot_that_falls_silent_ends_the_run() -> None:
    with _link([], answer_within_s=0.2) as link:
        program = ArduSub(link, wait_for_arming=False, say=lambda _sentence: None)
        running = Running(program, vehicle="bluerov2-heavy", levels=[0.3])
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sitl:
            sitl.sendto(
                struct.pack("<HHI16H", 18458, 400, 0, *[1500] * 16), ("127.0.0.1", link.port)
            )
            outcome = running.outcome()

    assert outcome.failure is FailureReason.TIME_LIMIT
    assert outcome.sentence == "ArduPilot sent no frame within 0.2 s."


@pytest.mark.parametrize("begun", [False, True])
def test_an_autopilot_that_restarts_may_begin_again_only_before_the_run(begun: bool) -> None:
    with _link([]) as link:
        program = ArduSub(link, wait_for_arming=True, say=lambda _sentence: None)
        running = Running(program, vehicle="bluerov2-heavy", levels=[0.3])
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sitl:
            sitl.settimeout(30)
            sitl.connect(("127.0.0.1", link.port))
            for frame, pulse in ((0, 1500), (1, 1600 if begun else 1500), (2, 1500), (0, 1500)):
                sitl.send(struct.pack("<HHI16H", 18458, 400, frame, *[pulse] * 16))
                if frame or not begun:
                    sitl.recv(65000)
            if not begun:
                sitl.send(struct.pack("<HHI16H", 18458, 400, 1, *[1600] * 16))
                sitl.recv(65000)
                sitl.send(struct.pack("<HHI16H", 18458, 400, 0, *[1600] * 16))
            outcome = running.outcome()

    assert outcome.failure is FailureReason.USER_ERROR
    assert outcome.sentence == "ArduPilot restarted at t = 0 s, before the run was over."
