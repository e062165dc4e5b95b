"""The curve of a sweep over one value: the score with its interval, as coordinates of an SVG."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from seamark.server.runs.setting_values import text_of
from seamark.server.runs.sweeps import Cell, SweepView
from seamark.server.web.template_filters import plain

WIDTH, HEIGHT = 640.0, 260.0  # of the drawing
LEFT, RIGHT, TOP, BOTTOM = 56.0, 16.0, 14.0, 34.0  # margins
TICKS = 4  # intervals of the vertical axis
LABELS_MAX = 9  # values that are named below


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
    """What the template draws."""

    points: tuple[Point, ...]
    values: tuple[Tick, ...]
    scores: tuple[Tick, ...]

    @property
    def line(self) -> str:
        """The points of the line."""
        return " ".join(f"{point.x:.1f},{point.y:.1f}" for point in self.points)


def curve(sweep: SweepView) -> CurveChart | None:
    """Return the chart; None without two scores."""
    scored = [cell for cell in sweep.cells if cell.run is not None and cell.run.score is not None]
    if len(scored) < 2:
        return None
    bounds = [bound for cell in scored for bound in _bounds(cell)]
    low, high = min(bounds), max(bounds)
    span = high - low or 1.0

    def y_of(score: float) -> float:
        return TOP + (HEIGHT - TOP - BOTTOM) * (high - score) / span

    positions = _positions(sweep.axes[0].values)
    at = dict(zip(sweep.axes[0].values, positions, strict=True))
    shown = max(1, -(-len(positions) // LABELS_MAX))
    ticks = list(zip(positions, sweep.axes[0].values, strict=True))[::shown]
    best = sweep.best
    return CurveChart(
        points=tuple(
            _point(cell, at[cell.values[0]], y_of, best=cell is best)
            for cell in sorted(scored, key=lambda cell: at[cell.values[0]])
        ),
        values=tuple(Tick(x, text_of(value)) for x, value in ticks),
        scores=tuple(
            Tick(y_of(score), plain(float(f"{score:.3g}")))
            for score in (low + span * step / TICKS for step in range(TICKS + 1))
        ),
    )


def _point(cell: Cell, x: float, y_of: Callable[[float], float], *, best: bool) -> Point:
    run = cell.run
    if run is None or run.score is None:
        raise ValueError("a cell without a score has no point")
    low, high = run.score_low, run.score_high
    return Point(
        x=x,
        y=y_of(run.score),
        low=None if low is None else y_of(low),
        high=None if high is None else y_of(high),
        run=run.id,
        best=best,
    )


def _bounds(cell: Cell) -> list[float]:
    run = cell.run
    values = () if run is None else (run.score, run.score_low, run.score_high)
    return [value for value in values if value is not None]


def _positions(values: Sequence[object]) -> list[float]:
    """Return where the values are: to scale if all are numbers, else evenly."""
    numbers = [float(v) for v in values if isinstance(v, int | float) and not isinstance(v, bool)]
    if len(numbers) < len(values):
        numbers = [float(index) for index in range(len(values))]
    low, span = min(numbers), max(numbers) - min(numbers)
    width = WIDTH - LEFT - RIGHT
    return [LEFT + width * (number - low) / span for number in numbers]
