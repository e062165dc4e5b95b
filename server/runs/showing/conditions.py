"""What was drawn for a trial of a run, as whoever simulated it drew it."""

from collections.abc import Mapping
from typing import Any

from seamark.server.runs.record.seeds import trial_seeds
from seamark.server.runs.showing.views import RunView
from seamark.server.settings import Settings
from seamark.sim import registry


def conditions_of(settings: Settings, run: RunView, *, trial: int) -> Mapping[str, Any]:
    """Return the conditions of a trial; a vehicle of the user's own has to be lent to it."""
    benchmark = registry.benchmark(run.benchmark)
    config: Any = benchmark.restore(run.config)
    seed = trial_seeds(run, settings)(trial)
    conditions: Mapping[str, Any] = benchmark.load().plan(config, seed=seed, trial=trial).conditions
    return conditions
