"""Parallel runs, one per core, compared with a single run; a ranked run of ten trials."""

import json
import os
import subprocess
import sys
import time

from performance.tables import Row
from seamark.sandbox.languages.python import PYTHON
from seamark.sandbox.probing.probes import probe
from seamark.sim.engine.warm_up import warm_up
from seamark.worker.evaluation.local import evaluate_locally

_LEVELS = {"levels": [0.0, 0.2], "level_duration_s": 120.0}
_TRIALS = 10
# The child waits for a line, so that all start together and no start-up is measured.
_CHILD = """
import json, os, sys, time
os.sched_setaffinity(0, {int(sys.argv[2])})
from seamark.sim.engine.warm_up import warm_up
from seamark.sim import registry
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import run_trial
warm_up()
config = registry.benchmark("currents-v1").read(json.loads(sys.argv[1]))
print("warm", flush=True)
sys.stdin.readline()
start = time.perf_counter()
run_trial("currents-v1", config, BuiltIn("pi", config), seed=7, trial=0, on_rows=lambda _: None)
print(time.perf_counter() - start, flush=True)
"""


def rows() -> list[Row]:
    """Measure and return the rows."""
    cores = sorted(os.sched_getaffinity(0))
    alone = _slowest_of_parallel_runs(cores[:1])
    return [
        Row(
            what=f"{len(cores[:count])} parallel runs of 240 s, one core each, the slowest",
            value=_slowest_of_parallel_runs(cores[:count]),
            unit="s wall",
            baseline="a single run",
            baseline_value=alone,
        )
        for count in (2, 4, 8)
        if count <= len(cores)
    ] + [_ranked(len(cores))]


def _slowest_of_parallel_runs(cores: list[int]) -> float:
    """Return the wall time [s] of the slowest of parallel runs, one per core."""
    children = [
        subprocess.Popen(
            [sys.executable, "-c", _CHILD, json.dumps(_LEVELS), str(core)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        for core in cores
    ]
    pipes = [(child.stdin, child.stdout) for child in children if child.stdin and child.stdout]
    for _, out in pipes:
        out.readline()
    for into, _ in pipes:
        into.write("go\n")
        into.flush()
    slowest = max(float(out.readline()) for _, out in pipes)
    for child in children:
        child.communicate()
    return slowest


def _ranked(cores: int) -> Row:
    """Measure ten trials of the benchmark with an uploaded program, as in a ranked run."""
    warm_up()
    start = time.perf_counter()
    outcome = evaluate_locally(
        "currents-v1",
        {},
        seed=7,
        trials=_TRIALS,
        controller=(PYTHON.self_test.upload(), "controller.py"),
        isolation=probe().level,
    )
    if outcome.failure is not None:
        raise RuntimeError(f"the program ended with {outcome.failure}: {outcome.sentence}")
    return Row(
        what=f"{_TRIALS} trials of currents-v1 with a program in its box, {cores} cores",
        value=time.perf_counter() - start,
        unit="s wall",
        baseline="simulated time",
        baseline_value=_TRIALS * 600.0,
    )
