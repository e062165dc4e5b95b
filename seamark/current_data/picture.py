"""A picture of a record of currents: its speed over time, and its profile."""

from __future__ import annotations

from html import escape

import numpy as np
from numpy.typing import NDArray

from seamark.sim.physics.water_motion.record import Record

_WIDTH, _HEIGHT, _MARGIN, _GAP = 900.0, 320.0, 48.0, 60.0
_SIDE = 220.0  # of the profile
_POINTS_MAX = 1200
_INK, _LINE, _DOWN = "#334155", "#1d4ed8", "#c2410c"
Array = NDArray[np.float64]


def picture(record: Record) -> str:
    """Return an SVG: speed at the middle height over time, mean and largest speed over height."""
    speed = np.sqrt(record.velocity[:, 0] ** 2 + record.velocity[:, 1] ** 2)  # (h, n)
    middle = record.heights.size // 2
    hours: Array = record.step_s / 3600.0 * np.arange(speed.shape[1], dtype=np.float64)
    fastest, highest = float(speed.max()), float(record.heights[-1])
    wide = _WIDTH - _SIDE - 2.0 * _MARGIN - _GAP
    left = _Panel(_MARGIN, wide, float(hours[-1]), fastest)
    right = _Panel(_MARGIN + wide + _GAP, _SIDE, fastest, highest)
    every = max(1, hours.size // _POINTS_MAX)
    height = f"{record.heights[middle]:g} m"
    parts = [
        _text(_MARGIN, 20.0, record.title, size=15),
        *left.frame(f"hours (at {height})", "m/s"),
        left.line(hours[::every], speed[middle, ::every], _LINE),
        *right.frame("m/s: mean, largest", "m above the bottom"),
        right.line(speed.mean(axis=1), record.heights, _LINE, dots=True),
        right.line(speed.max(axis=1), record.heights, _DOWN, dots=True),
    ]
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" '
        f'font-family="sans-serif"><rect width="100%" height="100%" fill="#fff"/>'
        + "".join(parts)
        + "</svg>\n"
    )


class _Panel:
    """A pair of axes from zero to a largest value each."""

    def __init__(self, left: float, width: float, most_x: float, most_y: float) -> None:
        self.left, self.width = left, width
        self.most = most_x or 1.0, most_y or 1.0

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Return where a point is drawn."""
        high = _HEIGHT - 2.0 * _MARGIN
        return (
            self.left + self.width * x / self.most[0],
            _HEIGHT - _MARGIN - high * y / self.most[1],
        )

    def frame(self, x_label: str, y_label: str) -> list[str]:
        """Return the axes with their labels and largest values."""
        (x0, y0), (x1, y1) = self.at(0.0, 0.0), self.at(*self.most)
        return [
            f'<path d="M{x0:.1f} {y1:.1f}V{y0:.1f}H{x1:.1f}" fill="none" stroke="{_INK}"/>',
            _text(x0, y0 + 32.0, x_label),
            _text(x1, y0 + 16.0, f"{self.most[0]:.3g}", anchor="end"),
            _text(x0 - 4.0, y1 + 4.0, f"{self.most[1]:.3g}", anchor="end"),
            _text(x0 + 6.0, y1 + 4.0, y_label),
        ]

    def line(self, x: Array, y: Array, colour: str, *, dots: bool = False) -> str:
        """Return a line through points."""
        places = [self.at(*pair) for pair in zip(x.tolist(), y.tolist(), strict=True)]
        path = " ".join(f"{a:.1f},{b:.1f}" for a, b in places)
        marks = (
            "".join(f'<circle cx="{a:.1f}" cy="{b:.1f}" r="3" fill="{colour}"/>' for a, b in places)
            if dots
            else ""
        )
        return f'<polyline points="{path}" fill="none" stroke="{colour}"/>{marks}'


def _text(x: float, y: float, text: str, *, anchor: str = "start", size: int = 12) -> str:
    place = f'x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}"'
    return f'<text {place} fill="{_INK}">{escape(text)}</text>'
