"""Which lines of two programs differ, as far as that is quick to find and short enough to read.

Programs are uploads, and difflib's time grows with the cube of the lines in the worst case: equal
lines at the start and at the end are left out first, the rest has at most `LINES_MAX` lines in all
files together, and a line that is repeated often may extend a match but not start one.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher

from seamark.programs import archives
from seamark.sandbox.printable_text import printable_text

BYTES_MAX = 256 << 10  # of a file whose lines are compared
LINES_MAX = 2000  # that may differ in all files of a program, from the first to the last that does
SHOWN_MAX = 400  # lines shown of two programs
COLUMNS_MAX = 200  # characters shown of a line
CONTEXT = 3  # equal lines around one that differs
_STEPS_MAX = 4_000_000  # of the inner loop of difflib: 0.2 s


@dataclass(frozen=True, slots=True)
class Line:
    """A line of a difference.

    Attributes
    ----------
    mark
        "-" only in the first program, "+" only in the second one, " " in both, "@" no line of
        them: it says where the next ones stand.
    """

    mark: str
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class FileDifference:
    """A file that is not the same in two programs."""

    path: str
    lines: tuple[Line, ...] = ()
    note: str = ""  # what is not shown, as a sentence


def differences(
    first: Mapping[str, bytes], second: Mapping[str, bytes]
) -> tuple[FileDifference, ...]:
    """Return the files that differ in two programs, path -> content, in the order of the paths.

    Single files are compared whatever their names are.
    """
    if len(first) == len(second) == 1:
        first = dict(zip(second, first.values(), strict=True))
    files, lines_left, shown_left = [], LINES_MAX, SHOWN_MAX
    for path in sorted({*first, *second}):
        before, after = first.get(path), second.get(path)
        if before == after:
            continue
        if note := _not_shown(before, after):
            files.append(FileDifference(path=path, note=note))
            continue
        texts = _Texts.of(_lines_of(before), _lines_of(after))
        if texts.length > lines_left or not shown_left:
            files.append(FileDifference(path=path, note=_TOO_LONG))
            continue
        lines_left -= texts.length
        lines = tuple(_grouped(texts))
        note = "" if len(lines) <= shown_left else f"Only the first {shown_left} lines are shown."
        files.append(FileDifference(path=path, lines=lines[:shown_left], note=note))
        shown_left -= min(len(lines), shown_left)
    return tuple(files)


def files_of(name: str, content: bytes) -> dict[str, bytes]:
    """Return path -> content of a stored program; of a single file, with its name as the path."""
    return archives.read_normal(content) if archives.is_archive(name) else {name: content}


_TOO_LONG = "Too many lines differ to show them here. Download the programs to compare them."


@dataclass(frozen=True, slots=True)
class _Texts:
    """The lines of two files between those that are equal at the start and at the end."""

    start: int  # equal lines before
    first: Sequence[str]
    second: Sequence[str]
    before: Sequence[str]  # equal lines just before and after, to be shown
    after: Sequence[str]

    @property
    def length(self) -> int:
        return max(len(self.first), len(self.second))

    @classmethod
    def of(cls, first: Sequence[str], second: Sequence[str]) -> "_Texts":
        shortest = min(len(first), len(second))
        start = next((at for at in range(shortest) if first[at] != second[at]), shortest)
        rest = shortest - start
        same = next((at for at in range(rest) if first[-1 - at] != second[-1 - at]), rest)
        end = len(first) - same
        return cls(
            start,
            first[start:end],
            second[start : len(second) - same],
            first[max(start - CONTEXT, 0) : start],
            first[end : end + CONTEXT],
        )


def _not_shown(before: bytes | None, after: bytes | None) -> str:
    """Return why the lines of a file are not compared; empty if they are."""
    if before is None:
        return "Only the second program has this file."
    if after is None:
        return "Only the first program has this file."
    if max(len(before), len(after)) > BYTES_MAX:
        return f"The file is larger than {BYTES_MAX >> 10} KiB: its lines are not compared."
    return "" if _is_text(before) and _is_text(after) else "The file is not text."


def _is_text(content: bytes) -> bool:
    try:
        return "\0" not in content.decode()
    except UnicodeDecodeError:
        return False


def _lines_of(content: bytes | None) -> list[str]:
    return (content or b"").decode().splitlines()


def _grouped(texts: _Texts) -> Iterator[Line]:
    first, second = ([*texts.before, *part, *texts.after] for part in (texts.first, texts.second))
    # Not difflib's own rule for repeated lines: it lets 1 % of the lines be alike.
    repeated = _repeated(second)
    matcher = SequenceMatcher(repeated.__contains__, first, second, autojunk=False)
    before = texts.start - len(texts.before)
    for group in matcher.get_grouped_opcodes(CONTEXT):
        at = before + group[0][3] + 1
        yield Line("@", f"line {at}")
        for tag, low, high, start, stop in group:
            if tag == "equal":
                yield from (_line(" ", text) for text in first[low:high])
                continue
            yield from (_line("-", text) for text in first[low:high])
            yield from (_line("+", text) for text in second[start:stop])


def _repeated(lines: Sequence[str]) -> frozenset[str]:
    """Return the lines that occur too often to try each of them as the start of a match."""
    most = max(_STEPS_MAX // max(len(lines), 1) ** 2, 1)
    return frozenset(line for line, times in Counter(lines).items() if times > most)


def _line(mark: str, text: str) -> Line:
    shown = printable_text(text[:COLUMNS_MAX])
    return Line(mark, shown if len(text) <= COLUMNS_MAX else f"{shown}…")
