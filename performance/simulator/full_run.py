"""A complete practice run of 600 s: camera, tracker and a controller, built in or in a box.

Measured in warm processes, as on a worker, and compared with simulated time. Each run is repeated
with a clock around its parts.
"""

import os
import resource
import time

import numpy as np
from numpy.typing import NDArray

from performance.simulator import run_parts
from performance.tables import Row
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages.python import PYTHON
from seamark.sandbox.probing.probes import probe
from seamark.sim.engine.warm_up import warm_up
from seamark.worker.evaluation.local import Callbacks, evaluate_locally

_SEED = 7
_SETTINGS: dict[str, object] = {"tracker": "esm", "warp": "homography", "criterion": "zncc"}
_SIMULATED_S = 600.0


def rows() -> list[Row]:
    """Measure and return the rows; CPU time is that of simulator and box together."""
    warm_up()
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(before)})
    try:
        isolation = probe().level
        measured = _measure("built-in PI", "pi", IsolationLevel.NONE)
        if isolation >= IsolationLevel.MEDIUM:
            program = (PYTHON.self_test.upload(), "controller.py")
            name = f"program in its box, isolation {isolation.name.lower()}"
            measured += _measure(name, program, isolation)
        measured += run_parts.rows_of_telemetry(_telemetry())
    finally:
        os.sched_setaffinity(0, before)
    peak_mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return [*measured, Row(what="memory of this process", value=peak_mib, unit="MiB peak")]


def _measure(
    name: str, controller: str | tuple[bytes, str], isolation: IsolationLevel
) -> list[Row]:
    wall_s, own_s, box_s = _run(controller, isolation)
    watch = run_parts.Stopwatch()
    with watch.open():
        _, timed_s, timed_box_s = _run(controller, isolation)
    return [
        _relative_to_real_time(f"600 s, {name}: CPU", own_s + box_s, "s CPU"),
        _relative_to_real_time(f"600 s, {name}: wall, one core", wall_s, "s wall"),
        *run_parts.loop_rows(name.partition(",")[0], watch, timed_s, timed_box_s),
    ]


def _run(
    controller: str | tuple[bytes, str],
    isolation: IsolationLevel,
    callbacks: Callbacks | None = None,
) -> tuple[float, float, float]:
    """Run once; return the wall time, the CPU time of this process and that of the box [s]."""
    wall, cpu = time.perf_counter(), time.process_time()
    outcome = evaluate_locally(
        "currents-v1",
        _SETTINGS,
        seed=_SEED,
        controller=controller,
        isolation=isolation,
        callbacks=callbacks,
    )
    wall_s, own_s = time.perf_counter() - wall, time.process_time() - cpu
    return wall_s, own_s, outcome.usage.get("cpu_s", 0.0)


def _telemetry() -> NDArray[np.float64]:
    """Return the rows of a run."""
    kept: list[NDArray[np.float64]] = []
    _run("pi", IsolationLevel.NONE, Callbacks(rows=kept.append))
    return np.concatenate(kept)


def _relative_to_real_time(what: str, value_s: float, unit: str) -> Row:
    return Row(
        what=what, value=value_s, unit=unit, baseline="simulated time", baseline_value=_SIMULATED_S
    )
