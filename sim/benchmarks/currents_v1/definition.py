"""currents-v1: which position controller keeps station best while the current grows.

Five levels of 120 s each; at each the vehicle is reset and the tracker starts from the true
corners.
"""

from dataclasses import replace

from seamark.sim.benchmarks.benchmark import Baseline
from seamark.sim.benchmarks.station_keeping.definition import station_keeping_benchmark
from seamark.sim.benchmarks.station_keeping.starting_points import PAPER
from seamark.sim.settings.station_keeping import StationKeepingSettings


class CurrentsConfiguration(StationKeepingSettings):
    """Settings of currents-v1. Seed, trials and controller are not part of it."""


_BENCHMARK = station_keeping_benchmark(
    name="currents-v1",
    title="Position controllers in changing currents",
    summary=(
        "Keep station above a black box on the bottom while the current grows from 0 to 0.4 m/s in "
        "five levels of 120 s."
    ),
    configuration=CurrentsConfiguration,
    baselines={
        "p": Baseline("P, default settings", "p"),
        "pi": Baseline("PI, default settings", "pi"),
    },
    quick_settings={"levels": [0.1], "level_duration_s": 2.0, "settle_s": 1.0},
)
BENCHMARK = replace(
    _BENCHMARK,
    gym_family="StationKeeping",
    question="Which position controller keeps station best while the current grows?",
    starting_points={**PAPER, **_BENCHMARK.starting_points},
)
