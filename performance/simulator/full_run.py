"""Complete practice runs: camera, tracker and a controller, built in or in a box; with an arm, too.

A run with an arm gives its program the images of the camera on it, ten times a second. Measured in
warm processes, as on a worker, and compared with simulated time. Each run is repeated with a clock
around the parts of a control step, whose functions are timed inside the run. Reading the clock
takes as long as some of them, so its time is measured and taken out.
"""

import os
import resource
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from functools import wraps
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from performance.tables import Row, cpu_us
from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.languages.python import PYTHON
from seamark.sandbox.probing.probes import probe
from seamark.server.runs.data.files import RunFiles
from seamark.sim.camera.arm_camera import ArmCamera
from seamark.sim.camera.camera import Camera
from seamark.sim.control.velocity_controller import VelocityController
from seamark.sim.detectors.faces.detector import OutlineDetector
from seamark.sim.engine.closed_loop import ClosedLoop
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.warm_up import warm_up
from seamark.sim.multibody.plant import ArmedPlant
from seamark.sim.physics.plant import Plant
from seamark.sim.recording import telemetry
from seamark.sim.trackers.template.tracker import TemplateTracker
from seamark.worker.evaluation.local import Callbacks, evaluate_locally
from seamark.worker.ipc import messages

_SEED = 7


class _Case(NamedTuple):
    """A run, and how long it is in simulated time."""

    benchmark: str
    settings: Mapping[str, object]
    simulated_s: float


_STATION = _Case(
    "currents-v1", {"tracker": "esm", "warp": "homography", "criterion": "zncc"}, 600.0
)
_WITH_ARM = tuple(
    _Case(name, {"levels": [0.0, 0.2], "level_duration_s": 90.0, "images": "arm"}, 180.0)
    for name in ("recover-v1", "valve-v1", "connect-v1")
)
_MISSION = _Case("mission-v1", {}, 720.0)  # a whole trial
_ROUTE = _Case("track-v1", {}, 600.0)  # a whole trial
_DOCK = _Case("dock-v1", {}, 450.0)  # a whole trial
# None of them is called within another one.
_PARTS: Mapping[str, tuple[tuple[Any, str], ...]] = {
    "rendering": ((Camera, "region"), (ArmCamera, "follow")),
    "images of the camera on an arm": ((ArmCamera, "grey_on_arm"),),
    "tracker": ((TemplateTracker, "update"),),
    "detector": ((OutlineDetector, "detect"),),
    "physics": ((Plant, "advance"), (Plant, "read_pose"), (ArmedPlant, "advance")),
    "sensors and position error": ((ClosedLoop, "_measure"),),
    "rendering, tracker and sensors in one call": ((ClosedLoop, "_look"),),
    "velocity controller": ((VelocityController, "step"),),
    "velocity controller and physics in one call": ((ClosedLoop, "_advance"),),
    "program: built in, or our side of the exchange": ((BuiltIn, "step"), (Box, "step")),
    "recording, with the digest": ((telemetry.Recorder, "commit"),),
}
_CLOCK = time.thread_time_ns
_BATCH = telemetry.DELIVERED_ROWS


def rows() -> list[Row]:
    """Measure and return the rows; CPU time is that of simulator and box together."""
    warm_up()
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(before)})
    try:
        isolation = probe().level
        measured = _measure(_STATION, "built-in PI", "pi", IsolationLevel.NONE)
        measured += _measure(_MISSION, "mission-v1, built-in chain", "chain", IsolationLevel.NONE)
        for built_in in ("ilos", "mpc"):
            name = f"track-v1, built-in {built_in}"
            measured += _measure(_ROUTE, name, built_in, IsolationLevel.NONE)
        measured += _measure(_DOCK, "dock-v1, built-in staged", "staged", IsolationLevel.NONE)
        if isolation >= IsolationLevel.MEDIUM:
            program = (PYTHON.self_test.upload(), "controller.py")
            name = f"program in its box, isolation {isolation.name.lower()}"
            measured += _measure(_STATION, name, program, isolation)
            for case in _WITH_ARM:
                measured += _with_arm(case, isolation)
        measured += _rows_of_telemetry(_telemetry())
    finally:
        os.sched_setaffinity(0, before)
    peak_mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return [*measured, Row(what="memory of this process", value=peak_mib, unit="MiB peak")]


def _with_arm(case: _Case, isolation: IsolationLevel) -> list[Row]:
    """Measure the starters of two languages that move an arm."""
    measured: list[Row] = []
    for language in ("python", "c"):
        starter = LANGUAGES[language].starter(moves_arm=True)
        assert starter is not None  # noqa: S101 - a test holds that every language has one
        program = (starter.upload(), starter.upload_name)
        _run(case, program, isolation)  # compiles what it needs
        measured += _measure(case, f"{case.benchmark}, starter in {language}", program, isolation)
    return measured


def _measure(
    case: _Case, name: str, controller: str | tuple[bytes, str], isolation: IsolationLevel
) -> list[Row]:
    wall_s, own_s, box_s = _run(case, controller, isolation)
    watch = _Stopwatch()
    with watch.open():
        _, timed_s, timed_box_s = _run(case, controller, isolation)
    real_s, what = case.simulated_s, f"{case.simulated_s:g} s, {name}"
    return [
        _relative_to_real_time(f"{what}: CPU", own_s + box_s, "s CPU", real_s),
        _relative_to_real_time(f"{what}: wall, one core", wall_s, "s wall", real_s),
        *_loop_rows(name, watch, timed_s, timed_box_s),
    ]


def _run(
    case: _Case,
    controller: str | tuple[bytes, str],
    isolation: IsolationLevel,
    callbacks: Callbacks | None = None,
) -> tuple[float, float, float]:
    """Run once; return the wall time, the CPU time of this process and that of the box [s]."""
    wall, cpu = time.perf_counter(), time.process_time()
    outcome = evaluate_locally(
        case.benchmark,
        case.settings,
        seed=_SEED,
        controller=controller,
        isolation=isolation,
        callbacks=callbacks,
        processes=1,
    )
    wall_s, own_s = time.perf_counter() - wall, time.process_time() - cpu
    if outcome.failure is not None:
        raise RuntimeError(f"the program ended with {outcome.failure}: {outcome.sentence}")
    return wall_s, own_s, outcome.usage.get("cpu_s", 0.0)


def _telemetry() -> NDArray[np.float64]:
    """Return the rows of a run."""
    kept: list[NDArray[np.float64]] = []
    _run(_STATION, "pi", IsolationLevel.NONE, Callbacks(rows=kept.append))
    return np.concatenate(kept)


def _relative_to_real_time(what: str, value_s: float, unit: str, simulated_s: float) -> Row:
    return Row(
        what=what, value=value_s, unit=unit, baseline="simulated time", baseline_value=simulated_s
    )


class _Stopwatch:
    """CPU time [s] of each part of what runs while it is open."""

    def __init__(self) -> None:
        self._ns = dict.fromkeys(_PARTS, 0)
        self._calls = dict.fromkeys(_PARTS, 0)
        self._clock_ns = 1e3 * cpu_us(_CLOCK, inner=10_000)

    @contextmanager
    def open(self) -> Iterator[None]:
        """Time the parts of what runs in this process."""
        with ExitStack() as restored:
            for part, functions in _PARTS.items():
                for owner, name in functions:
                    function = getattr(owner, name)
                    setattr(owner, name, self._timed(part, function))
                    restored.callback(setattr, owner, name, function)
            yield

    def _timed(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        ns, calls = self._ns, self._calls

        @wraps(function)
        def timed(*args: Any) -> Any:
            begin = _CLOCK()
            result = function(*args)
            ns[part] += _CLOCK() - begin
            calls[part] += 1
            return result

        return timed

    def parts_s(self) -> dict[str, float]:
        """Return the CPU time [s] of each part, without that of the clock."""
        return {
            part: 1e-9 * (ns - self._calls[part] * self._clock_ns) for part, ns in self._ns.items()
        }

    def clock_s(self) -> float:
        """Return the CPU time [s] that reading the clock took: twice at each call."""
        return 2e-9 * sum(self._calls.values()) * self._clock_ns


def _loop_rows(name: str, watch: _Stopwatch, own_s: float, box_s: float) -> list[Row]:
    """Return the parts of a run: `own_s` here, timed by `watch`, and `box_s` in its box."""
    parts, own_s = watch.parts_s(), own_s - watch.clock_s()
    parts["the rest: the loop itself, start and metrics"] = own_s - sum(parts.values())
    if box_s:
        parts["the box: its side of the exchange, and the program"] = box_s
    whole = own_s + box_s
    return [
        Row(
            what=f"  of {name}: {part}",
            value=seconds,
            unit="s CPU",
            baseline="all parts",
            baseline_value=whole,
        )
        for part, seconds in parts.items()
        if seconds > 0.0  # without an arm some of them are none
    ]


def _rows_of_telemetry(rows: NDArray[np.float64]) -> list[Row]:
    """Return what becomes of the rows of a run outside its loop."""
    return [
        Row(what=f"  after it: {what}", value=1e-6 * cpu_us(call, repeats=3), unit="s CPU")
        for what, call in {
            "CSV": lambda: telemetry.csv_lines(rows),
            "live data: messages to the worker, file that pages read": lambda: _send_live(rows),
        }.items()
    ]


def _send_live(rows: NDArray[np.float64]) -> None:
    with tempfile.TemporaryDirectory(prefix="seamark-") as folder:
        files = RunFiles(Path(folder), 1, 1)
        for at in range(0, len(rows), _BATCH):
            sent = telemetry.to_bytes(messages.Rows(rows[at : at + _BATCH]).rows)
            files.append_rows(telemetry.from_bytes(sent))
