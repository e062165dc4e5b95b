"""Make the excerpt of the measured trials and read it: `./run performance floating_arm FOLDER`.

The folder has the trials as their repository has them, each file compressed with gzip.
"""

import csv
import gzip
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from seamark.sim.numerics.arrays import Array

EXCERPT = Path(__file__).with_name("trials.csv")
SOURCE = "github.com/hkolano/UVMS-SysID-with-EAs, commit 18d9b2f, data/hinsdale-data-2023, MIT"
STEP_S = 0.1
# Seconds of each trial that are used. At the other ones somebody touches the vehicle: its attitude
# jerks while the arm rests.
SPANS = {
    "baseline1": (0.0, 37.0),
    "baseline2": (0.0, 51.0),
    "traj003-1": (7.0, 99.0),
    "traj005-1": (3.0, 99.0),
    "traj009-0": (0.0, 99.0),
    "traj019-2": (0.0, 99.0),
    "traj030-0": (0.0, 99.0),
    "traj_alt_001-1": (0.0, 99.0),
}
# The first three by name in which the arm moves.
FITTED = ("traj003-1", "traj005-1", "traj009-0")
OTHERS = tuple(name for name in SPANS if name not in FITTED)
COLUMNS = (
    *("time_s", "roll", "pitch", "mocap_roll", "mocap_pitch"),
    *("axis_e", "axis_d", "axis_c", "axis_b"),
)
_MEDIAN_S = 0.25  # to each side: markers are confused for some frames


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """What was measured at n times; angles in our axes, x forward, y starboard, z down [rad]."""

    name: str
    time_s: Array  # (n,)
    attitude: Array  # (n, 2) roll and pitch of the vehicle's own attitude filter
    seen: Array  # (n, 2) the same by motion capture
    joints: Array  # (n, 4) axes e, d, c, b as the arm reports them

    def with_clock(self, ahead_s: float) -> "Trial":
        """Return the trial with joints as if their clock were that much ahead of the vehicle's."""
        at = self.time_s + ahead_s
        joints = [np.interp(at, self.time_s, joint) for joint in self.joints.T]
        return replace(self, joints=np.column_stack(joints))


def trials() -> dict[str, Trial]:
    """Return all trials of the excerpt."""
    with EXCERPT.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))[1:]
    loaded = {}
    for name in SPANS:
        values = np.array([row[1:] for row in rows if row[0] == name], dtype=np.float64)
        loaded[name] = Trial(
            name=name,
            time_s=values[:, 0],
            attitude=values[:, 1:3],
            seen=values[:, 3:5],
            joints=values[:, 5:9],
        )
    return loaded


def main(arguments: Sequence[str]) -> int:
    """Write the excerpt from the folder of the original files."""
    (folder,) = map(Path, arguments)
    lines = [f"# {SOURCE}: every 0.1 s, angles in rad; the licence is beside this file"]
    lines.append(",".join(("trial", *COLUMNS)))
    for name in SPANS:
        for row in _decimated(folder, name):
            lines.append(",".join((name, f"{row[0]:.1f}", *(f"{value:.4f}" for value in row[1:]))))
    EXCERPT.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"{EXCERPT}: {EXCERPT.stat().st_size} bytes")
    return 0


def _decimated(folder: Path, name: str) -> Array:
    """Return the rows of a trial, (n, 9).

    Both attitudes are given in axes x forward, y port, z up: at rest the accelerometer reads +9.8
    along z. So roll stays, and pitch changes its sign.
    """
    imu, mocap, joints = (
        _columns(folder / f"{name}_{kind}.csv.gz") for kind in ("imu", "mocap", "joint_states")
    )
    start = max(SPANS[name][0], *(part["time_secs"][0] for part in (imu, mocap, joints)))
    end = min(SPANS[name][1], *(part["time_secs"][-1] for part in (imu, mocap, joints)))
    times = STEP_S * np.arange(np.ceil(start / STEP_S), np.floor(end / STEP_S) + 1)
    roll, pitch = _angles(*(imu[f"{key}_ori"] for key in "xyzw"))
    seen = _angles(*(mocap[f"{key}_ori"] for key in "xyzw"))
    columns = [
        times,
        np.interp(times, imu["time_secs"], roll),
        np.interp(times, imu["time_secs"], pitch),
        *(_medians(times, mocap["time_secs"], angle) for angle in seen),
        *(np.interp(times, joints["time_secs"], joints[f"axis_{key}_pos"]) for key in "edcb"),
    ]
    return np.column_stack(columns)


def _columns(path: Path) -> dict[str, Array]:
    with gzip.open(path, "rt", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {
        key: np.array([row[key] for row in rows], dtype=np.float64)
        for key in rows[0]
        if "yaw" not in key
    }


def _angles(x: Array, y: Array, z: Array, w: Array) -> tuple[Array, Array]:
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return roll, -np.arcsin(2.0 * (w * y - z * x))


def _medians(times: Array, at: Array, values: Array) -> Array:
    near = [values[np.abs(at - time) <= _MEDIAN_S] for time in times]
    return np.array([np.median(some) if some.size else np.nan for some in near])
