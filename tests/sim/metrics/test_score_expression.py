"""Expressions over measures: arithmetic and nothing else, in bounded time."""

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from seamark.sim.metrics.score_expression import (
    DEEPEST,
    FUNCTIONS,
    LONGEST,
    MOST_NODES,
    ExpressionInvalid,
    check,
    score_of,
)
from seamark.sim.registry import BENCHMARKS, benchmark
from seamark.sim.settings.configuration import Configuration, ConfigurationInvalid

MEASURES = {"corners": 4.0, "centroid": 1.5, "time": 60.0, "settling_s": None}


@pytest.mark.parametrize(
    ("expression", "score"),
    [
        ("corners + centroid", 5.5),
        ("100 / (1 + sqrt(corners)) - time / 60", 100 / 3 - 1),
        ("max(corners, centroid) ** 2 % 5", 1.0),
        ("-abs(centroid)", -1.5),
        ("mean(corners, centroid, 0.5) * exp(0)", 2.0),
        ("min(time, 3, 2)\n+ 1", 3.0),
    ],
)
def test_arithmetic_over_measures_is_worked_out(expression: str, score: float) -> None:
    assert score_of(expression, MEASURES) == pytest.approx(score)


@pytest.mark.parametrize(
    ("expression", "told"),
    [
        ("", "cannot be understood"),
        ("corners +", "cannot be understood"),
        ("1 + corner", "At character 5 is corner, which is no measure; did you mean corners?"),
        ("time + zzz", "At character 8 is zzz, which is no measure; there are centroid, corners"),
        ("sqroot(2)", "no function; did you mean sqrt?"),
        ("corners > 1", "no arithmetic"),
        ("'a' * 3", "no arithmetic"),
        ("[corners]", "no arithmetic"),
        ("corners.real", "no arithmetic"),
        ("corners.__class__", "no arithmetic"),
        ("__import__('os')", "__import__, which is no function"),
        ("(lambda: 1)()", "no arithmetic"),
        ("[x for x in (1, 2)]", "no arithmetic"),
        ("abs(x=1)", "no arithmetic"),
        ("max(*[1, 2])", "no arithmetic"),
        ("abs(1, 2)", "takes one value"),
        ("min()", "takes one value or more"),
        ("f'{time}'", "no arithmetic"),
        ("True", "no number"),
        ("2j", "no number"),
        ("1e999", "too large"),
        ("1" + "0" * 400, "too large"),
        ("1 << 9", "no arithmetic"),
        ("1" + "+1" * (MOST_NODES // 2), "too large"),
        ("-" * (DEEPEST + 1) + "1", "too large"),
        ("1" * (LONGEST + 1), "characters"),
        ("(" * 250 + "1" + ")" * 249, "cannot be understood"),
    ],
)
def test_everything_else_is_refused_with_a_sentence(expression: str, told: str) -> None:
    with pytest.raises(ExpressionInvalid, match=told.replace("?", r"\?")):
        check(expression, MEASURES)


@pytest.mark.parametrize(
    "expression", ["1 / (time - 60)", "sqrt(-1)", "(-2) ** 0.5", "9 ** 9 ** 9", "exp(time * time)"]
)
def test_what_gives_no_finite_number_is_no_score(expression: str) -> None:
    check(expression, MEASURES)

    with pytest.raises(ExpressionInvalid, match="gives no"):
        score_of(expression, MEASURES)


def test_a_measure_without_a_value_gives_no_score_and_is_named() -> None:
    with pytest.raises(ExpressionInvalid, match="settling_s has no value"):
        score_of("settling_s + 1", MEASURES)


PIECES = (
    *MEASURES,
    *FUNCTIONS,
    *("9", "1e308", "0.5", "0x7f", "1_0", "10**9", "**", "*", "+", "-", "/", "%", "(", ")", ","),
    *(
        " ",
        ".",
        "[",
        "]",
        "'",
        "_",
        "__class__",
        "lambda",
        "for",
        "in",
        "if",
        "else",
        ":",
        "=",
        ">",
    ),
    *("\n", "\0", "\\", "~", "not", "and", "await", ":=", "é", "𝐭𝐢𝐦𝐞", "1if", "#"),
)


@given(pieces=st.lists(st.sampled_from(PIECES), max_size=60))
@example(pieces=["9**9**9**9**9"])
@example(pieces=["(" * 490])
def test_no_expression_gives_anything_but_a_finite_number_or_a_refusal(pieces: list[str]) -> None:
    try:
        value = score_of("".join(pieces), MEASURES)
    except ExpressionInvalid:
        return
    assert type(value) is float
    assert math.isfinite(value)


operands = st.sampled_from(["corners", "centroid", "time", "2", "0.5"])
expressions = st.recursive(
    operands,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*"), inner).map(lambda t: f"({t[0]} {t[1]} {t[2]})"),
        st.tuples(st.sampled_from(["min", "max"]), inner, inner).map(
            lambda t: f"{t[0]}({t[1]}, {t[2]})"
        ),
        inner.map(lambda text: f"-{text}"),
        inner.map(lambda text: f"abs({text})"),
    ),
    max_leaves=12,
)


@given(expression=expressions)
def test_plain_arithmetic_is_what_python_makes_of_it(expression: str) -> None:
    names = {"corners": 4.0, "centroid": 1.5, "time": 60.0, "min": min, "max": max, "abs": abs}

    wanted = eval(expression, {"__builtins__": {}}, names)  # noqa: S307 - of our own making

    assert score_of(expression, MEASURES) == pytest.approx(wanted)


@pytest.mark.parametrize("name", BENCHMARKS)
def test_every_benchmark_takes_a_score_of_ones_own_and_ranked_runs_do_not(name: str) -> None:
    entry = benchmark(name)
    config: Configuration = entry.read({"score": "score - 2 * distance"})

    assert config.custom_score() == "score - 2 * distance"
    assert entry.ranked(config).custom_score() == ""
    with pytest.raises(ConfigurationInvalid, match=r"Score of your own.*did you mean distance"):
        entry.read({"score": "distanc"})
    with pytest.raises(ConfigurationInvalid, match=f"at most {LONGEST} characters"):
        entry.read({"score": "1" * (LONGEST + 1)})
