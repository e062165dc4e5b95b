"""Files that are written aside: what was there stays until its successor is complete."""

import json
import os
import re
import stat
import threading
from pathlib import Path

import pytest

from seamark.cli.output_folder import OutputFolder
from seamark.drafts import draft_of, replace_file
from seamark.worker.ipc.outcomes import RunOutcome

SEAMARK = Path(__file__).parents[2] / "seamark"
IN_PLACE = re.compile(r"""write_text\(|write_bytes\(|open\([^)]*["'][wax]""")


def test_a_failure_leaves_the_file_that_was_there_and_nothing_else(tmp_path: Path) -> None:
    out = tmp_path / "run.csv"
    out.write_bytes(b"old")

    with pytest.raises(KeyboardInterrupt), draft_of(out) as file:  # noqa: PT012
        file.write(b"half of the ne")
        raise KeyboardInterrupt

    assert out.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [out]


def test_a_new_file_is_seen_only_when_it_is_complete(tmp_path: Path) -> None:
    out = tmp_path / "run.csv"

    with draft_of(out) as file:
        file.write(b"all")
        seen = out.exists()

    assert (seen, out.read_bytes()) == (False, b"all")
    assert list(tmp_path.iterdir()) == [out]


def test_a_link_stays_a_link_and_a_file_keeps_its_permissions(tmp_path: Path) -> None:
    real, link = tmp_path / "real.csv", tmp_path / "link.csv"
    real.write_bytes(b"old")
    real.chmod(0o640)
    link.symlink_to(real)

    replace_file(link, b"new")

    assert (link.is_symlink(), real.read_bytes()) == (True, b"new")
    assert stat.S_IMODE(real.stat().st_mode) == 0o640


def test_a_new_file_has_the_permissions_that_opening_it_gives(tmp_path: Path) -> None:
    (tmp_path / "opened").write_bytes(b"")

    replace_file(tmp_path / "made", b"")

    assert (tmp_path / "made").stat().st_mode == (tmp_path / "opened").stat().st_mode


def test_a_folder_is_not_replaced(tmp_path: Path) -> None:
    with pytest.raises(IsADirectoryError):
        replace_file(tmp_path, b"new")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write to every file")
def test_a_file_that_may_not_be_written_is_not_replaced(tmp_path: Path) -> None:
    out = tmp_path / "run.csv"
    out.write_bytes(b"old")
    out.chmod(0o444)

    with pytest.raises(PermissionError):
        replace_file(out, b"new")


def test_a_pipe_gets_the_content_and_stays_a_pipe(tmp_path: Path) -> None:
    pipe, read = tmp_path / "pipe", list[bytes]()
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()), daemon=True)
    reader.start()

    replace_file(pipe, b"new")
    reader.join(timeout=30)

    assert read == [b"new"]
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_a_result_that_cannot_be_written_whole_leaves_the_earlier_one(tmp_path: Path) -> None:
    output = OutputFolder(tmp_path)
    output.save("currents-v1", RunOutcome(metrics={"score": 1.0}, manifest={}, digest="a"))
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    with pytest.raises(ValueError, match="nan"):
        output.save(
            "currents-v1", RunOutcome(metrics={"score": float("nan")}, manifest={}, digest="b")
        )

    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
    assert json.loads(before["metrics.json"]) == {"score": 1.0}


@pytest.mark.parametrize("part", ["cli", "client", "plots", "tuning"])
def test_no_command_writes_a_file_of_the_user_in_place(part: str) -> None:
    sources = list((SEAMARK / part).rglob("*.py"))

    assert sources
    assert [path.name for path in sources if IN_PLACE.search(path.read_text("utf-8"))] == []
