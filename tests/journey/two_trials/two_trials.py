"""currents-v1 with ranked runs of two trials (of ten), each a third as long as the real ones."""

from dataclasses import replace

from seamark.sim.benchmarks.currents_v1.definition import BENCHMARK as TEN_TRIALS
from seamark.sim.benchmarks.currents_v1.definition import CurrentsConfiguration
from seamark.sim.settings.setting import override

TRIALS = 2
LEVEL_S = 40.0  # longer than the settle window


class ShortConfiguration(CurrentsConfiguration):
    """The five levels, each of which ends soon after it has settled."""

    level_duration_s: float = override(
        CurrentsConfiguration.model_fields["level_duration_s"], LEVEL_S
    )


BENCHMARK = replace(TEN_TRIALS, configuration=ShortConfiguration, shared_trials=TRIALS)
