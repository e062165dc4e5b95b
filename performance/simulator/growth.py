"""How time and memory grow with simulated time, and the start-up cost of a process.

Each run has a process of its own, which reports its CPU time after the warm-up and its peak memory.
With linear growth, a simulated second costs as much as in the shortest run: the ratio is 1.
"""

import json
import subprocess
import sys

from performance.tables import Row

# Simulated time [s] -> number of levels, duration of a level [s].
_RUNS = {60.0: (1, 60.0), 600.0: (5, 120.0), 6000.0: (10, 600.0)}
_CURRENT_STEP_M_S = 0.04
_CHILD = """
import json, resource, sys, time
start = time.process_time()
from seamark.sim.engine.warm_up import warm_up
from seamark.sim import registry
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import run_trial
warm_up()
warm = time.process_time()
config = registry.benchmark("currents-v1").read(json.loads(sys.argv[1]))
run_trial("currents-v1", config, BuiltIn("pi", config), seed=7, trial=0, on_rows=lambda _: None)
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
print(json.dumps({"start": warm - start, "run": time.process_time() - warm, "peak": peak}))
"""


def rows() -> list[Row]:
    """Measure and return the rows."""
    measured = {seconds: _measured(*shape) for seconds, shape in _RUNS.items()}
    first = min(measured)
    per_second = measured[first]["run"] / first
    return [
        Row(
            what="start of a process including warm-up, code already compiled",
            value=measured[first]["start"],
            unit="s CPU",
        )
    ] + [
        row
        for seconds, cost in measured.items()
        for row in (
            Row(
                what=f"{seconds:.0f} s, built-in PI",
                value=cost["run"],
                unit="s CPU",
                baseline=f"{first:.0f} s run, scaled",
                baseline_value=per_second * seconds,
            ),
            Row(
                what=f"{seconds:.0f} s, memory of the process",
                value=cost["peak"],
                unit="MiB peak",
                baseline=f"{first:.0f} s run",
                baseline_value=measured[first]["peak"],
            ),
        )
    ]


def _measured(levels: int, level_s: float) -> dict[str, float]:
    settings = {
        "levels": [round(_CURRENT_STEP_M_S * level, 2) for level in range(levels)],
        "level_duration_s": level_s,
    }
    done = subprocess.run(
        [sys.executable, "-c", _CHILD, json.dumps(settings)],
        check=True,
        capture_output=True,
        text=True,
    )
    answer: dict[str, float] = json.loads(done.stdout)
    return answer
