"""Text of programs and people for terminals, pages and logs: it acts on nothing that shows it."""

import unicodedata


def visible_text(text: str, *, keep: str = "") -> str:
    """Return the text without control, invisible and unassigned characters, except for `keep`.

    For names and titles, in which nobody misses them: they could turn the direction of the text
    around, or make two names look the same.
    """
    return "".join(c for c in text if c in keep or _is_visible(c))


def printable_text(text: str) -> str:
    """Return the text with every character that is not printable written as an escape.

    These are control characters (an escape sequence of a terminal sets its title or writes to the
    clipboard), characters that reverse the direction of writing or are invisible, and surrogates.
    Line ends and tabs stay.
    """
    lines = text.replace("\r\n", "\n").split("\n")
    return "\n".join(map(_printable_line, lines))


def _printable_line(line: str) -> str:
    if line.isprintable():  # nearly all are
        return line
    return "".join(c if c.isprintable() or c == "\t" else _escape(c) for c in line)


def _is_visible(character: str) -> bool:
    category = unicodedata.category(character)
    return category[0] != "C" and category not in {"Zl", "Zp"}


def _escape(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")
