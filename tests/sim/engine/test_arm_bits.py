"""A run with an arm gives the same bits in two processes, and on the oldest processor."""

from collections.abc import Sequence

import pytest

from tests.services.prepared import printed
from tests.sim.oldest_processor import printed_here

PROGRAM = """
import sys
import numpy as np
from seamark.sim import registry
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording.telemetry import WORK_INDEX

runs = {"recover-v1": "oracle", "valve-v1": "oracle", "mission-v1": "chain"}
for benchmark in sys.argv[2:]:
    entry, rows = registry.benchmark(benchmark), []
    settings = {"levels": [0.1], "level_duration_s": float(sys.argv[1]), "images": "both"}
    if benchmark == "mission-v1":  # near enough to be found and gripped soon
        settings |= {"level_duration_s": 40.0, "loop1_values": [0.5]}
        settings |= {"start_offset_m": 2.0, "told_error_m": 0.5}
    if benchmark == "valve-v1":  # water that moves as a table has it
        settings |= {"current_place": "channel", "wave_height_m": 0.1}
    config = entry.read(settings)
    program = entry.load().built_in(runs[benchmark], config)
    result = run_trial(benchmark, config, program, seed=5, trial=0, on_rows=rows.append)
    held = np.concatenate(rows)[:, WORK_INDEX["work_arm_n"]] > 0.0
    print(result.digest, np.count_nonzero(held))
"""


RECOVER = ("21.0", "recover-v1")  # [s], until the hand has just gripped the box
EVERY = ("30.0", "recover-v1", "valve-v1", "mission-v1")


@pytest.mark.slow
@pytest.mark.timeout(900)  # where nothing is compiled for the oldest processor yet
@pytest.mark.parametrize(
    "runs",
    [
        pytest.param(RECOVER, id="one"),
        pytest.param(EVERY, id="every", marks=pytest.mark.long),
    ],
)
def test_runs_with_an_arm_have_the_same_bits_in_two_processes_and_on_the_oldest_processor(
    runs: Sequence[str],
) -> None:
    here = printed_here(PROGRAM, *runs).splitlines()

    assert here == printed(PROGRAM, *runs, on="oldest").splitlines()
    assert len(here) == len(runs[1:])
    assert all(int(line.split()[1]) > 20 for line in here)  # control steps with the hand on it
