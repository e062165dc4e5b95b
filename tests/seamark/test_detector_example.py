"""The example that trains a detector: its targets are what is read of its output again."""

import json
import runpy
import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from seamark.cli.main import cli
from seamark.sim.detectors.network.layers import LAYERS
from seamark.sim.detectors.network.reading import LABELS, OUTPUTS, VIEWS, answers

EXAMPLE = Path(__file__).parents[2] / "examples" / "detector"


@pytest.fixture(scope="module")
def example() -> dict[str, Any]:
    return runpy.run_path(str(EXAMPLE / "shown.py"))


def output_of(scores: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Return the output of a network that has learned the targets of an image."""
    told = shape.copy()
    told[4:] = np.log((shape[4:] + 1e-6) / (1.0 - shape[4:] + 1e-6))
    return np.concatenate([np.log((scores + 1e-6) / (1.0 - scores + 1e-6)), told])


def test_what_is_read_of_the_targets_are_the_objects_that_count(
    example: dict[str, Any], tmp_path: Path
) -> None:
    out = tmp_path / "shown.zip"
    options = ["--images", "26", "--seed", "8", "--format", "csv", "--out", str(out)]
    assert CliRunner().invoke(cli, ["dataset", "patterns-v1", *options]).exit_code == 0
    shown = example["Shown"](out)
    found = missed = 0

    for number, things in enumerate(shown.things):
        for turned in (False, True):
            seen, scores, weights, shape, near = shown.sample(number, turned=turned)
            told = {label: corners for label, corners, _ in answers(output_of(scores, shape))}
            assert seen.shape[0] == VIEWS
            assert shape.shape[0] + len(scores) == OUTPUTS
            assert (scores.max(axis=0)[near > 0.5] > 0.3).all()
            for thing in things:
                label = LABELS[thing.number]
                corners = (319, 239) - thing.corners if turned else thing.corners
                if not thing.counts:
                    assert not scores[thing.number].any()
                    assert weights[thing.number].min() == 0.0 or not inside(corners)
                    continue
                close = label in told and np.allclose(
                    [told[label].min(axis=0), told[label].max(axis=0)],
                    [corners.min(axis=0), corners.max(axis=0)],
                    atol=0.1,
                )
                found, missed = found + close, missed + (not close)
    assert found > 20
    assert missed <= 0.1 * found  # two objects with their centres in one cell


def inside(corners: np.ndarray) -> bool:
    """Return whether the middle of the upright box of an object is in the image."""
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    return bool((middle >= 0).all() and (middle <= (319, 239)).all())


@pytest.mark.slow
@pytest.mark.skipif(find_spec("torch") is None, reason="PyTorch is not installed")
def test_a_short_training_packs_a_detector_and_the_weights_of_an_entry(tmp_path: Path) -> None:
    shown = tmp_path / "shown.zip"
    options = ["--images", "32", "--format", "csv", "--out", str(shown)]
    assert CliRunner().invoke(cli, ["dataset", "patterns-v1", *options]).exit_code == 0
    command = [sys.executable, str(EXAMPLE / "train.py"), str(shown), "--passes", "1"]

    done = subprocess.run(
        [*command, "--seeds", "1", "--out", "detector.zip", "--keep", str(tmp_path)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )

    assert "optical depth 6: average precision" in done.stdout
    kept = json.loads((tmp_path / "network.json").read_text())
    assert kept["images"] == {"benchmark": "patterns-v1", "images": 32, "seed": 0}
    with np.load(tmp_path / "weights.npz") as weights:
        assert set(weights.files) == {
            f"{name}.{part}" for name in LAYERS for part in ("weights", "biases")
        }
        assert all(np.isfinite(weights[name]).all() for name in weights.files)
    with zipfile.ZipFile(tmp_path / "detector.zip") as archive:
        assert set(archive.namelist()) == {"main.py", "reading.py", "libm.py", "model.onnx"}
