"""TOML that may come from anybody, read in bounded time and memory.

`tomllib` recurses for every nested bracket, and looks up every part of a header for every key below
it. So size, nesting and the length of lines and keys are limited before it sees the text.
"""

import re
import tomllib
from typing import Any

BYTES_MAX = 256 * 1024
LINE_MAX = 2000  # characters
NESTING_MAX = 8  # brackets in brackets
KEY_PARTS_MAX = 4  # a.b.c.d
VALUES_MAX = 20_000
_OPAQUE = re.compile(r'"(?:[^"\\]|\\.)*"|\'[^\']*\'|#.*')  # strings and comments of a line
_BRACKET = re.compile(r"[\[\]{}]")


class TomlRefused(Exception):
    """It is not TOML, or more of it than is read. The text is for the user."""


def read_toml(content: bytes) -> dict[str, Any]:
    """Return the document.

    Raises
    ------
    TomlRefused
        It is not valid, or exceeds a limit.
    """
    if len(content) > BYTES_MAX:
        raise TomlRefused(f"The file has {len(content)} bytes; at most {BYTES_MAX} are read.")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise TomlRefused(
            f"The file is not UTF-8: byte {error.start} is 0x{content[error.start]:02x}. Save it "
            "as UTF-8."
        ) from None
    _check_shape(text)
    try:
        document = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise TomlRefused(f"The file is not valid TOML: {error}.") from None
    if _count(document) > VALUES_MAX:
        raise TomlRefused(f"The file has more than {VALUES_MAX} values.")
    return document


def without_texts(line: str) -> str:
    """Return a line without its comment, and an underscore for each text in it."""
    return _OPAQUE.sub(lambda match: "" if match[0].startswith("#") else "_", line)


def _check_shape(text: str) -> None:
    if '"""' in text or "'''" in text:
        raise TomlRefused("Texts of several lines (three quotes) are not read: use one line.")
    nesting = 0
    for number, line in enumerate(text.split("\n"), start=1):
        if len(line) > LINE_MAX:
            raise TomlRefused(f"Line {number} is longer than {LINE_MAX} characters; break it.")
        bare = without_texts(line)
        key = bare if bare.lstrip().startswith("[") else bare.partition("=")[0]
        if nesting == 0 and key.count(".") >= KEY_PARTS_MAX:
            raise TomlRefused(f"The key in line {number} has more than {KEY_PARTS_MAX} parts.")
        for bracket in _BRACKET.findall(bare):
            nesting = nesting + 1 if bracket in "[{" else max(nesting - 1, 0)
            if nesting > NESTING_MAX:
                raise TomlRefused(
                    f"Line {number} nests more than {NESTING_MAX} brackets in each other."
                )


def _count(document: dict[str, Any]) -> int:
    count, waiting = 0, [document.values()]
    while waiting:
        for value in waiting.pop():
            count += 1
            if isinstance(value, dict):
                waiting.append(value.values())
            elif isinstance(value, list):
                waiting.append(value)  # type: ignore[arg-type]
    return count
