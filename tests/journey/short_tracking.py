"""A tracker benchmark with fresh trials that takes seconds: the registry entry of a test."""

from dataclasses import replace

from seamark.sim.benchmarks.benchmark import RankedProtocol
from seamark.sim.benchmarks.visibility_v1.definition import BENCHMARK as VISIBILITY
from seamark.sim.benchmarks.visibility_v1.settings import VisibilityConfiguration
from seamark.sim.settings.setting import override

NAME, PATH = "short-tracking-v2", "tests.journey.short_tracking:BENCHMARK"
INHERITED = VisibilityConfiguration.model_fields


class ShortConfiguration(VisibilityConfiguration):
    """Three levels of two seconds, in water in which every tracker of the service succeeds."""

    level_duration_s: float = override(INHERITED["level_duration_s"], 2.0)
    sweep_to: float = override(INHERITED["sweep_to"], 1.0)
    sweep_step: float = override(INHERITED["sweep_step"], 0.5)


SHARED_NAME, SHARED_PATH = "short-tracking-v1", "tests.journey.short_tracking:SHARED"
BENCHMARK = replace(
    VISIBILITY,
    name=NAME,
    configuration=ShortConfiguration,
    quick_settings={},
    protocol=RankedProtocol(reference_trials=2, fresh_trials=2),
)
# As the first versions: all ranked runs are in the same hidden water.
SHARED = replace(BENCHMARK, name=SHARED_NAME, protocol=None, shared_trials=2)
