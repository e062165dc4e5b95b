"""The code in docs/formats.md runs as a reader would run it."""

import re
import subprocess
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seamark.formats.registry import FORMATS
from seamark.formats.ros import arm
from seamark.formats.ros.mcap_file import TOPICS
from seamark.sim.recording.telemetry import INDEX, Rows

GUIDE = Path(__file__).parents[3] / "docs" / "formats.md"


@pytest.fixture
def files(
    written: Callable[[str], BytesIO], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Path:
    """A folder with the run in the formats of the guide."""
    monkeypatch.chdir(tmp_path)
    for name in ("parquet", "npz", "mat", "mcap"):
        Path(FORMATS[name].file).write_bytes(written(name).getvalue())
    return tmp_path


def blocks(language: str) -> list[str]:
    text = GUIDE.read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


@pytest.mark.slow
@pytest.mark.usefixtures("files")
def test_the_python_of_the_guide_runs(rows: Rows, capsys: pytest.CaptureFixture[str]) -> None:
    names: dict[str, Any] = {}
    for block in blocks("python"):
        exec(block, names)  # noqa: S102  # our own documentation

    distance = rows[:, INDEX["distance"]]
    assert [value for _, value in names["distances"]] == distance.tolist()
    said = capsys.readouterr().out
    assert "distance in m of currents-v1" in said
    assert f"mean distance {distance.mean()} m" in said


@pytest.mark.slow
def test_the_matlab_code_of_the_guide_runs(files: Path, rows: Rows) -> None:
    (code,) = blocks("matlab")
    said = subprocess.run(
        ["octave-cli", "--norc", "--quiet", "--eval", code],
        cwd=files,
        check=True,
        capture_output=True,
        text=True,
    ).stdout

    first = rows[rows[:, INDEX["trial"]] == 0.0]
    mean = float(np.mean(first[:, INDEX["distance"]]))
    assert said == f"mean distance {mean:g} m\ncurrents-v1\n"


def test_the_guide_names_all_formats_and_topics() -> None:
    text = GUIDE.read_text(encoding="utf-8")

    assert {one.file for one in FORMATS.values()} <= set(re.findall(r"`([\w.]+)`", text))
    described = dict(re.findall(r"^\| `(/[\w/]+)` \| `([\w/]+)`", text, re.MULTILINE))
    assert described == TOPICS | arm.TOPICS
