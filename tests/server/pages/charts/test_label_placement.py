"""The judge draws the boxes anew, at widths of its own, from what the page gets."""

from itertools import combinations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seamark.server.pages.charts import label_placement
from seamark.server.pages.charts.label_placement import HEIGHT_PX, Label, Point

SCREENS_PX = (240, 257, 333, 480, 700, 905, 910)
Rectangle = tuple[float, float, float, float]  # left, top, right, bottom
_percent = st.floats(2.0, 98.0).map(lambda value: round(value, 2))
_points = st.lists(
    st.builds(Point, _percent, _percent, st.text("abc ", min_size=1, max_size=40)), max_size=25
)


def _drawn(point: Point, label: Label, width_px: int) -> Rectangle:
    length = 7.2 * len(label.text)
    x = point.x / 100.0 * width_px + label.dx
    y = point.y / 100.0 * HEIGHT_PX + label.dy
    left = x - {"start": 0.0, "middle": 0.5, "end": 1.0}[label.anchor] * length
    return left, y - 7.5, left + length, y + 7.5


def _dot(point: Point, width_px: int) -> Rectangle:
    x, y = point.x / 100.0 * width_px, point.y / 100.0 * HEIGHT_PX
    return x - 6.0, y - 6.0, x + 6.0, y + 6.0


def _overlap(one: Rectangle, other: Rectangle) -> bool:
    spare = 1e-6
    across = one[0] < other[2] - spare and other[0] < one[2] - spare
    return across and one[1] < other[3] - spare and other[1] < one[3] - spare


@settings(max_examples=60, deadline=None)
@given(points=_points)
def test_no_label_covers_another_one_or_a_point_on_any_screen(points: list[Point]) -> None:
    placed = label_placement.place(points)

    assert placed == label_placement.place(points)
    for width in SCREENS_PX:
        shown = [(p, label) for p, label in zip(points, placed, strict=True) if label is not None]
        labels = [_drawn(point, label, width) for point, label in shown]
        dots = [_dot(point, width) for point in points]
        assert not any(_overlap(one, other) for one, other in combinations(labels, 2))
        assert not any(_overlap(label, dot) for label in labels for dot in dots)
        assert all(left >= 0.0 and right <= width for left, _, right, _ in labels)
        assert all(top >= 0.0 and bottom <= HEIGHT_PX for _, top, _, bottom in labels)


@pytest.mark.parametrize("x", [2.0, 50.0, 98.0])
def test_close_points_all_get_their_labels(x: float) -> None:
    points = [Point(x, 40.0 + 3.0 * k, f"entry {k}") for k in range(6)]

    texts = [label and label.text for label in label_placement.place(points)]

    assert texts == [point.text for point in points]


def test_a_point_without_a_text_has_no_label_and_a_long_text_is_cut() -> None:
    nothing, long = label_placement.place([Point(10.0, 10.0), Point(50.0, 50.0, "w" * 80)])

    assert nothing is None
    assert long is not None
    assert long.text == "w" * 23 + "…"
