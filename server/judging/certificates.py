"""Certificates: which place a team has, as an SVG to print or to show.

A page of A4 across. It has no font of its own: whatever script a name is in, the reader's fonts
have it. Long names are squeezed into their lines.
"""

from dataclasses import dataclass
from html import escape

import svg

_WIDTH, _HEIGHT = 1123, 794  # [px], A4 across at 96 dpi
_MARGIN, _ROOM = 48, 880
_INK, _SEA, _SAND = "#12303f", "#0b6e8f", "#f6f2e9"
_FONT = "Georgia,'DejaVu Serif',serif"
_WIDE = 0.58  # of the font size: width of a character on average; E


@dataclass(frozen=True, slots=True, kw_only=True)
class Certificate:
    """What a certificate says."""

    competition: str  # its title
    place: int
    of: int  # entries with a place
    ranks: str  # empty, or a sentence: the ranks that the trials leave possible
    team: str
    members: str
    method: str
    score: str  # with its unit and interval
    trials: int
    organiser: str
    date: str
    address: str  # of the results
    digest: str  # SHA-256 of the frozen document


def drawn(certificate: Certificate) -> str:
    """Return the certificate as an SVG document."""
    middle = _WIDTH / 2
    title = f"Place {certificate.place} in {certificate.competition}: {certificate.team}"
    lines = [
        (170, 26, _SEA, certificate.competition),
        (270, 64, _INK, f"Place {certificate.place}"),
        (312, 20, _INK, f"of {certificate.of}{certificate.ranks}"),
        (400, 46, _SEA, certificate.team),
        (440, 18, _INK, certificate.members),
        (510, 24, _INK, f"with the method {certificate.method}"),
        (550, 18, _INK, f"{certificate.score} over {certificate.trials} trials in the same water"),
        (640, 18, _INK, f"{certificate.organiser} · {certificate.date}"),
        (690, 13, _INK, certificate.address),
        (712, 11, _INK, f"Rules and scenario frozen as SHA-256 {certificate.digest}"),
    ]
    return svg.SVG(
        width=_WIDTH,
        height=_HEIGHT,
        viewBox=svg.ViewBoxSpec(0, 0, _WIDTH, _HEIGHT),
        elements=[
            svg.Title(text=escape(title)),
            svg.Rect(x=0, y=0, width=_WIDTH, height=_HEIGHT, fill=_SAND),
            _frame(_MARGIN, 4),
            _frame(_MARGIN + 10, 1),
            *(_line(middle, *line) for line in lines if line[-1]),
            _wave(middle),
        ],
    ).as_str()


def _frame(margin: int, stroke_width: int) -> svg.Rect:
    return svg.Rect(
        x=margin,
        y=margin,
        width=_WIDTH - 2 * margin,
        height=_HEIGHT - 2 * margin,
        fill="none",
        stroke=_SEA,
        stroke_width=stroke_width,
    )


def _line(middle: float, y: int, size: int, colour: str, text: str) -> svg.Text:
    squeezed = len(text) * size * _WIDE > _ROOM
    return svg.Text(
        x=middle,
        y=y,
        text=escape(text),
        text_anchor="middle",
        font_family=_FONT,
        font_size=size,
        fill=colour,
        textLength=_ROOM if squeezed else None,
        lengthAdjust="spacingAndGlyphs" if squeezed else None,
    )


def _wave(middle: float) -> svg.Path:
    steps = [svg.Q(middle - 75 + 50 * at, 92, middle - 50 + 50 * at, 110) for at in range(4)]
    return svg.Path(d=[svg.M(middle - 100, 110), *steps], fill="none", stroke=_SEA, stroke_width=4)
