"""Runs with a picture of one's own on the target, from the command line to the archive."""

import json
import zipfile
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from seamark.cli.main import cli
from tests.cast import MARKER

SHORT = ("level_duration_s=2", "turbidity_levels=0,3", "motion_levels=2,8")


def seamark(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(one) for one in arguments])


def changed(archive: Path, file: dict[str, Any]) -> Path:
    """Return an archive with another picture in its manifest."""
    other = archive.with_name("changed.zip")
    with zipfile.ZipFile(archive) as old, zipfile.ZipFile(other, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name.endswith("manifest.json"):
                content = json.dumps(json.loads(content) | {"target_file": file}).encode()
            new.writestr(name, content)
    return other


@pytest.mark.slow
def test_a_run_with_a_picture_is_computed_again_from_its_archive(tmp_path: Path) -> None:
    picture, result, archive = tmp_path / "m.pgm", tmp_path / "result", tmp_path / "archive.zip"
    picture.write_bytes(MARKER)
    settings = [part for pair in (*SHORT, f"target_texture={picture}") for part in ("--set", pair)]

    run = seamark("run", "visibility-v2", *settings, "--out", result)

    assert run.exit_code == 0, run.output
    assert seamark("export", result, "--format", "archive", "-o", archive).exit_code == 0
    picture.unlink()
    again = seamark("rerun", archive)
    assert "Every number is the same." in again.output
    file = json.loads((result / "manifest.json").read_text())["target_file"]
    brighter = {**file, "text": file["text"].replace(" 100 ", " 101 ", 1)}
    for other, sentence in (
        (brighter, "target picture in the archive is another one"),
        ({**file, "text": "P2"}, "target picture in the archive: The file is not a plain PGM"),
    ):
        refused = seamark("rerun", changed(archive, other))
        assert refused.exit_code != 0
        assert sentence in " ".join(refused.output.split())


def test_what_is_no_picture_is_refused_before_the_run(tmp_path: Path) -> None:
    path = tmp_path / "bad.png"
    path.write_text("no picture")

    done = seamark("run", "visibility-v3", "--set", f"target_texture={path}")

    assert done.exit_code != 0
    assert f"{path}: The file is no PNG, JPEG or PGM" in " ".join(done.output.split())
