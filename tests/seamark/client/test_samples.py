"""The code in docs/python-client.md runs as a reader would run it, against a service."""

import re
from pathlib import Path
from typing import Any

import pytest

from tests.cast import PROGRAM

GUIDE = Path(__file__).parents[3] / "docs" / "python-client.md"
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.mark.slow
@pytest.mark.usefixtures("worker")
def test_the_code_of_the_guide_runs(
    address: str,
    token: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "controller.py").write_bytes(PROGRAM)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SEAMARK_SERVER", address)
    monkeypatch.setenv("SEAMARK_TOKEN", token)

    names: dict[str, Any] = {}
    for block in BLOCK.findall(GUIDE.read_text(encoding="utf-8")):
        exec(block, names)  # noqa: S102  # our own documentation

    printed = capsys.readouterr().out
    assert names["run"].public
    assert (tmp_path / "run.png").stat().st_size > 10_000
    assert "10 control steps, RMS distance 2.00 m" in printed
    assert "Best: <run" in printed
    assert "kp" in printed.splitlines()[-1]
    names["client"].close()
