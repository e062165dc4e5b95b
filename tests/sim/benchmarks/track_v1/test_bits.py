"""A run of track-v1 has the same bits in two processes, and on the oldest processor."""

import pytest

from tests.services.prepared import printed
from tests.sim.oldest_processor import printed_here

PROGRAM = """
from seamark.sim import registry
from seamark.sim.engine.trial import run_trial

entry = registry.benchmark("track-v1")
config = entry.read({"levels": [0.3], "level_duration_s": 10.0})
names = ("ilos", "mpc", "oracle", "pi", "blind", "into-flow", "l1", "mpc")
for trial, controller in enumerate(names):
    program = entry.load().built_in(controller, config.for_trial(trial))
    result = run_trial("track-v1", config, program, seed=5, trial=trial, on_rows=lambda rows: None)
    print(result.digest)
"""


@pytest.mark.slow
def test_routes_have_the_same_bits_in_two_processes_and_on_the_oldest_processor() -> None:
    here = printed_here(PROGRAM)

    assert here == printed(PROGRAM, on="oldest")
    assert len(set(here.splitlines())) == 8
