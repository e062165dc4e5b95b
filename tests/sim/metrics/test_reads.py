"""What metrics say that they read is all that they read."""

from typing import Any

import numpy as np
import pytest

from seamark.sim import registry
from seamark.sim.metrics import uwsim_metrics
from seamark.sim.recording.telemetry import NAMES, WIDTH, Rows

BENCHMARKS = ("currents-v1", "currents-v2", "currents-v3")


def _rows() -> Rows:
    """Return rows in which every metric has a value other than that of nothing."""
    rows = 0.05 + 0.5 * np.random.default_rng(7).random((600, WIDTH))
    rows[:, NAMES.index("trial")] = rows[:, NAMES.index("level")] = 0.0
    rows[:, NAMES.index("t")] = 0.05 * np.arange(len(rows))
    rows[:, NAMES.index("tracker_ok")] = np.arange(len(rows)) % 7 > 0
    rows[:, NAMES.index("tracker_error")] *= 40.0
    rows[:, NAMES.index("contact_n")] = np.arange(len(rows)) % 50 == 3
    rows[-300:, NAMES.index("distance")] = 0.05
    return rows


def _metrics(benchmark: str, rows: Rows, absent: frozenset[str]) -> dict[str, Any]:
    entry = registry.benchmark(benchmark)
    config: Any = entry.read({"settle_s": 1.0, "vehicle": "girona500"})
    experiment: Any = entry.load()
    original = uwsim_metrics.level_metrics(rows, absent=absent)
    return experiment.metrics(config, 0, rows, absent=absent) | original


@pytest.mark.slow
@pytest.mark.parametrize("benchmark", BENCHMARKS)
def test_a_metric_is_the_same_whatever_stands_in_columns_that_it_does_not_read(
    benchmark: str,
) -> None:
    whole = _metrics(benchmark, _rows(), frozenset())

    for at, column in enumerate(NAMES):
        other = _rows()
        other[:, at] = np.nan
        found = _metrics(benchmark, other, frozenset({column}))
        assert found == {
            name: None if value is None else whole[name] for name, value in found.items()
        }, column


@pytest.mark.parametrize("benchmark", BENCHMARKS)
def test_no_metric_is_made_of_columns_that_were_not_measured(benchmark: str) -> None:
    nothing = _metrics(benchmark, np.full((600, WIDTH), np.nan), frozenset(NAMES))

    assert {name for name, value in nothing.items() if value is not None} == {"level", "speed"}
