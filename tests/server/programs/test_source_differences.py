"""Lines in which two programs differ: what is shown, and what hostile programs cost."""

import pytest

from seamark.programs.archives import normal_form
from seamark.sandbox.limits import Limits
from seamark.server.programs.source_differences import (
    COLUMNS_MAX,
    LINES_MAX,
    SHOWN_MAX,
    FileDifference,
    differences,
    files_of,
)

TEXT = [f"line {number}" for number in range(1, 21)]


def _of_lines(first: list[str], second: list[str]) -> FileDifference:
    (found,) = differences(
        {"mine.py": "\n".join(first).encode()}, {"other.py": "\n".join(second).encode()}
    )
    return found


def _shown(found: FileDifference) -> list[str]:
    return [line.mark + line.text for line in found.lines]


def test_a_changed_line_is_shown_with_the_lines_around_it() -> None:
    found = _of_lines(TEXT, [*TEXT[:9], "line X", *TEXT[10:]])

    around = [" line 7", " line 8", " line 9", "-line 10", "+line X", " line 11", " line 12"]
    assert (found.path, found.note) == ("other.py", "")
    assert _shown(found) == ["@line 7", *around, " line 13"]


def test_changes_far_apart_are_shown_apart() -> None:
    found = _of_lines(TEXT, ["line X", *TEXT[1:], "line 21"])

    places = [line for line in _shown(found) if line.startswith("@")]
    assert places == ["@line 1", "@line 18"]


def test_the_same_programs_differ_in_no_file() -> None:
    assert differences({"a.py": b"x = 1\n"}, {"a.py": b"x = 1\n"}) == ()


def test_the_files_of_archives_are_compared_by_their_paths() -> None:
    archives = [
        normal_form(files, limits=Limits())
        for files in (
            {"controller.py": b"KP = 0.4\n", "gains.npy": b"\x93NUMPY\xff", "old.py": b""},
            {"controller.py": b"KP = 0.5\n", "gains.npy": b"\x93NUMPY\xfe", "new.py": b""},
        )
    ]

    found = differences(*(files_of("mine.zip", content) for content in archives))

    assert {each.path: (_shown(each), each.note) for each in found} == {
        "controller.py": (["@line 1", "-KP = 0.4", "+KP = 0.5"], ""),
        "gains.npy": ([], "The file is not text."),
        "new.py": ([], "Only the second program has this file."),
        "old.py": ([], "Only the first program has this file."),
    }


@pytest.mark.parametrize(
    ("first", "second"),
    [
        # Each of 100,000 equal lines may start a match with each of 100,000 others.
        (["", "a"] * 50_000, ["a", ""] * 50_000 + ["b"]),
        # Every other line matches, one at a time: difflib looks at all the others each time.
        ([f"{n // 2}" if n % 2 else f"a{n}" for n in range(20_000)],
         [f"{n // 2}" if n % 2 else f"b{n}" for n in range(20_000)]),
    ],
    ids=["equal lines", "every other line"],
)  # fmt: skip
def test_programs_that_would_take_difflib_hours_are_not_compared(
    first: list[str], second: list[str]
) -> None:
    found = _of_lines(first, second)

    assert found.lines == ()
    assert "Download the programs" in found.note


def test_as_many_lines_as_are_compared_take_a_moment_however_they_repeat() -> None:
    half = LINES_MAX // 2
    found = _of_lines(["", "a"] * half, ["b", *(["a", ""] * (half - 1)), "c"])

    assert found.lines


def test_all_files_of_a_program_share_one_limit() -> None:
    first, second = (
        {f"{n:03}.py": f"{letter}\n".encode() * (LINES_MAX // 10) for n in range(100)}
        for letter in "ab"
    )

    found = differences(first, second)

    assert sum(len(each.lines) for each in found) == SHOWN_MAX
    assert sum("Download the programs" in each.note for each in found) > 90


def test_long_lines_are_cut_and_what_cannot_be_printed_is_escaped() -> None:
    found = _of_lines(["x" * 10**5], ["\x1b[31m\u202edrowssap"])

    assert _shown(found)[1:] == ["-" + "x" * COLUMNS_MAX + "…", r"+\x1b[31m\u202edrowssap"]


@pytest.mark.parametrize("content", [b"\0", b"\xff\xfe", b"PK\x03\x04"])
def test_what_is_not_text_has_no_lines(content: bytes) -> None:
    (found,) = differences({"a.fmu": content}, {"a.fmu": b"\0" + content})

    assert (found.lines, found.note) == ((), "The file is not text.")
