"""visibility-v2: which tracker keeps its target in the most turbid water and the fastest motion."""

from dataclasses import replace

from seamark.sim.benchmarks.benchmark import RankedProtocol
from seamark.sim.benchmarks.visibility_v1.definition import BENCHMARK as VERSION_1

BENCHMARK = replace(
    VERSION_1,
    name="visibility-v2",
    title="Trackers in turbid water and fast motion",
    protocol=RankedProtocol(reference_trials=8, fresh_trials=24),
)
