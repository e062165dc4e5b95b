"""The badge of a published run: a small SVG picture for pages elsewhere, readable without colour.

It has no script, no link and no font of its own; texts are escaped, and squeezed into their boxes
where a reader's font is wider than the one that the widths are from.
"""

from html import escape

TEXT_MAX = 60  # [character] of each half
_HEIGHT, _PADDING, _CHARACTER = 20, 6, 6.6  # [px]; of a character of 11 px Verdana, on average
_LEFT, _RIGHT = "#12303f", "#0b6e8f"  # both with white text above 4.5:1 (WCAG 2.2 AA)


def svg(label: str, value: str) -> str:
    """Return the badge with a label and what it is about."""
    label, value = _short(label), _short(value)
    left, right = _width(label), _width(value)
    name = escape(f"{label}: {value}", quote=True)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{left + right}" height="{_HEIGHT}" '
        f'role="img" aria-label="{name}"><title>{name}</title>'
        f'<clipPath id="round"><rect width="{left + right}" height="{_HEIGHT}" rx="3"/></clipPath>'
        f'<g clip-path="url(#round)"><rect width="{left}" height="{_HEIGHT}" fill="{_LEFT}"/>'
        f'<rect x="{left}" width="{right}" height="{_HEIGHT}" fill="{_RIGHT}"/></g>'
        '<g fill="#fff" font-family="Verdana,DejaVu Sans,sans-serif" font-size="11">'
        f"{_text(label, at=0)}{_text(value, at=left)}</g></svg>\n"
    )


def _text(text: str, *, at: int) -> str:
    room = _width(text) - 2 * _PADDING
    return f'<text x="{at + _PADDING}" y="14" textLength="{room}">{escape(text)}</text>'


def _width(text: str) -> int:
    return round(len(text) * _CHARACTER) + 2 * _PADDING


def _short(text: str) -> str:
    return text if len(text) <= TEXT_MAX else f"{text[: TEXT_MAX - 1]}…"
