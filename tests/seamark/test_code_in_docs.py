"""The code in docs/datasets.md, trackers.md and training.md works as a reader would run it."""

import re
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from seamark.cli.main import cli
from seamark.sim import registry
from seamark.sim.engine.trial import run_trial
from seamark.sim.trackers import Corners, Track, Window

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
NAME = "visibility-v1"
SEED = 3
HARD = {"sweep_from": 0.5, "sweep_to": 6.5, "sweep_step": 3, "level_duration_s": 2}
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LIBRARIES = ("torchrl", "pufferlib", "stable_baselines3")  # that not everybody has


class UploadAdapter:
    """Adapts the interface of uploaded trackers to that of the simulator."""

    def __init__(self, tracker: Any) -> None:
        self._tracker = tracker
        self._size = (0, 0)

    def start(self, image: Any, corners: Corners) -> None:
        self._size = image.shape[::-1]
        self._last = corners
        self._tracker.start(image, corners)

    def window(self) -> Window:
        return (0, 0, *self._size)

    def update(self, image: Any) -> Track:
        found = self._tracker.update(image)
        self._last = self._last if found is None else found
        return Track(self._last, found is not None, 0.0, 1)


def _settings(values: dict[str, float]) -> list[str]:
    return [word for key, value in values.items() for word in ("--set", f"{key}={value}")]


@pytest.fixture
def reader_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with a tiny data set in dataset.zip and the template in tracker.py."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    options = [*_settings(HARD), "--seed", str(SEED)]
    for arguments in (["init", "--benchmark", NAME, "."], ["dataset", NAME, *options]):
        done = CliRunner().invoke(cli, arguments)
        assert done.exit_code == 0, done.output
    yield tmp_path
    sys.modules.pop("tracker", None)


@pytest.mark.slow
def test_a_tracker_scores_the_same_on_a_data_set_as_in_the_benchmark(
    reader_folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names: dict[str, Any] = {}
    for block in BLOCK.findall((DOCS / "datasets.md").read_text(encoding="utf-8")):
        exec(block, names)  # noqa: S102  # our own documentation

    config = registry.benchmark(NAME).read(HARD)
    solution = UploadAdapter(names["Tracker"]({}))
    result = run_trial(NAME, config, solution, seed=SEED, trial=0, on_rows=lambda _rows: None)
    assert list(names["shares"].values()) == [level["p5_percent"] for level in result.levels]
    assert len(set(names["shares"].values())) > 1  # neither tracked nor lost at every level
    truth = [float(names["truth"][0][f"camera_{axis}"]) for axis in "xyz"]
    assert np.allclose(names["camera_m"], truth, atol=1e-4)
    assert "tau50:" in capsys.readouterr().out


@pytest.mark.slow
def test_the_tracker_of_the_documentation_follows_a_still_target(reader_folder: Path) -> None:
    *_, block = BLOCK.findall((DOCS / "trackers.md").read_text(encoding="utf-8"))
    names: dict[str, Any] = {}
    exec(block, names)  # noqa: S102  # our own documentation
    still = {"path_swing_m": 0, "path_turn_rad": 0}
    config = registry.benchmark(NAME).read({"sweep_to": 0.25, "level_duration_s": 2, **still})

    solution = UploadAdapter(names["Tracker"]({}))
    result = run_trial(NAME, config, solution, seed=SEED, trial=0, on_rows=lambda _rows: None)

    assert result.levels[0]["p5_percent"] == 100.0  # neither it nor the target moves


def test_the_documentation_tracks_a_video(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    block, _ = BLOCK.findall((DOCS / "trackers.md").read_text(encoding="utf-8"))
    monkeypatch.chdir(tmp_path)
    image = np.random.default_rng(1).integers(0, 255, (240, 320, 3), np.uint8)
    writer = cv2.VideoWriter("dive.mp4", cv2.VideoWriter.fourcc(*"mp4v"), 20.0, (320, 240))
    for _ in range(3):
        writer.write(image)
    writer.release()

    exec(block, {})  # noqa: S102  # our own documentation

    assert [line[:2] for line in capsys.readouterr().out.splitlines() if "True" in line] == [
        *("0 ", "1 ", "2 ")
    ]


def of_training() -> Iterator[Any]:
    """Yield the code of the page, with what it needs."""
    for block in BLOCK.findall((DOCS / "training.md").read_text(encoding="utf-8")):
        needed = [name for name in LIBRARIES if name in block]
        missing = [name for name in needed if find_spec(name) is None]
        yield pytest.param(
            block, marks=pytest.mark.skipif(bool(missing), reason=f"needs {missing}")
        )


@pytest.mark.slow
@pytest.mark.parametrize("block", [*of_training()])
def test_each_example_of_training_runs_by_itself(
    block: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)

    exec(block, {})  # noqa: S102  # our own documentation
