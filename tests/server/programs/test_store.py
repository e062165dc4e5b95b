import os
import threading
from concurrent.futures import ThreadPoolExecutor
from io import BytesIO
from pathlib import Path

import pytest

from seamark.server.programs import store
from seamark.server.programs.store import UploadRejected

GOOD = b"class Controller(Base):\n    pass\n"


def _store(source: bytes, data: Path, name: str = "mine.py") -> store.StoredProgram:
    return store.save_upload(BytesIO(source), name, limit=1000, data=data)


def test_a_program_is_stored_once_under_its_hash(tmp_path: Path) -> None:
    first, second = _store(GOOD, tmp_path), _store(GOOD, tmp_path, "other.py")

    assert first.sha256 == second.sha256
    assert store.read(tmp_path, first.sha256) == GOOD
    assert len(list((tmp_path / "programs").iterdir())) == 1


@pytest.mark.parametrize(
    ("source", "name", "says"),
    [
        (b"", "a.py", "empty"),
        (b" \n", "a.py", "empty"),
        (b"x" * 1001, "a.py", "larger"),
        (GOOD, "a.exe", "not supported"),
        (GOOD, "", "no name"),
        (GOOD, "a/..", "no name"),
        (b"\n\xff" + GOOD, "a.py", "line 2.*UTF-8"),
        (b"def f(:\n", "a.py", "line 1"),
        (b"x = 1\n", "a.py", "Controller"),
        (b"int x;\n\xff", "a.c", "line 2.*UTF-8"),
        (b"\n", "a.cpp", "empty"),
        (b"\0" + GOOD, "a.py", "cannot be parsed"),
        (b"(" * 900 + GOOD, "a.py", "line 1|cannot be parsed"),
    ],
)
def test_an_upload_that_breaks_a_rule_is_refused_with_a_message(
    tmp_path: Path, source: bytes, name: str, says: str
) -> None:
    with pytest.raises(UploadRejected, match=says):
        _store(source, tmp_path, name)
    assert not (tmp_path / "programs").exists()


@pytest.mark.parametrize(
    ("name", "language"),
    [("a.py", "python"), ("a.c", "c"), ("A.C", "c"), ("a.cpp", "c++"), ("a.cc", "c++")],
)
def test_the_language_is_that_of_the_suffix(tmp_path: Path, name: str, language: str) -> None:
    assert _store(GOOD, tmp_path, name).language == language


def test_a_program_in_c_is_checked_only_by_its_compiler(tmp_path: Path) -> None:
    assert _store(b"this is no C", tmp_path, "a.c").size == 12


def test_an_upload_is_not_executed_while_it_is_checked(tmp_path: Path) -> None:
    mark = tmp_path / "executed"

    _store(f"open({str(mark)!r}, 'w')\n".encode() + GOOD, tmp_path)

    assert not mark.exists()


@pytest.mark.parametrize(
    "name", ["../../etc/mine.py", "C:\\x\\mine.py", "mi\x00ne.py", "m\nine.py"]
)
def test_a_file_name_loses_its_folders_and_control_characters(tmp_path: Path, name: str) -> None:
    assert _store(GOOD, tmp_path, name).name == "mine.py"


def test_an_upload_too_large_is_not_read_to_its_end(tmp_path: Path) -> None:
    stream = BytesIO(b"x" * 10_000_000)

    with pytest.raises(UploadRejected):
        store.save_upload(stream, "a.py", limit=1000, data=tmp_path)

    assert stream.tell() < 200_000


@pytest.mark.parametrize("key", ["", "../secret", "A" * 64, "0" * 63])
def test_a_program_is_found_only_by_a_valid_hash(tmp_path: Path, key: str) -> None:
    with pytest.raises(ValueError, match="SHA-256"):
        store.path(tmp_path, key)


def test_only_old_unreferenced_programs_are_deleted(tmp_path: Path) -> None:
    kept = [_store(GOOD + b"# %d" % number, tmp_path).sha256 for number in range(3)]
    for sha256 in kept[:2]:
        os.utime(store.path(tmp_path, sha256), (0, 0))

    gone = store.delete_unused(tmp_path, older_than_s=60, used=lambda key: key == kept[0])

    assert gone == 1
    assert [store.touch(tmp_path, sha256) for sha256 in kept] == [True, False, True]


def test_uploading_a_program_again_renews_its_age(tmp_path: Path) -> None:
    sha256 = _store(GOOD, tmp_path).sha256
    os.utime(store.path(tmp_path, sha256), (0, 0))

    _store(GOOD, tmp_path)

    assert store.delete_unused(tmp_path, older_than_s=60, used=lambda _: False) == 0


def test_two_workers_delete_every_unused_program_once(tmp_path: Path) -> None:
    for number in range(3):
        sha256 = _store(GOOD + b"# %d" % number, tmp_path).sha256
        os.utime(store.path(tmp_path, sha256), (0, 0))
    deleted_by_other = []

    def used(_: str) -> bool:  # called between listing the folder and taking the lock
        other = store.delete_unused(tmp_path, older_than_s=60, used=lambda _: False)
        deleted_by_other.append(other)
        return False

    deleted = store.delete_unused(tmp_path, older_than_s=60, used=used)

    assert (deleted_by_other, deleted) == ([3], 0)


def test_uploads_survive_two_workers_that_delete_at_the_same_time(tmp_path: Path) -> None:
    ended = threading.Event()

    def delete() -> None:
        while not ended.is_set():
            store.delete_unused(tmp_path, older_than_s=60, used=lambda _: False)

    with ThreadPoolExecutor(2) as workers:
        deleting = [workers.submit(delete) for _ in range(2)]
        for number in range(300):  # every file is first a draft, which is then renamed
            sha256 = _store(GOOD + b"# %d" % number, tmp_path).sha256
            assert store.read(tmp_path, sha256)
            os.utime(store.path(tmp_path, sha256), (0, 0))
        ended.set()

    assert [one.result() for one in deleting] == [None, None]
