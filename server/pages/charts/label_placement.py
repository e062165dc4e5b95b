"""Where the labels of a plot's points go, so that none covers another label or a point.

Points are in percent of the plot, which is as wide as the screen lets it be; texts have the same
size everywhere. So a place is good if it is at every width that the plot may have. Labels are
placed in order, each where it is first free: the same points always give the same places.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

WIDTHS_PX = (240.0, 910.0)  # of the plot: on a phone of 360 px, on a wide screen
HEIGHT_PX = 288.0  # of .plot .plot-area in boards.css: 18rem
_CHARACTER_PX, _LINE_PX = 7.2, 15.0  # of the 12 px text there, in a wide font
_POINT_PX = 6.0  # radius with its outline
_BESIDE_PX = 9.0  # from a point to the text beside it
# Above and below, then on a level with the point, where lines of the plot often are.
_ROWS_PX = (
    *(-8.0, 8.0, 0.0),
    *(sign * (8.0 + 15.0 * row) for row in range(1, 8) for sign in (-1.0, 1.0)),
)
_FAR_PX = 12.0  # a text further up or down needs a line to its point
CHARACTERS_MAX = 24
Anchor = Literal["start", "middle", "end"]  # which part of a text is at dx


@dataclass(frozen=True, slots=True)
class Point:
    """A point of the plot and what stands beside it; an empty text: nothing."""

    x: float  # [%] from the left
    y: float  # [%] from the top
    text: str = ""


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle that hangs on a point: its edges are at so many pixels from it."""

    point: Point
    left: float
    right: float
    top: float
    bottom: float

    def across(self, width_px: float) -> tuple[float, float]:
        """Return both ends from the left of a plot of this width [px]."""
        at = self.point.x / 100.0 * width_px
        return at + self.left, at + self.right

    def down(self) -> tuple[float, float]:
        """Return both ends from the top [px]."""
        at = self.point.y / 100.0 * HEIGHT_PX
        return at + self.top, at + self.bottom

    def meets(self, other: "Box") -> bool:
        """Return whether the boxes overlap at any width of the plot."""
        (top, bottom), (others_top, others_bottom) = self.down(), other.down()
        if bottom <= others_top or others_bottom <= top:
            return False
        # The distance of the points is linear in the width: only its ends count.
        apart = [(self.point.x - other.point.x) / 100.0 * width for width in WIDTHS_PX]
        return max(apart) > other.left - self.right and min(apart) < other.right - self.left

    def is_inside(self) -> bool:
        """Return whether the box is in the plot at every width."""
        top, bottom = self.down()
        ends = [self.across(width) for width in WIDTHS_PX]
        across = all(
            left >= 0.0 and right <= w for w, (left, right) in zip(WIDTHS_PX, ends, strict=True)
        )
        return across and top >= 0.0 and bottom <= HEIGHT_PX


@dataclass(frozen=True, slots=True)
class Label:
    """A text beside its point."""

    text: str
    dx: float  # [px] from the point to the end of the text that is next to it
    dy: float  # [px] from the point to the middle of the line
    anchor: Anchor
    box: Box

    @property
    def is_far(self) -> bool:
        """Whether a line should lead from the point to it."""
        return abs(self.dy) > _FAR_PX


def place(points: Sequence[Point]) -> list[Label | None]:
    """Return the label of each point; None without a text, and where there is no room for it."""
    taken = [_mark(point) for point in points]
    placed: list[Label | None] = []
    for point in points:
        label = _first_free(point, taken) if point.text else None
        if label is not None:
            taken.append(label.box)
        placed.append(label)
    return placed


def _mark(point: Point) -> Box:
    return Box(point, -_POINT_PX, _POINT_PX, -_POINT_PX, _POINT_PX)


def _first_free(point: Point, taken: Sequence[Box]) -> Label | None:
    free = (label for label in _choices(point) if not any(map(label.box.meets, taken)))
    return next(free, None)


def _choices(point: Point) -> Iterator[Label]:
    """Iterate over the labels within the plot, the nearest first."""
    text = point.text
    if len(text) > CHARACTERS_MAX:
        text = f"{text[: CHARACTERS_MAX - 1].rstrip()}…"
    length = len(text) * _CHARACTER_PX
    sides: tuple[tuple[Anchor, float, float], ...] = (
        ("start", _BESIDE_PX, _BESIDE_PX),
        ("end", -_BESIDE_PX, -_BESIDE_PX - length),
        ("middle", 0.0, -length / 2.0),
    )
    for dy in _ROWS_PX:
        for anchor, dx, left in sides:
            box = Box(point, left, left + length, dy - _LINE_PX / 2.0, dy + _LINE_PX / 2.0)
            if box.is_inside():
                yield Label(text, dx, dy, anchor, box)
