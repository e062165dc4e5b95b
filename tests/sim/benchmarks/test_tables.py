"""The tables of metrics on a run's page."""

import pytest

from seamark.sim import registry
from seamark.sim.metrics.station_keeping import HEAD


@pytest.mark.parametrize("name", registry.BENCHMARKS)
def test_no_metric_of_a_whole_level_stands_under_the_settle_window(name: str) -> None:
    after = [table for table in registry.benchmark(name).tables if "settle window" in table.title]

    shown = {metric.name for table in after if not table.prefix for metric in table.metrics}

    assert not shown & {metric.name for metric in HEAD}
