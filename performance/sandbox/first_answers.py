"""The time to a program's first answer, by language: in a cold box and in a warm (waiting) one.

Wall time is what a user experiences, but it depends on the load of the machine. So the CPU time is
given as well, and for Python a plain interpreter that imports NumPy, measured alternately.
"""

import os
import resource
import statistics
import subprocess
import sys
import time

from performance.tables import Row
from seamark.sandbox.box import Box
from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import SandboxBroken
from seamark.sandbox.probing.self_test import LAYOUT, OBSERVATION

STARTS = 9
NUMPY = (sys.executable, "-c", "import numpy")


def rows(isolation: IsolationLevel, core: int) -> list[Row]:
    """Measure all languages available on this host."""
    table: list[Row] = []
    for name in LANGUAGES:
        try:
            program = _program(name, isolation)
        except SandboxBroken:  # not installed here
            continue
        table += _of_language(name, program, isolation, core)
    return table


def _program(name: str, isolation: IsolationLevel) -> bytes:
    language = LANGUAGES[name]
    source, filename = language.self_test.upload(), language.self_test.upload_name
    return compiled(language.sample_compiler, source, filename, isolation=isolation)


def _of_language(name: str, program: bytes, isolation: IsolationLevel, core: int) -> list[Row]:
    starts, bare = [], []
    for _ in range(STARTS):
        starts.append(_start(name, program, isolation, core))
        bare.append(_bare_numpy() if name == "python" else (0.0, 0.0))
    cold, warm, cpu, warm_cpu, memory = (
        statistics.median(each) for each in zip(*starts, strict=True)
    )
    wall, own = (statistics.median(each) for each in zip(*bare, strict=True))
    label = LANGUAGES[name].label
    baseline = "python -c 'import numpy'" if wall else ""
    return [
        Row(
            what=f"{label}: first answer, cold",
            value=cold,
            unit="ms wall",
            baseline=baseline,
            baseline_value=wall or None,
        ),
        Row(
            what=f"{label}: first answer, cold",
            value=cpu,
            unit="ms CPU",
            baseline=baseline,
            baseline_value=own or None,
        ),
        Row(what=f"{label}: first answer, warm box", value=warm, unit="ms wall"),
        Row(what=f"{label}: first answer, warm box", value=warm_cpu, unit="ms CPU"),
        Row(what=f"{label}: a waiting box", value=memory, unit="MiB"),
    ]


def _start(name: str, program: bytes, isolation: IsolationLevel, core: int) -> tuple[float, ...]:
    """Return wall times cold and warm [ms], CPU times cold and warm [ms], memory of the box [MiB].

    The cold CPU time is that of the box, the warm one that of both sides.
    """
    begin = time.perf_counter()
    with Box(name, limits=Limits(), isolation=isolation, core=core) as box:
        box.wait_ready()
        waiting = box.usage()
        ready, own_s = time.perf_counter(), time.process_time()
        box.load(program, LANGUAGES[name].self_test.upload_name, {"contents": False}, LAYOUT)
        box.step(OBSERVATION)
        end = time.perf_counter()
        own_s = time.process_time() - own_s
        cpu_s = box.usage().cpu_s
        box.finish()
    times = (end - begin, end - ready, cpu_s, cpu_s - waiting.cpu_s + own_s)
    return (*(seconds * 1e3 for seconds in times), waiting.memory_mib)


def _bare_numpy() -> tuple[float, float]:
    """Return wall and CPU time [ms] of a plain interpreter that imports NumPy."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.perf_counter()
    one_thread = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    subprocess.run(NUMPY, check=True, env=one_thread)
    wall_s = time.perf_counter() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return wall_s * 1e3, cpu_s * 1e3
