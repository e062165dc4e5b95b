"""Golden trajectories: the physics and the whole chain stay what they were.

On the class of processor that wrote them the bytes are the same; on others every column has a
tolerance. To write them again, on purpose and with a new benchmark version or a changelog entry:

    ./run golden [CASE ...]
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from seamark.sim.engine.trial import run_trial
from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import NAMES, Rows
from seamark.sim.registry import BENCHMARKS, VEHICLES, benchmark
from seamark.sim.settings.intervention import InterventionSettings
from tests.telemetry_csv import read

FOLDER = Path(__file__).parent
# Benchmark -> settings that make it short. Every benchmark of the registry needs an entry, and runs
# with each of its vehicles on ground truth; FURTHER are the cases with something else.
SHORT: dict[str, dict[str, object]] = {
    "currents-v1": {
        "levels": [0.1, 0.4],
        "level_duration_s": 4.0,
        "settle_s": 1.0,
        "tracker": "truth",
    },
    "currents-v2": {
        "levels": [0.2, 0.8],
        "level_duration_s": 4.0,
        "settle_s": 1.0,
        "tracker": "truth",
    },
    "currents-v3": {
        "levels": [0.2, 0.8],
        "level_duration_s": 4.0,
        "settle_s": 1.0,
        "tracker": "truth",
    },
    "visibility-v1": {
        "mode": "free",
        "sweep_to": 2.0,
        "sweep_step": 2.0,
        "level_duration_s": 2.0,
        "tracker": "truth",
    },
    "visibility-v2": {
        "turbidity_levels": [0.0, 7.0],
        "motion_levels": [4.0, 48.0],
        "jump_levels": [4.0, 28.0],
        "level_duration_s": 1.0,
        "tracker": "truth",
    },
    "visibility-v3": {
        "turbidity_levels": [0.0, 9.0],
        "motion_levels": [4.0, 60.0],
        "jump_levels": [4.0, 28.0],
        "level_duration_s": 1.0,
        "tracker": "truth",
    },
    "patterns-v1": {"optical_depths": [0.0, 3.0], "level_duration_s": 4.0},
    "mission-v1": {"levels": [0.3], "loop1_values": [0.5], "level_duration_s": 6.0},
    "track-v1": {"levels": [0.3], "level_duration_s": 6.0},
    "dock-v1": {"levels": [0.3], "level_duration_s": 6.0, "tracker": "truth"},
    "recover-v1": {"levels": [0.4], "level_duration_s": 4.0, "tracker": "truth"},
    "valve-v1": {"levels": [0.4], "level_duration_s": 4.0, "tracker": "truth"},
    "connect-v1": {"levels": [0.4], "level_duration_s": 4.0, "tracker": "truth"},
}
ARMS = {"bluerov2-heavy": "alpha-like", "bluerov2-heavy-v2": "alpha-like"}  # where they need one
FURTHER: dict[str, tuple[str, dict[str, object]]] = {
    "currents-v1-girona500-esm": ("currents-v1", {"vehicle": "girona500", "tracker": "esm"}),
    "track-v1-girona500-pipe": ("track-v1", {"vehicle": "girona500", "route": "pipe"}),
    "visibility-v1-fixed-esm": ("visibility-v1", {"mode": "fixed", "tracker": "esm"}),
}


def vehicles_of(name: str) -> list[str]:
    """The vehicles that a benchmark's form offers."""
    choices: list[str] = benchmark(name).schema()["properties"].get("vehicle", {}).get("enum", [])
    return [choice for choice in choices if choice in VEHICLES]


def arm_of(name: str, vehicle: str) -> dict[str, object]:
    """The arm that a vehicle carries if it is not the benchmark's default."""
    armed = isinstance(benchmark(name).read({}), InterventionSettings)
    return {"arm": ARMS[vehicle]} if armed and vehicle in ARMS else {}


CASES = {
    f"{name}-{vehicle}": (name, short | {"vehicle": vehicle} | arm_of(name, vehicle))
    for name, short in SHORT.items()
    for vehicle in vehicles_of(name)
} | {case: (name, SHORT[name] | changes) for case, (name, changes) in FURTHER.items()}
CASES |= {name: (name, short) for name, short in SHORT.items() if not vehicles_of(name)}
TOLERANCES = {"m": 1e-6, "rad": 1e-6, "m/s": 1e-6, "rad/s": 1e-6, "px": 1e-4, "N": 1e-4}
SEED = 20


def trajectory(case: str) -> Rows:
    name, settings = CASES[case]
    config = benchmark(name).read(settings)
    rows: list[Rows] = []
    solution = benchmark(name).load().built_in(next(iter(benchmark(name).built_in)), config)
    run_trial(name, config, solution, seed=SEED, trial=0, on_rows=rows.append)
    return np.concatenate(rows)


def golden_rows(case: str) -> Rows:
    names, rows = read((FOLDER / f"{case}.csv").read_text(encoding="utf-8"))
    assert tuple(names) == telemetry.names(rows.shape[1])
    return rows


def test_every_benchmark_and_every_vehicle_has_a_golden_trajectory() -> None:
    assert set(SHORT) == set(BENCHMARKS)
    assert {vehicle for name in SHORT for vehicle in vehicles_of(name)} == set(VEHICLES)
    assert {path.stem for path in FOLDER.glob("*.csv")} == set(CASES)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_the_trajectory_is_the_golden_one(case: str) -> None:
    ours, golden = trajectory(case), golden_rows(case)

    assert ours.shape == golden.shape
    for at, column in enumerate(telemetry.columns(ours.shape[1])):
        limit = np.inf if column.name == "step_us" else TOLERANCES.get(column.unit, 1e-9)
        absent = np.isnan(golden[:, at])  # such as the corners of what is not in the image
        assert np.array_equal(np.isnan(ours[:, at]), absent), column.name
        worst = np.abs(ours[:, at] - golden[:, at])[~absent].max(initial=0.0)
        assert worst <= limit, f"{column.name} moved by {worst:g} {column.unit}"


def write(cases: Sequence[str]) -> None:
    """Write the golden trajectories of these cases, or all."""
    FOLDER.mkdir(exist_ok=True)
    for case in cases or CASES:
        _name, settings = CASES[case]
        rows = trajectory(case)
        rows[:, NAMES.index("step_us")] = 0.0
        head = telemetry.header([f"{case}, seed {SEED}: {settings}"], width=rows.shape[1])
        text = head + telemetry.csv_lines(rows)
        (FOLDER / f"{case}.csv").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write(sys.argv[1:])
