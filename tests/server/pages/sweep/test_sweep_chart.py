"""The chart of a sweep: the ticks of its axes, and the warning if the best point is at an edge."""

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from typing import Any, cast

import pytest

from seamark.server.pages.sweep import sweep_chart, sweep_edges
from seamark.server.runs.showing.views import RunView
from seamark.server.runs.submission.sweep_axes import Axis, Value
from seamark.server.runs.submission.sweeps import Cell, SweepView

GAIN: dict[str, Any] = {"title": "Gain", "x-unit": "1/s", "type": "number"}


def swept(
    values: tuple[Value, ...], scores: tuple[float, ...], *, spread: float | None = None
) -> SweepView:
    runs = [
        SimpleNamespace(
            id=number,
            score=score,
            score_low=None if spread is None else score - spread,
            score_high=None if spread is None else score + spread,
        )
        for number, score in enumerate(scores, start=1)
    ]
    cells = (Cell((value,), cast(RunView, run)) for value, run in zip(values, runs, strict=True))
    return SweepView(
        id=1,
        user_id=1,
        guest=None,
        benchmark="currents-v1",
        title="",
        axes=(Axis("kp", values),),
        created_at=0.0,
        cells=tuple(cells),
    )


def labels(sweep: SweepView) -> tuple[list[str], list[str]]:
    chart = sweep_chart.curve(sweep)
    assert chart is not None
    return [tick.label for tick in chart.values], [tick.label for tick in chart.scores]


def test_ticks_are_few_round_numbers_whatever_the_values_are() -> None:
    below, beside = labels(swept((0.1, 0.1 + 0.2, 0.7001), (41.234, 87.9, 60.0)))

    assert below == ["0.2", "0.4", "0.6"]
    assert beside == ["50", "60", "70", "80"]


def test_values_over_several_powers_of_ten_have_a_logarithmic_axis() -> None:
    sweep = swept((0.001, 0.01, 0.1, 1.0), (1.0, 2.0, 3.0, 4.0))

    below, _beside = labels(sweep)
    chart = sweep_chart.curve(sweep)

    assert below == ["0.001", "0.01", "0.1", "1"]
    assert chart is not None
    steps = [after.x - before.x for before, after in pairwise(chart.points)]
    assert steps == pytest.approx([steps[0]] * 3)


def test_choices_stand_side_by_side_without_a_line_between_them() -> None:
    chart = sweep_chart.curve(swept(("esm", "klt", "ecc"), (1.0, 2.0, 3.0)))

    assert chart is not None
    assert [tick.label for tick in chart.values] == ["esm", "klt", "ecc"]
    assert not chart.is_line


def test_the_chart_has_bars_only_with_intervals() -> None:
    with_bars = sweep_chart.curve(swept((1, 2), (40.0, 50.0), spread=2.0))
    without = sweep_chart.curve(swept((1, 2), (40.0, 50.0)))

    assert with_bars is not None
    assert without is not None
    assert (with_bars.has_bars, without.has_bars) == (True, False)


@pytest.mark.parametrize(
    ("values", "scores", "expected"),
    [
        ((0.2, 0.4, 0.6), (1.0, 2.0, 3.0), "the largest Gain of this sweep, 0.6 1/s. Try larger"),
        ((0.2, 0.4, 0.6), (3.0, 2.0, 1.0), "the smallest Gain of this sweep, 0.2 1/s. Try smaller"),
        ((0.6, 0.4, 0.2), (3.0, 2.0, 1.0), "the largest Gain of this sweep, 0.6 1/s. Try larger"),
        ((0.2, 0.4, 0.6), (1.0, 3.0, 2.0), ""),
        (("esm", "klt"), (1.0, 3.0), ""),
        ((False, True), (1.0, 3.0), ""),
        ((0.2, 0.4), (2.0, 2.0), ""),
    ],
)
def test_the_best_point_at_an_edge_says_where_to_extend_the_sweep(
    values: tuple[Value, ...], scores: tuple[float, ...], expected: str
) -> None:
    warnings = sweep_edges.warnings(swept(values, scores), {"kp": GAIN})

    assert [expected in each for each in warnings] == ([True] if expected else [])


@pytest.mark.parametrize(("limit", "scores"), [("maximum", (1.0, 3.0)), ("minimum", (3.0, 1.0))])
def test_there_is_no_warning_where_the_setting_ends(limit: str, scores: tuple[float, ...]) -> None:
    sweep = swept((0.2, 0.6), scores)
    gain = GAIN | {limit: {"maximum": 0.6, "minimum": 0.2}[limit]}

    assert sweep_edges.warnings(sweep, {"kp": gain}) == []


def test_a_sweep_without_a_score_has_no_best_point_at_an_edge() -> None:
    sweep = swept((0.2, 0.4), (1.0, 2.0))
    unscored = tuple(replace(cell, run=None) for cell in sweep.cells)

    assert sweep_edges.warnings(replace(sweep, cells=unscored), {"kp": GAIN}) == []
