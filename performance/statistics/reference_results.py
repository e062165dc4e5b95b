"""Compute the reference results to ship: of the named benchmarks, or of all.

Takes about ten minutes on two cores. Run it when a benchmark or a reference entry is added.
"""

from collections.abc import Sequence
from importlib.metadata import version
from multiprocessing import get_context
from typing import NamedTuple

from seamark.sim.benchmarks import reference_results
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.benchmarks.reference_results import ReferenceResult
from seamark.sim.engine.summary import summarise
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.engine.warm_up import warm_up
from seamark.sim.registry import BENCHMARKS, benchmark

PROCESSES = 2


class Job(NamedTuple):
    """One trial of one entry."""

    benchmark: str
    entry: str
    trial: int
    seed: int | None = None  # None: the benchmark's public one


def measure(job: Job) -> TrialResult:
    """Run a trial in the ranked scenario."""
    definition = benchmark(job.benchmark)
    entry = definition.baselines[job.entry]
    config = definition.ranked(definition.read(entry.config))
    solution = definition.load().built_in(entry.built_in, config.for_trial(job.trial))
    public, _ = reference_results.trials_of(definition)
    seed = public if job.seed is None else job.seed
    return run_trial(
        job.benchmark, config, solution, seed=seed, trial=job.trial, on_rows=lambda _rows: None
    )


def plotted(definition: Benchmark, trials: Sequence[TrialResult]) -> dict[str, float]:
    """Return the two metrics of the benchmark's Pareto plot, as a run of these trials has them."""
    config = definition.ranked(definition.read({}))
    values = definition.board_values(summarise(definition.name, config, trials))
    return {metric.name: values[metric.name] for metric in definition.pareto or ()}


def main(names: Sequence[str]) -> int:
    """Compute the entries of these benchmarks, or of all, and store them beside the others."""
    results = {name: dict(reference_results.of_benchmark(benchmark(name))) for name in BENCHMARKS}
    with get_context("spawn").Pool(PROCESSES, initializer=warm_up) as pool:
        for definition in map(benchmark, names or BENCHMARKS):
            seed, trials = reference_results.trials_of(definition)
            for name in definition.baselines:
                jobs = [Job(definition.name, name, trial) for trial in range(trials)]
                measured = pool.map(measure, jobs, chunksize=1)
                result = ReferenceResult(
                    version=version("seamark"),
                    seed=seed,
                    configuration=reference_results.configuration_digest(definition, name),
                    scores=[trial.score for trial in measured],
                    metrics=plotted(definition, measured),
                )
                results[definition.name][name] = result
                print(f"{definition.name} {name}: {result.score:.3f}", flush=True)
    reference_results.write(results)
    return 0
