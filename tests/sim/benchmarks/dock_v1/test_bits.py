"""A run of dock-v1 has the same bits in two processes, and on the oldest processor."""

from collections.abc import Sequence

import pytest

from tests.services.prepared import printed
from tests.sim.oldest_processor import printed_here

PROGRAM = """
import sys
from seamark.sim import registry
from seamark.sim.engine.trial import run_trial

entry = registry.benchmark("dock-v1")
# So near that they get into the dock.
near = {"approach_least_m": 0.1, "approach_most_m": 0.3, "approach_rise_m": 0.0}
config = entry.read({"levels": [0.3], "level_duration_s": 14.0} | near)
for trial, controller in enumerate(sys.argv[1:]):
    program = entry.load().built_in(controller, config.for_trial(trial))
    result = run_trial("dock-v1", config, program, seed=5, trial=trial, on_rows=lambda rows: None)
    print(result.digest)
"""


CONTROLLERS = ("staged", "straight", "oracle", "acoustic")


@pytest.mark.slow
@pytest.mark.timeout(900)  # where nothing is compiled for the oldest processor yet
@pytest.mark.parametrize(
    "controllers",
    [
        pytest.param(CONTROLLERS[:1], id="one"),
        pytest.param(CONTROLLERS, id="every", marks=pytest.mark.long),
    ],
)
def test_docks_have_the_same_bits_in_two_processes_and_on_the_oldest_processor(
    controllers: Sequence[str],
) -> None:
    here = printed_here(PROGRAM, *controllers)

    assert here == printed(PROGRAM, *controllers, on="oldest")
    assert len(set(here.splitlines())) == len(controllers)
