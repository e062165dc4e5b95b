"""currents-v2: which position controller holds station in the strongest current."""

from dataclasses import replace

from seamark.sim.benchmarks.benchmark import Baseline, RankedProtocol
from seamark.sim.benchmarks.station_keeping.definition import station_keeping_benchmark
from seamark.sim.settings.station_keeping import StationKeepingSettings


class CurrentsConfiguration(StationKeepingSettings):
    """Settings of currents-v2. Seed, trials and controller are not part of it."""


_BENCHMARK = station_keeping_benchmark(
    name="currents-v2",
    title="Position controllers in unknown currents",
    summary="Keep station above a box on the bottom in currents that nobody has seen before.",
    configuration=CurrentsConfiguration,
    baselines={
        "p": Baseline("P, default settings", "p"),
        "pi": Baseline("PI, default settings", "pi"),
    },
    quick_settings={"levels": [0.1], "level_duration_s": 2.0, "settle_s": 1.0},
)
BENCHMARK = replace(_BENCHMARK, protocol=RankedProtocol(reference_trials=8, fresh_trials=24))
