"""A trajectory kept in the repository: the physics and the chain stay what they were.

On the machine class that wrote it the bytes are the same; on others every column has a tolerance.
To write it anew, on purpose and with a new benchmark version or a line in the change log:

    ./run golden
"""

from pathlib import Path

import numpy as np
import pytest

from sim import telemetry
from sim.program import BuiltIn
from sim.registry import benchmark
from sim.telemetry import NAMES, Rows
from sim.trial import run_trial

FOLDER = Path(__file__).parent.parent / "golden"
SHORT = {"levels": [0.1, 0.4], "level_duration_s": 4.0, "settle_s": 1.0}
CASES = {
    "girona500-truth": SHORT | {"vehicle": "girona500", "tracker": "truth"},
    "girona500-uwsim-truth": SHORT | {"vehicle": "girona500-uwsim", "tracker": "truth"},
    "bluerov2-heavy-truth": SHORT | {"vehicle": "bluerov2-heavy", "tracker": "truth"},
    "girona500-esm": SHORT | {"vehicle": "girona500", "tracker": "esm"},
}
TOLERANCES = {"m": 1e-6, "rad": 1e-6, "m/s": 1e-6, "rad/s": 1e-6, "px": 1e-4, "N": 1e-4}
SEED = 20


def trajectory(case: str) -> Rows:
    config = benchmark("currents-v1").read(CASES[case])
    rows: list[Rows] = []
    program = BuiltIn("pi", config)
    run_trial("currents-v1", config, program, seed=SEED, trial=0, on_rows=rows.append)
    return np.concatenate(rows)


def kept(case: str) -> Rows:
    return telemetry.from_csv((FOLDER / f"{case}.csv").read_text(encoding="utf-8"))


@pytest.mark.parametrize("case", CASES)
def test_the_trajectory_is_the_kept_one(case: str) -> None:
    ours, golden = trajectory(case), kept(case)

    assert ours.shape == golden.shape
    for at, column in enumerate(telemetry.COLUMNS):
        limit = np.inf if column.name == "step_us" else TOLERANCES.get(column.unit, 1e-9)
        worst = np.abs(ours[:, at] - golden[:, at]).max()
        assert worst <= limit, f"{column.name} moved by {worst:g} {column.unit}"


def write() -> None:
    """Write all kept trajectories anew."""
    FOLDER.mkdir(exist_ok=True)
    for case, settings in CASES.items():
        rows = trajectory(case)
        rows[:, NAMES.index("step_us")] = 0.0
        text = telemetry.to_csv(rows, [f"{case}, seed {SEED}: {settings}"])
        (FOLDER / f"{case}.csv").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write()
