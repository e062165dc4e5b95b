"""The learned entry: its network has one order of arithmetic, and its policy says what it is."""

from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from performance.statistics.headroom.interventions import SEED as HEADROOM_SEED
from seamark.sim.control.manipulation import imitation
from seamark.sim.control.manipulation.imitation.controller import WEIGHTS
from seamark.sim.control.manipulation.imitation.features import (
    ABOVE_M,
    CLOSE,
    COME,
    FALL,
    LIFT,
    PATIENCE,
    PHASES,
    SEE,
    Features,
)
from seamark.sim.control.manipulation.imitation.layers import Layer, forward, load, save
from seamark.sim.registry import benchmark
from tests.services.prepared import printed
from tests.sim.oldest_processor import printed_here

BITS = """
import numpy as np
from seamark.sim.control.manipulation.imitation.controller import WEIGHTS
from seamark.sim.control.manipulation.imitation.layers import forward, load

layers = load(WEIGHTS)
for features in np.random.default_rng(1).normal(size=(20, len(layers[0][0]))):
    print(*(value.hex() for value in forward(layers, features.tolist())))
"""


def layers_of(*sizes: int) -> list[Layer]:
    random = np.random.default_rng(1)
    pairs = pairwise(sizes)
    return [(random.normal(size=pair), random.normal(size=pair[1])) for pair in pairs]


def features_of(**settings: object) -> Features:
    return Features(benchmark("recover-v1").read(settings).for_program(), (1.3, 0.0, 0.9))


def moment(depth: float = 2.0) -> SimpleNamespace:
    """What `advance` asks of an observation."""
    return SimpleNamespace(depth=depth, dt=0.05)


def test_the_network_is_layers_of_rectified_linear_units_and_a_linear_one() -> None:
    layers = layers_of(5, 8, 7, 3)
    x = np.random.default_rng(2).normal(size=5)
    hidden = x
    for weights, biases in layers[:-1]:
        hidden = np.maximum(hidden @ weights + biases, 0.0)
    expected = hidden @ layers[-1][0] + layers[-1][1]

    assert forward(layers, x.tolist()) == pytest.approx(expected.tolist(), rel=1e-12)
    assert min(expected) < 0.0


def test_the_network_adds_from_the_first_input_to_the_last() -> None:
    large = 2.0**53  # to which adding 1 changes nothing
    layers = [(np.ones((4, 1)), np.zeros(1))]

    assert forward(layers, [1.0, 1.0, large, -large]) == [0.0 + 2.0]
    assert forward(layers, [large, 1.0, 1.0, -large]) == [0.0]


@pytest.mark.slow
def test_the_network_has_the_same_bits_on_the_oldest_processor() -> None:
    here = printed_here(BITS)

    assert here == printed(BITS, on="oldest")
    assert len(set(here.splitlines())) == 20


def test_weights_are_read_as_they_were_written(tmp_path: Path) -> None:
    layers = [(a.astype(np.float32), b.astype(np.float32)) for a, b in layers_of(5, 8, 3)]

    save(layers, tmp_path / "weights.npz")

    for layer, again in zip(layers, load(tmp_path / "weights.npz"), strict=True):
        for array, other in zip(layer, again, strict=True):
            np.testing.assert_array_equal(array, other)


def test_the_kept_network_takes_the_features_and_gives_what_the_entry_needs() -> None:
    layers = load(WEIGHTS)
    joints = 5

    assert layers[0][0].shape[0] == 28 + joints
    assert layers[-1][1].shape == (4 + joints + 1 + PHASES,)
    assert len(imitation.POLICY["most"]) == 4 + joints
    assert all(np.isfinite(array).all() for layer in layers for array in layer)


def test_a_phase_begins_when_it_was_told_often_enough_in_a_row() -> None:
    features = features_of()

    for phase in [COME] * (PATIENCE - 1) + [SEE] + [COME] * (PATIENCE - 1):
        features.advance(phase, 0.0, moment())
        assert features.phase == SEE
    features.advance(COME, 0.0, moment(2.5))

    assert (features.phase, features.depth_before) == (COME, 2.5)


def test_the_goal_falls_only_on_the_way_down_and_comes_back_with_a_new_attempt() -> None:
    features = features_of()

    def told(phase: int, times: int) -> float:
        for _ in range(times):
            features.advance(phase, 0.1, moment())
        return features.goal

    assert told(COME, 20) == ABOVE_M
    assert told(FALL, PATIENCE + 10) == pytest.approx(ABOVE_M - 10 * 0.1 * 0.05)
    assert told(CLOSE, 20) == told(LIFT, 20) < ABOVE_M
    assert told(COME, PATIENCE) == ABOVE_M


def test_no_demonstration_was_of_a_trial_that_the_entry_is_measured_by() -> None:
    definition = benchmark("recover-v1")
    first, last = imitation.POLICY["demonstrations"]["seeds"]
    assert definition.protocol is not None

    assert last - first + 1 == imitation.POLICY["demonstrations"]["episodes"]
    for seed in (definition.protocol.reference_seed, HEADROOM_SEED):
        assert not first <= seed <= last


def test_the_notes_of_the_entry_tell_date_seeds_and_cost() -> None:
    policy = imitation.POLICY
    shown, training = policy["demonstrations"], policy["training"]

    notes = benchmark("recover-v1").baselines["imitation"].notes

    for number in (*shown["seeds"], shown["episodes"], shown["cpu_s"], training["cpu_s"]):
        assert f" {number}" in notes
    assert f"on {policy['trained']}" in notes
    assert f"seed {training['seed']}" in notes
