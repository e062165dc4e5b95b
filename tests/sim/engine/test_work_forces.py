"""Rows of a run whose arm works on something have the force that it gives, with its direction."""

import numpy as np
import pytest

from seamark.sim import registry
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording.telemetry import WORK_INDEX, Rows

BENCHMARK, SEED = "recover-v1", 2026
CONFIG = {"levels": [0.0], "level_duration_s": 22.0}


@pytest.fixture(scope="module")
def rows() -> Rows:
    benchmark, kept = registry.benchmark(BENCHMARK), list[Rows]()
    config = benchmark.read(CONFIG)
    program = benchmark.load().built_in("scripted", config)
    run_trial(BENCHMARK, config, program, seed=SEED, trial=0, on_rows=kept.append)
    return np.concatenate(kept)


@pytest.mark.slow
def test_the_force_on_the_workpiece_is_as_large_as_the_push(rows: Rows) -> None:
    force = rows[:, WORK_INDEX["work_fx"] : WORK_INDEX["work_fz"] + 1]

    assert np.linalg.norm(force, axis=1) == pytest.approx(rows[:, WORK_INDEX["work_push_n"]])
    assert rows[:, WORK_INDEX["work_push_n"]].max() > 10.0


def test_a_box_that_is_carried_is_pulled_upwards(rows: Rows) -> None:
    carried = (rows[:, WORK_INDEX["work_arm_n"]] > 1.0) & (rows[:, WORK_INDEX["work_rest_n"]] == 0)

    north, east, down = rows[carried, WORK_INDEX["work_fx"] : WORK_INDEX["work_fz"] + 1].mean(
        axis=0
    )

    assert -30.0 < down < -10.0, "about its weight in water"
    assert max(abs(north), abs(east)) < 0.3 * abs(down)
