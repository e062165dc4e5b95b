"""Runs a hostile program for real, as a worker would: one trial of some steps."""

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.isolation.process_tree import Layers
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome, ProgramEnded, Verdict

PROGRAMS = Path(__file__).with_name("programs")
STEPS = 20
LAYOUT = {
    "observation": [["t", 0], ["error", 3], ["depth", 0], ["target_visible", 0]],
    "booleans": ["target_visible"],
    "command": ["surge", "sway", "heave", "yaw_rate"],
}
LIMITS = Limits(
    cpu_s=1.0,
    wall_s=20.0,
    start_wall_s=5.0,
    step_wall_s=0.7,
    memory_mib=128,
    processes=16,
    output_kib=4,
    output_max_mib=1,
)

# For programs that end by themselves or by another limit: a slow or busy host must not make them
# end by time.
LONG_WAITS = replace(LIMITS, cpu_s=5.0, start_wall_s=20.0, step_wall_s=10.0)
# For programs that do nothing until they are stopped: the less they wait, the sooner it is over.
SHORT_WAITS = replace(LIMITS, start_wall_s=2.0)

Run = Callable[..., Outcome]


@pytest.fixture(scope="session")
def run(isolation: IsolationLevel) -> Run:
    """Return a function that runs one program of the corpus and returns its outcome."""

    def run_one(
        name: str,
        *,
        at: IsolationLevel = isolation,
        layers: Layers | None = None,
        limits: Limits = LIMITS,
    ) -> Outcome:
        return stepped(PROGRAMS / f"{name}.py", Box(limits=limits, isolation=at, layers=layers))

    return run_one


@pytest.fixture(scope="session")
def run_file(isolation: IsolationLevel) -> Run:
    """Return a function that runs a program by its path and returns its outcome."""

    def run_one(path: Path, *, layers: Layers | None = None, **config: object) -> Outcome:
        return stepped(path, Box(limits=LIMITS, isolation=isolation, layers=layers), **config)

    return run_one


def limits_for(expected: Mapping[str, Any]) -> Limits:
    """Return the limits for a program of a table."""
    if expected["verdict"] != Verdict.TIME_LIMIT:
        return LONG_WAITS
    return SHORT_WAITS if expected.get("waits") else LIMITS


def stepped(path: Path, started: Box, **config: object) -> Outcome:
    with started as box:
        try:
            box.load(path.read_bytes(), path.name, {"kp": 0.5} | config, LAYOUT)
            box.reset({"index": 0})
            for step in range(STEPS):
                box.step([step / 20, 0.1, 0.2, 0.3, 5.0, 1.0])
            return box.finish()
        except ProgramEnded as end:
            return end.outcome


@pytest.fixture
def secret(monkeypatch: pytest.MonkeyPatch) -> str:
    """Put a secret into the worker's environment and return it."""
    monkeypatch.setenv("SEAMARK_SECRET_KEY", "do-not-tell")
    assert os.environ["SEAMARK_SECRET_KEY"] == "do-not-tell"
    return "do-not-tell"
