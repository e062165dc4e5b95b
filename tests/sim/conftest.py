"""What the tests of the whole chain share: short experiments."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from hypothesis import settings

from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.recording.telemetry import Rows
from seamark.sim.registry import benchmark
from seamark.sim.settings.configuration import Configuration

# A deadline is a timed test: it fails on a busy machine and says nothing about the code.
settings.register_profile("no-deadline", deadline=None)
settings.load_profile("no-deadline")

SHORT = {"levels": [0.1, 0.3], "level_duration_s": 6.0, "settle_s": 3.0}
RunOf = Callable[[Mapping[str, Any]], tuple[TrialResult, Rows]]


@pytest.fixture
def currents() -> Benchmark:
    return benchmark("currents-v1")


@pytest.fixture
def short(currents: Benchmark) -> Configuration:
    return currents.read(SHORT)


@pytest.fixture
def run_short(currents: Benchmark) -> RunOf:
    """Runs two short levels with the built-in PI, settings changed as given."""

    def run(changes: Mapping[str, Any]) -> tuple[TrialResult, Rows]:
        config = currents.read({**SHORT, **changes})
        rows: list[Rows] = []
        program = BuiltIn("pi", config)
        result = run_trial("currents-v1", config, program, seed=5, trial=0, on_rows=rows.append)
        return result, np.concatenate(rows)

    return run
