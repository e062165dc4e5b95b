"""Scores of many trials of a benchmark, each in its own water: the population of seeds.

Where the trials of a ranked run share a seed, these are the trials of as many runs as are needed.

`./run performance population BENCHMARK SOLUTION [TRIALS]` measures one and stores it in
population.json, from which `coverage` and `selection` draw runs. SOLUTION is a built-in controller,
or a tracker with its default options. It takes some seconds per trial.
"""

import json
from collections.abc import Sequence
from pathlib import Path

import cv2

from seamark.sim import registry
from seamark.sim.benchmarks.benchmark import RankedProtocol
from seamark.sim.engine.trial import run_trial

FILE = Path(__file__).with_suffix(".json")
TRIALS = 120
FIRST_SEED = 5_000_000  # of trials that nothing has seen; the next one has the next seed


def stored() -> dict[str, list[float]]:
    """Return "benchmark solution" -> scores in the order of the trials."""
    scores: dict[str, list[float]] = json.loads(FILE.read_text()) if FILE.exists() else {}
    return scores


def seed_and_trial(protocol: RankedProtocol | None, trial: int) -> tuple[int, int]:
    """Return the seed of a trial of the population, and which trial of that seed it is."""
    if protocol is None or not protocol.shared_seed:
        return FIRST_SEED + trial, trial
    run, own = divmod(trial, protocol.fresh_trials)
    return FIRST_SEED + run, own


def score(benchmark: str, solution: str, trial: int) -> float:
    """Return the score of one trial."""
    entry = registry.benchmark(benchmark)
    tracks = entry.role == "tracker"
    config = entry.ranked(entry.read({"tracker": solution} if tracks else {}))
    seed, own = seed_and_trial(entry.protocol, trial)
    program = None if tracks else entry.load().built_in(solution, config.for_trial(own))
    result = run_trial(benchmark, config, program, seed=seed, trial=own, on_rows=lambda _rows: None)
    return result.score


def main(arguments: Sequence[str]) -> int:
    """Measure a population and store it."""
    benchmark, solution, trials, *_ = *arguments, TRIALS
    cv2.setNumThreads(1)
    scores = [round(score(benchmark, solution, trial), 6) for trial in range(int(trials))]
    populations = stored() | {f"{benchmark} {solution}": scores}
    lines = (f"{json.dumps(name)}: {json.dumps(each)}" for name, each in populations.items())
    FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    return 0
