"""A self-test that has passed is not repeated until something changes that a box sees."""

import json
import os
import shutil
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.languages.language import ALL_ROLES, Language
from seamark.sandbox.outcome import SandboxBroken
from seamark.sandbox.probing import kept_tests
from seamark.sandbox.probing.kept_tests import KeptTests, state_of
from seamark.sandbox.probing.self_test import Result
from seamark.sandbox.runtime import BindMount, Runtime

MARK = "kept"  # no interpreter has this version


@pytest.fixture
def compiler(tmp_path: Path) -> Path:
    """A file that the boxes of the language `python` see beside the others."""
    path = tmp_path / "tools" / "compiler"
    path.parent.mkdir()
    path.write_text("an old compiler", encoding="utf-8")
    return path


@pytest.fixture
def language(compiler: Path, monkeypatch: pytest.MonkeyPatch) -> Language:
    def runtime() -> Runtime:
        known = python.runtime()
        return replace(known, mounts=(*known.mounts, BindMount(compiler.parent, "/box/tools")))

    python = LANGUAGES["python"]
    added = replace(python, runtime=runtime, roles=python.roles[:1])  # each is tested in a box
    for path in (compiler, compiler.parent, *compiler.parents):  # boxes have to enter it
        if path.stat().st_uid == os.geteuid() and path != Path("/"):
            path.chmod(path.stat().st_mode | 0o555)
    monkeypatch.setitem(LANGUAGES, python.name, added)
    return added


@pytest.fixture
def result(tmp_path: Path, isolation: IsolationLevel) -> Callable[[], Result]:
    """What a worker that starts finds out about `python`."""
    return lambda: KeptTests(isolation, kept_in=tmp_path / "kept").result("python")


def mark(folder: Path) -> None:
    """Have the kept result tell where it is from."""
    [file] = folder.iterdir()
    kept = json.loads(file.read_text())
    kept["contents"] = [{"kind": "interpreter", "name": "Python", "version": MARK}]
    file.write_text(json.dumps(kept))


def is_kept(found: Result) -> bool:
    return [component.version for component in found.contents] == [MARK]


def rewrite(compiler: Path) -> None:
    """Replace the content by one of the same size, and set the time back."""
    before = compiler.stat()
    compiler.write_text("a new* compiler", encoding="utf-8")
    os.utime(compiler, ns=(before.st_atime_ns, before.st_mtime_ns))


def replace_file(compiler: Path) -> None:
    other = compiler.with_name("other")
    shutil.copy2(compiler, other)
    other.rename(compiler)


CHANGES: dict[str, Callable[[Path], object]] = {
    "rewritten with the old time and size": rewrite,
    "replaced by a copy": replace_file,
    "no longer readable": lambda compiler: compiler.chmod(0),
    "removed": Path.unlink,
    "joined by another file": lambda compiler: compiler.with_name("linker").touch(),
    "renamed": lambda compiler: compiler.rename(compiler.with_name("cc")),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=list(CHANGES))
def test_a_state_differs_after_each_change_of_a_compiler(
    compiler: Path, change: Callable[[Path], object]
) -> None:
    folder = compiler.parents[1]
    before = state_of(folder)
    unchanged = state_of(folder) == before

    change(compiler)

    assert unchanged
    assert state_of(folder) != before


def test_bytecode_that_is_written_changes_no_state(compiler: Path) -> None:
    (compiler.parent / "__pycache__").mkdir()
    before = state_of(compiler.parent)

    (compiler.parent / "__pycache__" / "module.pyc").touch()

    assert state_of(compiler.parent) == before


@pytest.mark.host
@pytest.mark.usefixtures("language")
def test_a_language_is_tested_once_and_again_after_its_compiler_changed(
    result: Callable[[], Result], compiler: Path, tmp_path: Path
) -> None:
    first = result()
    mark(tmp_path / "kept")
    second = result()
    rewrite(compiler)
    third, fourth = result(), result()

    assert first.why_not == ""
    assert [is_kept(one) for one in (first, second, third)] == [False, True, False]
    assert first == third == fourth


@pytest.mark.host
def test_a_language_is_tested_again_on_another_day_and_with_other_self_tests(
    language: Language,
    result: Callable[[], Result],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    result()
    mark(tmp_path / "kept")
    kept = is_kept(result())

    [file] = (tmp_path / "kept").iterdir()
    old = json.loads(file.read_text())
    file.write_text(json.dumps(old | {"tested_at": time.time() - kept_tests.KEPT_S}))
    next_day = is_kept(result())
    mark(tmp_path / "kept")
    more = replace(language, roles=ALL_ROLES[:2])
    monkeypatch.setitem(LANGUAGES, "python", more)
    changed = is_kept(result())

    assert len(more.roles) > len(language.roles)
    assert (kept, next_day, changed) == (True, False, False)


@pytest.mark.host
@pytest.mark.usefixtures("language")
@pytest.mark.parametrize("text", ["", "[]", "{}", "null", '{"state": 1, "tested_at": ""}'])
def test_what_is_no_kept_result_is_none(
    result: Callable[[], Result], tmp_path: Path, text: str
) -> None:
    result()
    [file] = (tmp_path / "kept").iterdir()

    file.write_text(text)

    assert result().why_not == ""
    assert json.loads(file.read_text())["contents"]


@pytest.mark.host
def test_a_failure_is_not_kept(
    language: Language,
    result: Callable[[], Result],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def missing() -> Runtime:
        raise SandboxBroken("the interpreter is missing")

    without = replace(language, runtime=missing)
    monkeypatch.setitem(LANGUAGES, "python", without)
    failed = result()
    monkeypatch.setitem(LANGUAGES, "python", language)

    assert failed.why_not == "the interpreter is missing"
    assert not (tmp_path / "kept").exists()
    assert result().why_not == ""


@pytest.mark.host
@pytest.mark.usefixtures("language")
def test_a_folder_that_cannot_be_written_to_only_keeps_nothing(
    isolation: IsolationLevel,
) -> None:
    assert KeptTests(isolation, kept_in=Path("/proc/kept")).result("python").why_not == ""
