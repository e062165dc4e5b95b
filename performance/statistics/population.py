"""Scores of many trials of a benchmark, each in its own water: the population of seeds.

`./run performance population BENCHMARK SOLUTION [TRIALS]` measures one and stores it in
population.json, from which `coverage` and `selection` draw runs. SOLUTION is a built-in controller,
or a tracker with its default options. It takes some seconds per trial.
"""

import json
from collections.abc import Sequence
from pathlib import Path

import cv2

from seamark.sim import registry
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import run_trial

FILE = Path(__file__).with_suffix(".json")
TRIALS = 120
FIRST_SEED = 5_000_000  # trial i has seed FIRST_SEED + i: trials that nothing has seen


def stored() -> dict[str, list[float]]:
    """Return "benchmark solution" -> scores in the order of the trials."""
    scores: dict[str, list[float]] = json.loads(FILE.read_text()) if FILE.exists() else {}
    return scores


def score(benchmark: str, solution: str, trial: int) -> float:
    """Return the score of one trial."""
    entry = registry.benchmark(benchmark)
    tracks = entry.role == "tracker"
    config = entry.ranked(entry.read({"tracker": solution} if tracks else {}))
    program = None if tracks else BuiltIn(solution, config.for_trial(trial))
    seed = FIRST_SEED + trial
    result = run_trial(
        benchmark, config, program, seed=seed, trial=trial, on_rows=lambda _rows: None
    )
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
