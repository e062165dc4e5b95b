"""A run's MCAP, read by Foxglove's own libraries from npm.

    ./run foxglove

`@mcap/core` reads the file, `@foxglove/rosmsg` its definitions and
`@foxglove/rosmsg2-serialization` its messages, as in Foxglove. All CRCs must be right, the
definitions those that Foxglove and ROS 2 publish, every value the recorded one bit for bit, and
every image must decode. Needs Node.js and npm, which downloads the libraries as
`package-lock.json` has them.
"""

import json
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from performance.interoperability.steps import NPM_CI, SEAMARK, Failed, are_installed, run
from seamark.formats.ros import frames, layout, mcap_file
from seamark.sim.recording.telemetry import INDEX, Rows
from tests import telemetry_csv

READER = Path(__file__).parent / "foxglove_reader"
SHORT = ("levels=0,0.3", "level_duration_s=10", "settle_s=2")
RUN = ("currents-v1", "--controller", "pi", "--seed", "7", "--trials", "2", "--out", "result")
SETTINGS = tuple(word for pair in SHORT for word in ("--set", pair))


def main(_arguments: Sequence[str]) -> int:
    """Print what was read; 0 if all of it is right."""
    if not are_installed("npm"):
        return 2
    with tempfile.TemporaryDirectory(prefix="seamark-foxglove-") as name:
        folder = Path(name)
        try:
            reading, rows = _read(folder)
            _check(folder / "out", reading, rows)
        except Failed as failed:
            print(failed, file=sys.stderr)
            return 1
    for topic, count in sorted(reading["counts"].items()):
        print(f"  {topic}: {count} messages")
    print(f"{len(rows)} rows of {rows.shape[1]} columns are the recorded ones, bit for bit.")
    print(f"{len(set(reading['definitions']))} definitions are the published ones.")
    print(f"{len(reading['images'])} images decode.")
    return 0


def _read(folder: Path) -> tuple[dict[str, Any], Rows]:
    """Return what the reader printed of a short run, and the rows of the run."""
    reader = folder / "reader"
    shutil.copytree(READER, reader)
    (folder / "out").mkdir()
    run((*SEAMARK, "run", *RUN, *SETTINGS), folder)
    run((*SEAMARK, "export", "result", "--format", "mcap", "-o", "run.mcap"), folder)
    run(NPM_CI, reader)
    printed = run(("node", "read.mjs", str(folder / "run.mcap"), str(folder / "out")), reader)
    text = (folder / "result" / "telemetry.csv").read_text(encoding="utf-8")
    names, rows = telemetry_csv.read(text)
    reading: dict[str, Any] = json.loads(printed)
    if reading["columns"] != names:
        raise Failed(f"the columns are {reading['columns']}")
    return reading, rows


def _check(out: Path, reading: dict[str, Any], rows: Rows) -> None:
    """Compare what the reader wrote with the rows; raises Failed."""
    if set(reading["counts"]) != set(mcap_file.TOPICS):
        raise Failed(f"the topics are {sorted(reading['counts'])}")
    if (out / "rows.f64").read_bytes() != rows.astype("<f8").tobytes():
        raise Failed("a value of the telemetry differs")
    position = slice(INDEX["x"], INDEX["z"] + 1)
    angles = slice(INDEX["roll"], INDEX["yaw"] + 1)
    poses = np.hstack([frames.to_enu(rows[:, position]), frames.orientation(rows[:, angles])])
    if (out / "poses.f64").read_bytes() != poses.astype("<f8").tobytes():
        raise Failed("a pose differs")
    for name, (width, height) in zip(reading["images"], reading["sizes"], strict=True):
        image = cv2.imread(str(out / name))
        if image is None or image.shape != (height, width, 3):
            raise Failed(f"{name} is no image of {width} x {height} pixels")
    if (out / layout.FILE).read_bytes() != layout.TEXT:
        raise Failed("the attached layout differs")
