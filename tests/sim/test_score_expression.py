"""Expressions over measures: arithmetic and nothing else."""

import pytest

from sim.score_expression import ExpressionInvalid, score_of

MEASURES = {"corners": 4.0, "centroid": 1.5, "time": 60.0}


@pytest.mark.parametrize(
    ("expression", "score"),
    [
        ("corners + centroid", 5.5),
        ("100 / (1 + sqrt(corners)) - time / 60", 100 / 3 - 1),
        ("max(corners, centroid) ** 2 % 5", 1.0),
        ("-abs(centroid)", -1.5),
    ],
)
def test_arithmetic_over_measures_is_worked_out(expression: str, score: float) -> None:
    assert score_of(expression, MEASURES) == pytest.approx(score)


@pytest.mark.parametrize(
    "expression",
    [
        "",
        "corners +",
        "corner",
        "1 / 0",
        "sqrt(-1)",
        "9 ** 9 ** 9",
        "1e308 * 10",
        "corners > 1",
        "'a' * 3",
        "[corners]",
        "corners.real",
        "corners.__class__",
        "__import__('os')",
        "open('x')",
        "(lambda: 1)()",
        "[x for x in (1, 2)]",
        "1" + " + 1" * 200,
    ],
)
def test_everything_else_is_refused_with_a_sentence(expression: str) -> None:
    with pytest.raises(ExpressionInvalid):
        score_of(expression, MEASURES)
