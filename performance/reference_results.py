"""`python -m performance.reference_results`: compute the results of the reference entries to ship.

Takes about ten minutes on two cores. Run it when a benchmark or a reference entry is added.
"""

from importlib.metadata import version
from multiprocessing import get_context
from typing import NamedTuple

from seamark.sim.benchmarks import reference_results
from seamark.sim.benchmarks.reference_results import ReferenceResult
from seamark.sim.engine.trial import run_trial
from seamark.sim.engine.warm_up import warm_up
from seamark.sim.registry import BENCHMARKS, benchmark

PROCESSES = 2


class Job(NamedTuple):
    """One trial of one entry."""

    benchmark: str
    entry: str
    trial: int


def measure(job: Job) -> tuple[float, str]:
    """Return score and digest of the telemetry of a trial on the benchmark's public seed."""
    definition = benchmark(job.benchmark)
    entry = definition.baselines[job.entry]
    config = definition.ranked(definition.read(entry.config))
    solution = definition.load().built_in(entry.built_in, config.for_trial(job.trial))
    seed, _ = reference_results.trials_of(definition)
    result = run_trial(
        job.benchmark, config, solution, seed=seed, trial=job.trial, on_rows=lambda _rows: None
    )
    return result.score, result.digest


def main() -> None:
    """Compute all entries of all benchmarks and store them."""
    results: dict[str, dict[str, ReferenceResult]] = {}
    with get_context("spawn").Pool(PROCESSES, initializer=warm_up) as pool:
        for definition in map(benchmark, BENCHMARKS):
            seed, trials = reference_results.trials_of(definition)
            entries = results[definition.name] = {}
            for name in definition.baselines:
                jobs = [Job(definition.name, name, trial) for trial in range(trials)]
                scores, digests = zip(*pool.map(measure, jobs, chunksize=1), strict=True)
                entries[name] = ReferenceResult(
                    version=version("seamark"),
                    seed=seed,
                    configuration=reference_results.configuration_digest(definition, name),
                    telemetry=reference_results.telemetry_digest(digests),
                    scores=scores,
                )
                print(f"{definition.name} {name}: {entries[name].score:.3f}", flush=True)
    reference_results.write(results)


if __name__ == "__main__":
    main()
