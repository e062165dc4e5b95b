"""What a host does beside a run is in no result."""

import subprocess
import sys

import pytest

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.worker.evaluation.local import evaluate_locally

pytestmark = [pytest.mark.host, pytest.mark.slow]

CONFIG = {"levels": [0.0, 0.2], "level_duration_s": 4.0, "settle_s": 1.0}
BUSY = 4
SOURCE = b"""
import numpy as np

class Controller:
    def __init__(self, config):
        self.seen = np.zeros(3)

    def step(self, observation):
        self.seen = 0.9 * self.seen + 0.1 * observation.error
        return [*(0.5 * observation.error + 0.1 * self.seen), 0.0]
"""


def evaluated(isolation: IsolationLevel) -> tuple[str, object]:
    outcome = evaluate_locally(
        "currents-v1",
        CONFIG,
        seed=5,
        controller=(SOURCE, "mine.py"),
        isolation=isolation,
    )
    assert outcome.metrics is not None, outcome.sentence
    return outcome.digest, outcome.metrics["score"]


def test_the_result_of_a_run_is_the_same_beside_four_busy_processes(
    isolation: IsolationLevel,
) -> None:
    alone = evaluated(isolation)

    spin = [sys.executable, "-I", "-S", "-c", "while True: pass"]
    neighbours = [subprocess.Popen(spin) for _ in range(BUSY)]
    try:
        beside_others = evaluated(isolation)
    finally:
        for neighbour in neighbours:
            neighbour.kill()
            neighbour.wait()

    assert beside_others == alone
