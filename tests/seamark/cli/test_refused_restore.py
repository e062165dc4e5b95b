"""What a restore leaves behind that was refused or broke off: nothing, or nothing that starts."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from click.testing import CliRunner

from seamark.cli.main import cli
from seamark.server.administration.backup import creation, layout, restoring
from seamark.server.database import schema
from seamark.server.database.data_folder import WrongDataFolder
from seamark.server.runs.data.files import RunFiles
from seamark.server.settings import Settings
from seamark.sim.recording.telemetry import WIDTH
from tests.cast import Backend


def _nothing(_more: int) -> None:
    """Be told that more bytes have been copied."""


@pytest.fixture
def archive(backend: Backend, tmp_path: Path) -> Path:
    """A backup of a service with a run."""
    claim = backend.running("ann", controller="upload", program=backend.store_program())
    files = RunFiles(backend.settings.data, claim.run_id, claim.attempt)
    files.append_rows(np.full((50, WIDTH), 7.0))
    assert backend.finish(claim)
    creation.make(backend.database, backend.settings, tmp_path / "b.tar", _nothing)
    return tmp_path / "b.tar"


class Case(NamedTuple):
    archive: Path
    place: Path
    patch: pytest.MonkeyPatch


def _is_text(case: Case) -> None:
    case.archive.write_text("no archive")


def _is_cut(case: Case) -> None:
    with case.archive.open("r+b") as file:
        file.truncate(case.archive.stat().st_size // 2)


def _is_changed(case: Case) -> None:
    content = bytearray(case.archive.read_bytes())
    content[content.index(np.full(WIDTH, 7.0).tobytes()) + 100] ^= 1
    case.archive.write_bytes(content)


def _is_of_a_later_version(case: Case) -> None:
    case.patch.setattr(layout, "FORMAT", layout.FORMAT - 1)


def _has_no_room(case: Case) -> None:
    usage = shutil.disk_usage(case.archive)
    case.patch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=1000))


def _has_another_key(case: Case) -> None:
    case.patch.setenv("SEAMARK_SEED_KEY", "of the environment")


def _is_for_a_folder(case: Case) -> None:
    case.patch.setenv("SEAMARK_STORAGE_URL", f"file://{case.place.parent}/objects")


def _has_runs_there(case: Case) -> None:
    (case.place / "runs").mkdir(parents=True)


REFUSALS: dict[str, tuple[Callable[[Case], None], str]] = {
    "no archive": (_is_text, "not a complete backup"),
    "cut": (_is_cut, "not complete"),
    "changed": (_is_changed, "SHA-256"),
    "later version": (_is_of_a_later_version, "later than this version"),
    "no room": (_has_no_room, "has room for"),
    "another key": (_has_another_key, "SEAMARK_SEED_KEY"),
    "another storage": (_is_for_a_folder, "SEAMARK_STORAGE_URL"),
    "used": (_has_runs_there, "--force"),
}


def _tree(folder: Path) -> list[Path]:
    return sorted(folder.rglob("*"))


@pytest.mark.slow
@pytest.mark.parametrize("exists", [True, False])
@pytest.mark.parametrize("why", REFUSALS)
def test_a_refused_restore_leaves_nothing_behind(
    archive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, why: str, exists: bool
) -> None:
    place = tmp_path / "there" / "elsewhere"
    place.parent.mkdir()
    if exists:
        place.mkdir()
    prepare, says = REFUSALS[why]
    prepare(Case(archive, place, monkeypatch))
    before = _tree(place.parent)

    words = ["restore", str(archive), "--data", str(place)]
    answer = CliRunner().invoke(cli, words, prog_name="seamark")

    assert (answer.exit_code, says in answer.output) == (2, True), answer.output
    assert _tree(place.parent) == before


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.05, 0.5, 0.95, 1.05, 1.3, 1.6, 1.9])
def test_a_restore_that_is_interrupted_leaves_nothing_or_what_does_not_start(
    archive: Path, tmp_path: Path, share: float
) -> None:
    place = tmp_path / "elsewhere"
    settings = Settings.load({"SEAMARK_DATA": str(place)}, looking=True)
    read, whole = 0, 0

    def count(more: int) -> None:
        nonlocal whole
        whole += more

    def interrupt(more: int) -> None:
        nonlocal read
        read += more
        if read >= share * whole:
            raise KeyboardInterrupt

    restoring.check(archive, count)
    with pytest.raises(KeyboardInterrupt):
        restoring.restore(settings, archive, force=False, on_bytes=interrupt)

    assert place.exists() == (share > 1.0)
    if place.exists():
        starting = Settings.model_validate({"data": place})  # as `seamark up` does
        with pytest.raises(WrongDataFolder, match="has not finished"):
            schema.upgrade(starting)
    restoring.restore(settings, archive, force=share > 1.0, on_bytes=_nothing)
    schema.check_all(Settings.model_validate({"data": place}))


def test_the_keys_of_a_restored_service_are_those_of_the_backup_for_its_owner_alone(
    backend: Backend, archive: Path, tmp_path: Path
) -> None:
    place = tmp_path / "elsewhere"

    words = ["restore", str(archive), "--data", str(place)]
    answer = CliRunner().invoke(cli, words, prog_name="seamark")

    assert answer.exit_code == 0
    restored: Any = Settings.model_validate({"data": place})
    assert restored.seed_key == backend.settings.seed_key
    assert restored.secret_key == backend.settings.secret_key
    modes = {(place / name).stat().st_mode & 0o777 for name in ("secret", "seed_key")}
    assert modes == {0o600}
