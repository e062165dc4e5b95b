"""The badge of a published run: a small SVG picture for pages elsewhere, readable without colour.

It has no script, no link and no font of its own; texts are escaped, and squeezed into their boxes
where a reader's font is wider than the one that the widths are from.
"""

from html import escape
from itertools import accumulate

TEXT_MAX = 100  # [character] of each part
_HEIGHT, _PADDING, _CHARACTER = 20, 6, 6.6  # [px]; of a character of 11 px Verdana, on average
# Of label, value and caution; all with white text above 4.5:1 (WCAG 2.2 AA)
_FILLS = ("#12303f", "#0b6e8f", "#7a4300")


def svg(label: str, value: str, caution: str = "") -> str:
    """Return the badge with a label, what it is about, and what keeps others from comparing it."""
    parts = [_short(part) for part in ((label, value, caution) if caution else (label, value))]
    edges = [0, *accumulate(map(_width, parts))]
    first, *rest = parts
    name = escape(f"{first}: {', '.join(rest)}", quote=True)
    fills = zip(edges, parts, _FILLS, strict=False)
    boxes = (
        f'<rect x="{x}" width="{_width(part)}" height="{_HEIGHT}" fill="{fill}"/>'
        for x, part, fill in fills
    )
    texts = (_text(part, at=x) for x, part in zip(edges, parts, strict=False))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{edges[-1]}" height="{_HEIGHT}" '
        f'role="img" aria-label="{name}"><title>{name}</title>'
        f'<clipPath id="round"><rect width="{edges[-1]}" height="{_HEIGHT}" rx="3"/></clipPath>'
        f'<g clip-path="url(#round)">{"".join(boxes)}</g>'
        '<g fill="#fff" font-family="Verdana,DejaVu Sans,sans-serif" font-size="11">'
        f"{''.join(texts)}</g></svg>\n"
    )


def _text(text: str, *, at: int) -> str:
    room = _width(text) - 2 * _PADDING
    return f'<text x="{at + _PADDING}" y="14" textLength="{room}">{escape(text)}</text>'


def _width(text: str) -> int:
    return round(len(text) * _CHARACTER) + 2 * _PADDING


def _short(text: str) -> str:
    return text if len(text) <= TEXT_MAX else f"{text[: TEXT_MAX - 1]}…"
