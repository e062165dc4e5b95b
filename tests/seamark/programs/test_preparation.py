from pathlib import Path

import pytest

from seamark.programs import archives, preparation
from seamark.programs.preparation import PreparedProgram, UploadRejected
from seamark.sandbox.limits import Limits

GOOD = b"class Controller(Base):\n    pass\n"
STEP = "    def __init__(self, config): ...\n    def step(self, observation): ...\n"


def _clean(source: bytes, name: str = "mine.py") -> PreparedProgram:
    prepared = preparation.prepare(source, name)
    prepared.require_clean()
    return prepared


@pytest.mark.parametrize(
    ("source", "name", "says"),
    [
        (b"", "a.py", "empty"),
        (b" \n", "a.py", "empty"),
        (GOOD, "a.exe", r"\.exe is not a type of program. Executables .* 64-bit Linux"),
        (GOOD, "", "no name"),
        (GOOD, "a/..", "no name"),
        (b"\n\xff" + GOOD, "a.py", "line 2.*UTF-8"),
        (b"def f(:\n", "a.py", "line 1"),
        (b"x = 1\n", "a.py", "Controller"),
        (b"int x;\n\xff", "a.c", "line 2.*UTF-8"),
        (b"\n", "a.cpp", "empty"),
        (b"\0" + GOOD, "a.py", "cannot be parsed"),
        (b"(" * 900 + GOOD, "a.py", "line 1|cannot be parsed"),
        (GOOD, "a.txt", r"\.txt is not a type of program.*\.py"),
        (GOOD, "a.ipynb", "notebook"),
        (b"PK", "a.slx", r"upload the \.fmu file, or generate C with Embedded Coder"),
        (b"08", "policy.onnx", "main.py"),
        (b"// h", "a.hpp", "archive"),
        (b"% x\n classdef Mine < handle\nend\n", "a.m", "line 2: .*controller_step"),
    ],
)
def test_an_upload_that_breaks_a_rule_is_refused_with_a_message(
    source: bytes, name: str, says: str
) -> None:
    with pytest.raises(UploadRejected, match=says):
        _clean(source, name)


@pytest.mark.parametrize(
    ("name", "language"),
    [("a.py", "python"), ("a.c", "c"), ("A.C", "c"), ("a.cpp", "c++"), ("a.cc", "c++")],
)
def test_the_language_is_that_of_the_suffix(name: str, language: str) -> None:
    assert _clean(GOOD, name).language == language


def test_a_program_in_c_is_checked_only_by_its_compiler() -> None:
    assert _clean(b"this is no C", "a.c").content == b"this is no C"


def test_an_upload_is_not_executed_while_it_is_checked(tmp_path: Path) -> None:
    mark = tmp_path / "executed"

    _clean(f"open({str(mark)!r}, 'w')\n".encode() + GOOD)

    assert not mark.exists()


@pytest.mark.parametrize(
    "name", ["../../etc/mine.py", "C:\\x\\mine.py", "mi\x00ne.py", "m\nine.py"]
)
def test_a_file_name_loses_its_folders_and_control_characters(name: str) -> None:
    assert _clean(GOOD, name).name == "mine.py"


def _hierarchy(levels: int, bases: str) -> str:
    classes = "".join(f"class C{i + 1}({bases.format(i)}): pass\n" for i in range(levels))
    return f"class C0:\n{STEP}\n{classes}class Controller(C{levels}): pass\n"


@pytest.mark.parametrize(
    ("levels", "bases"), [(60, "C{0}, C{0}"), (3000, "C{0}")], ids=["doubling", "a chain"]
)
def test_base_classes_are_followed_in_linear_time_to_any_depth(levels: int, bases: str) -> None:
    source = _hierarchy(levels, bases)

    assert _clean(source.encode()).diagnostics == ()
    missing = preparation.prepare(source.replace("def step", "def stop").encode(), "mine.py")
    assert "has no method step" in missing.diagnostics[0].sentence


def test_classes_that_are_bases_of_each_other_are_followed_once() -> None:
    source = "class A(Controller): pass\nclass Controller(A):\n" + STEP

    assert _clean(source.encode()).diagnostics == ()


def test_a_folder_is_packed_as_the_archive_of_its_files_without_hidden_ones(tmp_path: Path) -> None:
    files = {"controller.py": GOOD, "law/pid.py": b"x = 1\n"}
    hidden = {".env": b"secret", ".venv/lib.py": b"y = 1\n", "__pycache__/law.pyc": b"\0"}
    for name, content in (files | hidden).items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)

    packed = archives.of_folder(tmp_path, limits=Limits())

    assert packed == archives.normal_form(files, limits=Limits())
    assert preparation.prepare(packed, "mine.zip").language == "python"


@pytest.mark.parametrize(
    ("limits", "says"),
    [
        (Limits(archive_files=2), "more than 2 files"),
        (Limits(source_kib=1), "larger than 0.00097"),
    ],
)
def test_a_folder_is_read_no_further_than_an_archive_may_go(
    tmp_path: Path, limits: Limits, says: str
) -> None:
    for name in ("controller.py", "a.bin", "b.bin"):
        (tmp_path / name).write_bytes(bytes(500))

    with pytest.raises(archives.ArchiveRefused, match=says):
        archives.of_folder(tmp_path, limits=limits)


@pytest.mark.parametrize(
    ("names", "language"),
    [
        (["controller.c", "controller.py"], "c"),
        (["main.py", "controller.c"], "python"),
        (["controller.py", "arm.py"], "python"),
    ],
)
def test_the_main_file_of_an_archive_says_its_language(names: list[str], language: str) -> None:
    packed = archives.normal_form(dict.fromkeys(names, GOOD), limits=Limits())

    assert preparation.prepare(packed, "mine.zip").language == language
