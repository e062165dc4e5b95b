"""Tables as Markdown."""

import math
from collections.abc import Iterable, Sequence


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a Markdown table; cells are converted with `str` and their bars escaped."""
    lines = [_line(header), "|" + "---|" * len(header)]
    return "\n".join([*lines, *(_line(row) for row in rows)])


def _line(cells: Sequence[object]) -> str:
    return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"


def signed(value: float, digits: int = 1) -> str:
    """Return the formatted number, never as -0.0."""
    text = f"{value:.{digits}f}"
    return text[1:] if float(text) == 0.0 and text.startswith("-") else text


def below(value: float) -> str:
    """Return the next power of ten above a positive rounding error, such as "< 1e-05".

    Its digits depend on the processor, its size does not.
    """
    return f"< {10.0 ** (math.floor(math.log10(value)) + 1):.0e}" if value > 0.0 else "0"
