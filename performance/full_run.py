"""A complete practice run of 600 s: camera, tracker and a controller, built in or in a box.

Measured in warm processes, as on a worker, and compared with simulated time.
"""

import os
import resource
import time

from performance.table import Row
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages.python import PYTHON
from seamark.sandbox.probing.probes import probe
from seamark.sim.engine.warm_up import warm_up
from seamark.worker.evaluation.local import evaluate_locally

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
        measured = [_measure("built-in PI", "pi", IsolationLevel.NONE)]
        if isolation >= IsolationLevel.MEDIUM:
            program = (PYTHON.self_test.upload(), "controller.py")
            name = f"program in its box, isolation {isolation.name.lower()}"
            measured.append(_measure(name, program, isolation))
    finally:
        os.sched_setaffinity(0, before)
    peak_mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return [row for pair in measured for row in pair] + [
        Row(what="memory of this process", value=peak_mib, unit="MiB peak")
    ]


def _measure(
    name: str, controller: str | tuple[bytes, str], isolation: IsolationLevel
) -> tuple[Row, Row]:
    wall, cpu = time.perf_counter(), time.process_time()
    outcome = evaluate_locally(
        "currents-v1",
        _SETTINGS,
        seed=_SEED,
        controller=controller,
        isolation=isolation,
    )
    wall_s = time.perf_counter() - wall
    cpu_s = time.process_time() - cpu + outcome.usage.get("cpu_s", 0.0)
    return (
        _relative_to_real_time(f"600 s, {name}: CPU", cpu_s, "s CPU"),
        _relative_to_real_time(f"600 s, {name}: wall, one core", wall_s, "s wall"),
    )


def _relative_to_real_time(what: str, value_s: float, unit: str) -> Row:
    return Row(
        what=what, value=value_s, unit=unit, baseline="simulated time", baseline_value=_SIMULATED_S
    )
