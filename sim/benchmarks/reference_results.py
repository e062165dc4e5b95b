"""The results of the reference entries that Seamark ships, computed on public seeds.

They show what a benchmark separates before a new service has computed its own. The results of a
service must agree with them bit for bit wherever both had the same seeds: in the reference trials.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import Any

from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.numerics.statistics import mean, mean_interval

FILE = Path(__file__).with_name("reference_results.json")
PUBLIC_SEED = 2026  # of benchmarks without a protocol; the others name theirs
PUBLIC_TRIALS = 8


@dataclass(frozen=True, slots=True)
class ReferenceResult:
    """The result of one reference entry of a benchmark version."""

    version: str  # of Seamark, that computed it
    seed: int
    configuration: str  # SHA-256 of what was evaluated
    scores: Sequence[float]  # of the trials, in the benchmark's unit
    metrics: Mapping[str, float] = field(default_factory=dict)  # of the benchmark's Pareto plot

    @property
    def score(self) -> float:
        """The mean over the trials."""
        return mean(self.scores)

    def interval(self, benchmark: Benchmark) -> tuple[float, float]:
        """Return the 95 % interval of the score; the score twice without one."""
        block = benchmark.protocol.block if benchmark.protocol else 1
        return mean_interval(self.scores, block=block) or (self.score, self.score)


def of_benchmark(benchmark: Benchmark) -> Mapping[str, ReferenceResult]:
    """Return suffix of the entry's user name -> shipped result."""
    return _stored().get(benchmark.name, {})


def trials_of(benchmark: Benchmark) -> tuple[int, int]:
    """Return the public seed of a benchmark and the number of trials with it."""
    protocol = benchmark.protocol
    if protocol is None:
        return PUBLIC_SEED, PUBLIC_TRIALS
    return protocol.reference_seed, protocol.reference_trials


def configuration_digest(benchmark: Benchmark, name: str) -> str:
    """Return the SHA-256 of the ranked configuration and the built-in solution of an entry."""
    entry = benchmark.baselines[name]
    config = benchmark.ranked(benchmark.read(entry.config)).model_dump(mode="json")
    evaluated = {"solution": entry.built_in, "configuration": config}
    return sha256(json.dumps(evaluated, sort_keys=True).encode()).hexdigest()


def write(results: Mapping[str, Mapping[str, ReferenceResult]]) -> None:
    """Store the results: benchmark -> entry -> result."""
    values: dict[str, Any] = {
        benchmark: {name: asdict(result) for name, result in entries.items()}
        for benchmark, entries in results.items()
    }
    FILE.write_text(json.dumps(values, indent=1) + "\n", encoding="utf-8")


@lru_cache(maxsize=1)
def _stored() -> Mapping[str, Mapping[str, ReferenceResult]]:
    values = json.loads(FILE.read_text(encoding="utf-8"))
    return {
        benchmark: {name: ReferenceResult(**result) for name, result in entries.items()}
        for benchmark, entries in values.items()
    }
