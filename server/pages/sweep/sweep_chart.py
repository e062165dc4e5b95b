"""The curve of a sweep over one value: the score with its interval, as coordinates of an SVG."""

from collections.abc import Sequence
from dataclasses import dataclass

from seamark.server.pages.charts.plots import Axis as Scale
from seamark.server.runs.submission.sweep_axes import Value, numbers_of, shown
from seamark.server.runs.submission.sweeps import Cell, SweepView
from seamark.server.web.template_filters import plain

WIDTH, HEIGHT = 640.0, 280.0  # of the drawing
LEFT, RIGHT, TOP, BOTTOM = 56.0, 16.0, 14.0, 54.0  # margins
LOGARITHMIC_FROM = 50.0  # times the least value: then the greatest is on a logarithmic axis


@dataclass(frozen=True, slots=True)
class Point:
    """A score at its value; `low` and `high` are the ends of its interval."""

    x: float
    y: float
    low: float | None
    high: float | None
    run: int
    best: bool


@dataclass(frozen=True, slots=True)
class Tick:
    """A labelled position of an axis."""

    at: float
    label: str


@dataclass(frozen=True, slots=True)
class CurveChart:
    """What the template draws; choices have no line between them."""

    points: tuple[Point, ...]
    values: tuple[Tick, ...]
    scores: tuple[Tick, ...]
    is_line: bool

    @property
    def line(self) -> str:
        """The points of the line."""
        return " ".join(f"{point.x:.1f},{point.y:.1f}" for point in self.points)

    @property
    def has_bars(self) -> bool:
        """Whether a point has an interval."""
        return any(point.low is not None and point.high is not None for point in self.points)


def curve(sweep: SweepView) -> CurveChart | None:
    """Return the chart; None without two scores."""
    scored = [cell for cell in sweep.cells if cell.run is not None and cell.run.score is not None]
    if len(scored) < 2:
        return None
    scale = Scale.over(bound for cell in scored for bound in _bounds(cell))
    at, ticks = _across(sweep.axes[0].values)
    best = sweep.best
    return CurveChart(
        points=tuple(
            _point(cell, at[cell.values[0]], scale, best=cell is best)
            for cell in sorted(scored, key=lambda cell: at[cell.values[0]])
        ),
        values=tuple(ticks),
        scores=tuple(Tick(_height(scale, score), plain(score)) for score in scale.ticks()),
        is_line=numbers_of(sweep.axes[0].values) is not None,
    )


def _point(cell: Cell, x: float, scale: Scale, *, best: bool) -> Point:
    run = cell.run
    if run is None or run.score is None:
        raise ValueError("a cell without a score has no point")
    low, high = run.score_low, run.score_high
    return Point(
        x=x,
        y=_height(scale, run.score),
        low=None if low is None else _height(scale, low),
        high=None if high is None else _height(scale, high),
        run=run.id,
        best=best,
    )


def _bounds(cell: Cell) -> list[float]:
    run = cell.run
    values = () if run is None else (run.score, run.score_low, run.score_high)
    return [value for value in values if value is not None]


def _height(scale: Scale, score: float) -> float:
    return TOP + (HEIGHT - TOP - BOTTOM) * scale.up(score) / 100.0


def _across(values: Sequence[Value]) -> tuple[dict[Value, float], list[Tick]]:
    """Return where the values are, to scale if all are numbers, and the ticks below."""
    numbers = numbers_of(values)
    if numbers is None:
        scale = Scale.over(map(float, range(len(values))))
        at = {value: _right(scale, float(index)) for index, value in enumerate(values)}
        return at, [Tick(x, shown(value)) for value, x in at.items()]
    wide = min(numbers) > 0.0 and max(numbers) >= LOGARITHMIC_FROM * min(numbers)
    scale = Scale.over(numbers, logarithmic=wide)
    at = {value: _right(scale, number) for value, number in zip(values, numbers, strict=True)}
    return at, [Tick(_right(scale, tick), plain(tick)) for tick in scale.ticks()]


def _right(scale: Scale, value: float) -> float:
    return LEFT + (WIDTH - LEFT - RIGHT) * scale.at(value) / 100.0
