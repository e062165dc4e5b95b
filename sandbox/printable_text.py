"""Text of programs for terminals, pages and logs: nothing in it acts on what displays it."""


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


def _escape(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")
