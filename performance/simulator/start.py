"""How long `seamark run` takes on a machine that has run it before, and on what it spends the time.

The whole command is timed as a person starts it. Its parts are timed one after the other in a
fresh process, beside what no run can do without: importing NumPy and Numba, and the simulation
itself in a process that has everything loaded.
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence

from performance.tables import Row

REPEATS = 3  # the fastest counts: what else the machine does only adds
RUN = ("run", "currents-v1", "--controller", "pi", "--seed", "7")
LIBRARIES = "import numpy, numba"
PARTS = """
import json, time
marks = []
def mark(name):
    marks.append((name, time.perf_counter(), time.process_time()))
mark("")
import numpy, numba
mark("import NumPy and Numba")
from seamark.sim import registry
from seamark.worker.evaluation.local import Callbacks, evaluate_locally
benchmark = registry.benchmark("currents-v1")
experiment = benchmark.load()
mark("import the simulator and its command")
quick = benchmark.read(benchmark.quick_settings).model_dump(mode="json")
evaluate_locally("currents-v1", quick, seed=7, controller="pi")
mark("load compiled code, draw the scene, run 2 s")
rows = []
whole = benchmark.read({}).model_dump(mode="json")
keep = Callbacks(rows=rows.append)
evaluate_locally("currents-v1", whole, seed=7, controller="pi", callbacks=keep)
mark("simulate 600 s")
from seamark.sim.recording import telemetry
text = "".join(map(telemetry.csv_lines, rows))
mark("write telemetry as CSV")
print(json.dumps(marks))
"""


def rows() -> list[Row]:
    """Measure and return the rows; each part has a row of CPU time and one of wall time."""
    parts = min((_parts() for _ in range(REPEATS)), key=lambda part: sum(c for _, _, c in part))
    commands = (("whole command", RUN), ("--help", ("--help",)))
    floor = _fastest([sys.executable, "-c", LIBRARIES])
    measured = []
    for name, arguments in commands:
        wall_s, cpu_s = _fastest(_command(arguments))
        measured += [
            Row(
                what=f"{name}: {kind}",
                value=ours,
                unit=f"s {kind}",
                baseline=LIBRARIES,
                baseline_value=base,
            )
            for kind, ours, base in (("wall", wall_s, floor[0]), ("CPU", cpu_s, floor[1]))
        ]
    first_line_s, simulating_s = _first_progress_s()
    measured += [
        Row(what="first line of progress", value=first_line_s, unit="s wall"),
        Row(what="first progress of the simulation", value=simulating_s, unit="s wall"),
    ]
    simulation_s = next(cpu_s for name, _, cpu_s in parts if name.startswith("simulate"))
    for name, wall_s, cpu_s in parts:
        measured.append(
            Row(
                what=name,
                value=cpu_s,
                unit=f"s CPU, {wall_s:.2f} s wall",
                baseline="simulation alone",
                baseline_value=simulation_s,
            )
        )
    return measured


def _command(arguments: Sequence[str]) -> list[str]:
    return [sys.executable, "-m", "seamark.cli.main", *arguments]


def _parts() -> list[tuple[str, float, float]]:
    """Return name, wall time and CPU time [s] of each part, from a fresh process."""
    ended = subprocess.run(
        [sys.executable, "-c", PARTS], check=True, capture_output=True, text=True
    )
    marks = json.loads(ended.stdout)
    return [
        (name, wall - marks[at][1], cpu - marks[at][2])
        for at, (name, wall, cpu) in enumerate(marks[1:])
    ]


def _fastest(command: Sequence[str]) -> tuple[float, float]:
    """Return the shortest wall time and CPU time [s] of a command that writes its data."""
    timings = [_timed(command) for _ in range(REPEATS)]
    return min(wall for wall, _ in timings), min(cpu for _, cpu in timings)


def _timed(command: Sequence[str]) -> tuple[float, float]:
    with tempfile.TemporaryDirectory() as folder:
        out = ["--out", f"{folder}/result"] if "run" in command else []
        started, cpu_s = time.perf_counter(), _children_cpu_s()
        subprocess.run([*command, *out], check=True, capture_output=True)
        return time.perf_counter() - started, _children_cpu_s() - cpu_s


def _children_cpu_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _first_progress_s() -> tuple[float, float]:
    """Return the time until the first two lines: loading, and simulating [s]."""
    timings = []
    for _ in range(REPEATS):
        started = time.perf_counter()
        with subprocess.Popen(
            _command(RUN), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        ) as process:
            assert process.stderr is not None  # noqa: S101 - a pipe was asked for
            seen = [(process.stderr.readline(), time.perf_counter() - started) for _ in range(2)]
            process.kill()
        timings.append((seen[0][1], seen[1][1]))
    return min(first for first, _ in timings), min(second for _, second in timings)
