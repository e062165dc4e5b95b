"""A curve of the error of a run as points of a small picture in a row of a table."""

from itertools import groupby

from seamark.server.runs.data.error_curve import Curve

WIDTH, HEIGHT = 96.0, 24.0
_MARGIN = 2.0


def segments(curve: Curve | None) -> list[str]:
    """Return the points of its lines, as SVG has them: a line ends where there is no value.

    The picture reaches from 0 to the largest value.
    """
    values = curve or []
    largest = max((value for value in values if value is not None), default=0.0) or 1.0
    step = WIDTH / max(len(values) - 1, 1)
    height = HEIGHT - 2 * _MARGIN
    points = [
        None
        if value is None
        else f"{at * step:.1f},{HEIGHT - _MARGIN - height * value / largest:.1f}"
        for at, value in enumerate(values)
    ]
    runs = groupby(points, key=lambda point: point is not None)
    return [" ".join(str(point) for point in part) for known, part in runs if known]
