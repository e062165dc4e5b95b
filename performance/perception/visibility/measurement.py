"""Trackers in turbid water: measure, store, and write the page.

    ./run performance visibility [GROUP ...]

Runs visibility-v1 like a ranked run, on known seeds. The results are stored in
docs/visibility.json, from which docs/visibility.md and its plot are generated; groups that are not
named keep their results.
"""

import json
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import cv2

from performance import DOCS
from performance.perception.visibility.cases import GROUPS, SEEDS, STEP, Case
from performance.perception.visibility.page import write
from seamark.sim.engine.trial import run_trial
from seamark.sim.numerics.statistics import mean
from seamark.sim.registry import benchmark
from seamark.sim.trackers.visp.installation import unavailable_reason

NAME = "visibility-v1"
RESULTS = DOCS / "visibility.json"
METRICS = ("p5_percent", "p1_percent", "corner_px", "not_admitted_percent")


def measure(case: Case) -> dict[str, Any]:
    """Run one tracker over all its seeds."""
    cv2.setNumThreads(1)
    config = benchmark(NAME).read(
        {"sweep_step": STEP, "level_duration_s": case.level_s, **case.config}
    )
    results = [
        run_trial(NAME, config, None, seed=seed, trial=0, on_rows=lambda _rows: None)
        for seed in range(SEEDS)
    ]
    levels = zip(*(result.levels for result in results), strict=True)
    overall = [result.trial_score.overall for result in results]
    return {
        "label": case.label,
        "scores": [result.score for result in results],
        "overall": {name: _mean([one[name] for one in overall]) for name in METRICS},
        "p5": [round(mean([level["p5_percent"] for level in same]), 3) for same in levels],
    }


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return round(mean(known), 6) if known else None


def main(names: Sequence[str]) -> int:
    """Measure the groups, two cases at a time, and write the page; 2 if a name is unknown."""
    unknown = [name for name in names if name not in GROUPS]
    if unknown:
        print(f"There is no group {', '.join(unknown)}; there are {', '.join(GROUPS)}.")
        return 2
    results: dict[str, Any] = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    with ProcessPoolExecutor(max_workers=min(2, os.cpu_count() or 1)) as pool:
        for name in names or GROUPS:
            if name.startswith("visp") and (reason := unavailable_reason()):
                print(f"{name} is skipped: {reason}.")
                continue
            results[name] = []
            for one in pool.map(measure, GROUPS[name]):
                print(f"{one['label']:32} {mean(one['scores']):.2f} {one['scores']}", flush=True)
                results[name].append(one)
                RESULTS.write_text(_stored(results), encoding="utf-8")
    write(results, DOCS)
    return 0


def _stored(results: Mapping[str, Sequence[Any]]) -> str:
    """Return the results as JSON with a case on each line."""
    groups = (
        f"{json.dumps(name)}: [\n" + ",\n".join(f" {json.dumps(one)}" for one in cases) + "\n]"
        for name, cases in results.items()
    )
    return "{\n" + ",\n".join(groups) + "\n}\n"
