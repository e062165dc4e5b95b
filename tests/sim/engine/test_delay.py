"""Latency is a shift by whole control steps, and nothing else."""

import numpy as np
import pytest

from seamark.sim.engine.delay import STILL, CommandDelay, ImageDelay, arriving


@pytest.mark.parametrize("steps", [0, 1, 3])
def test_a_command_arrives_as_many_steps_later(steps: int) -> None:
    line = CommandDelay(steps)
    sent = [(float(i), 0.0, 0.0, 0.0) for i in range(1, 8)]

    arrived = [line.step(command) for command in sent]

    assert arrived == [STILL] * steps + sent[: len(sent) - steps]


@pytest.mark.parametrize("steps", [0, 1, 3])
def test_the_station_keeper_gets_what_the_tracker_said_so_many_steps_ago(steps: int) -> None:
    tracked = np.zeros(8)
    results = ImageDelay(steps).results
    seen = []

    for i in range(8):
        tracked[:] = i
        arrived = arriving(results, i, steps, tracked, i != 2)
        seen.append((arrived[8] != 0.0, arrived[0]))

    expected = [max(i - steps, 0) for i in range(8)]
    assert seen == [(i != 2, float(i)) for i in expected]
