"""The example that trains with PPO: what its policy sees, and what its archive does in a box."""

import runpy
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest
from numpy.typing import NDArray
from onnx import numpy_helper

from seamark.gym.spaces import named
from seamark.sandbox.isolation.level import IsolationLevel

EXAMPLE = Path(__file__).parents[3] / "examples" / "ppo"
FEATURES = runpy.run_path(str(EXAMPLE / "features.py"))
Array = NDArray[Any]


@pytest.fixture
def packing(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What packs the example, which imports a neighbour by a name that others have, too."""
    monkeypatch.syspath_prepend(EXAMPLE)
    monkeypatch.delitem(sys.modules, "features", raising=False)
    found = runpy.run_path(str(EXAMPLE / "packing.py"))
    del sys.modules["features"]
    return found


def seen(count: int, *, vehicles: int = 2) -> Array:
    """Return observations (count, vehicles, 29), the first vehicle with five thrusters."""
    observations = np.random.default_rng(1).normal(0.0, 0.3, (count, vehicles, 29))
    observations[..., 7] = 1.0
    observations[:, 0, 26:] = 0.0
    return observations


def test_a_vehicle_that_turned_about_its_tool_has_no_error() -> None:
    yaw, radius = np.array([-0.9, 0.0, 1.2]), 1.0
    camera = np.stack(
        [radius - radius * np.cos(yaw), -radius * np.sin(yaw)], axis=1
    )  # from station
    observations = np.zeros((3, 29))
    observations[:, 2:4], observations[:, 17] = FEATURES["rotated"](-yaw, -camera), yaw

    np.testing.assert_allclose(FEATURES["tool_error"](observations), 0.0, atol=1e-12)


def test_an_action_that_turns_alone_does_not_move_the_tool() -> None:
    forward, starboard = FEATURES["TOOL_M"]

    [[surge, sway, heave, rate]] = FEATURES["Features"](1).command(np.array([[0.0, 0.0, 1.0]]))

    assert rate == FEATURES["FASTEST_TURN"]
    assert (surge - rate * starboard, sway + rate * forward, heave) == (0.0, 0.0, 0.0)


def test_a_vehicle_alone_has_the_features_that_it_has_among_others() -> None:
    both, alone = FEATURES["Features"](2), [FEATURES["Features"](1) for _ in range(2)]
    random = np.random.default_rng(2)
    for observations in seen(20):
        together = both.see(observations, np.arange(2))
        actions = random.uniform(-2.0, 2.0, (2, FEATURES["ACTIONS"]))
        both.command(actions)

        for i, one in enumerate(alone):
            told = observations[i, : 26 + 3 * i]
            by_itself = one.see(FEATURES["row"](named(told)), np.array([0]))
            one.command(actions[i : i + 1])
            np.testing.assert_array_equal(by_itself[0], together[i])
        assert together.shape == (2, FEATURES["FEATURES"])
        assert together.dtype == np.float32


def test_a_level_forgets_what_was_seen_in_the_one_before() -> None:
    features = FEATURES["Features"](2)
    first = features.see(seen(1)[0], np.arange(2))
    for observations in seen(5):
        features.see(observations, np.arange(2))
        features.command(np.ones((2, FEATURES["ACTIONS"])))

    features.forget(np.array([1]))

    again = features.see(seen(1)[0], np.arange(2))
    np.testing.assert_array_equal(again[1], first[1])
    assert not np.array_equal(again[0], first[0])


def forward(network: bytes, features: Array) -> Array:
    """Return the actions of a network in ONNX's format, computed in float64."""
    stored = {
        each.name: numpy_helper.to_array(each).astype(np.float64)
        for each in onnx.load_from_string(network).graph.initializer
    }
    x = features
    for number in range(len(stored) // 2):
        x = (np.tanh(x) if number else x) @ stored[f"weights{number}"] + stored[f"biases{number}"]
    return x


@pytest.mark.slow
@pytest.mark.host
@pytest.mark.parametrize(("vehicle", "number"), [("girona500", 0), ("bluerov2-heavy", 1)])
def test_the_archive_in_its_box_acts_as_the_network_does_on_features(
    isolation: IsolationLevel,
    packing: dict[str, Any],
    tmp_path: Path,
    vehicle: str,
    number: int,
) -> None:
    random, sizes = np.random.default_rng(3), (FEATURES["FEATURES"], 8, 8, FEATURES["ACTIONS"])
    layers = [
        (random.normal(0.0, 0.3, (n, m)).astype(np.float32), np.zeros(m, np.float32))
        for n, m in pairwise(sizes)
    ]
    packing["pack"](layers, tmp_path / "ppo.zip")
    observations, features, expected = seen(21), FEATURES["Features"](1), []
    for step, each in enumerate(observations[:, number : number + 1]):
        if step % FEATURES["STEPS"] == 0:
            network = packing["exported"](layers)
            command = features.command(forward(network, features.see(each, np.array([0]))))[0]
        expected.append(command)

    with packing["boxed"](tmp_path / "ppo.zip", vehicle) as answer:
        told = [answer(each) for each in observations[:, number]]

    np.testing.assert_allclose(told, expected, rtol=0.0, atol=1e-6)  # [m/s, rad/s] in float32
    assert np.ptp(told, axis=0)[[0, 1, 3]].min() > 0.1
