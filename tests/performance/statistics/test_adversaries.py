"""Programs that do not look: what they do, and what they score."""

import numpy as np
import pytest

from performance.statistics import adversaries
from seamark.sim.engine.program import BuiltIn
from seamark.sim.registry import benchmark

NOWHERE = np.zeros(0)


def commands_of(name: str, seconds: float) -> list[tuple[float, ...]]:
    program = adversaries.Timed(adversaries.CONTROLLERS[name])
    program.reset({"dt": 0.05})
    return [program.step(NOWHERE) for _ in range(round(seconds / 0.05))]


@pytest.mark.parametrize(
    ("name", "period"), [("oscillating, 2 s", 2.0), ("oscillating, 30 s", 30.0)]
)
def test_an_oscillating_program_changes_its_sign_every_half_period(
    name: str, period: float
) -> None:
    signs = np.sign([command[0] for command in commands_of(name, 2.0 * period)])

    changes = np.flatnonzero(np.diff(signs)) * 0.05
    assert np.diff(changes) == pytest.approx(period / 2.0)


def test_a_random_program_does_the_same_in_every_level() -> None:
    assert commands_of("random", 3.0) == commands_of("random", 3.0)
    assert len(set(commands_of("random", 3.0))) > 2


@pytest.mark.parametrize("name", adversaries.TRACKERS)
def test_an_unseeing_tracker_asks_for_no_pixel(name: str) -> None:
    tracker = adversaries.TRACKERS[name]()
    tracker.start(np.zeros((8, 8), dtype=np.uint8), np.ones((4, 2)))

    x0, y0, x1, y1 = tracker.window()

    assert (x1 - x0) * (y1 - y0) == 0
    assert tracker.update(np.zeros((8, 8), dtype=np.uint8)).corners.shape == (4, 2)


def test_built_in_solutions_stand_beside_the_adversaries() -> None:
    entry = benchmark("currents-v1")
    found = adversaries.solutions(entry)

    assert set(adversaries.CONTROLLERS) < set(found)
    assert isinstance(found["built-in: PI"](entry.read({})), BuiltIn)


@pytest.mark.slow
def test_a_saturated_program_scores_less_than_one_that_does_nothing() -> None:
    entry = benchmark("currents-v1")
    found = adversaries.solutions(entry)

    scores = {
        name: adversaries.measured(entry, found[name], trials=1, seed=3)["score"]
        for name in ("saturated ahead", "built-in: Nothing")
    }

    assert scores["saturated ahead"] < 5.0 < scores["built-in: Nothing"]
