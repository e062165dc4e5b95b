"""Expressions over metrics: arithmetic and nothing else, in bounded time."""

import math
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from seamark.sim.metrics.score_expression import (
    FUNCTIONS,
    MAX_DEPTH,
    MAX_LENGTH,
    MAX_NODES,
    ExpressionInvalid,
    check,
    expression_of,
    score_of,
)
from seamark.sim.registry import BENCHMARKS, benchmark
from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.refusal import ConfigurationInvalid

METRICS = {"corners": 4.0, "centroid": 1.5, "time": 60.0, "settling_s": None}


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
def test_arithmetic_over_metrics_is_evaluated(expression: str, score: float) -> None:
    assert score_of(expression, METRICS) == pytest.approx(score)


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ("", "Syntax error"),
        ("corners +", "Syntax error at character"),
        ("1 + corner", "At character 5 is corner, which is not a metric; did you mean corners?"),
        ("time + zzz", "At character 8 is zzz, which is not a metric; there are centroid, corners"),
        ("sqroot(2)", "not a function; did you mean sqrt?"),
        ("corners > 1", "is not arithmetic"),
        ("'a' * 3", "is not arithmetic"),
        ("[corners]", "is not arithmetic"),
        ("corners.real", "is not arithmetic"),
        ("corners.__class__", "is not arithmetic"),
        ("__import__('os')", "__import__, which is not a function"),
        ("(lambda: 1)()", "is not arithmetic"),
        ("[x for x in (1, 2)]", "is not arithmetic"),
        ("abs(x=1)", "is not arithmetic"),
        ("max(*[1, 2])", "is not arithmetic"),
        ("abs(1, 2)", "takes one argument"),
        ("min()", "takes arguments"),
        ("f'{time}'", "is not arithmetic"),
        ("True", "not a real number"),
        ("2j", "not a real number"),
        ("1e999", "too large"),
        ("1" + "0" * 400, "too large"),
        ("1 << 9", "is not arithmetic"),
        ("1" + "+1" * (MAX_NODES // 2), "too large"),
        ("-" * (MAX_DEPTH + 1) + "1", "too large"),
        ("1" * (MAX_LENGTH + 1), "characters"),
        ("(" * 250 + "1" + ")" * 249, "Syntax error"),
    ],
)
def test_anything_else_is_rejected_with_a_reason(expression: str, message: str) -> None:
    with pytest.raises(ExpressionInvalid, match=message.replace("?", r"\?")):
        check(expression, METRICS)


@pytest.mark.parametrize(
    "expression", ["1 / (time - 60)", "sqrt(-1)", "(-2) ** 0.5", "9 ** 9 ** 9", "exp(time * time)"]
)
def test_an_expression_without_a_finite_value_is_not_a_score(expression: str) -> None:
    check(expression, METRICS)

    with pytest.raises(ExpressionInvalid, match="has no"):
        score_of(expression, METRICS)


def test_a_metric_without_a_value_gives_no_score_and_is_named() -> None:
    with pytest.raises(ExpressionInvalid, match="settling_s has no value"):
        score_of("settling_s + 1", METRICS)


PIECES = (
    *METRICS,
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
def test_every_expression_gives_a_finite_float_or_is_rejected(pieces: list[str]) -> None:
    try:
        value = score_of("".join(pieces), METRICS)
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
def test_plain_arithmetic_agrees_with_python(expression: str) -> None:
    names = {"corners": 4.0, "centroid": 1.5, "time": 60.0, "min": min, "max": max, "abs": abs}

    wanted = eval(expression, {"__builtins__": {}}, names)  # noqa: S307 - generated above

    assert score_of(expression, METRICS) == pytest.approx(wanted)


@pytest.mark.parametrize("name", BENCHMARKS)
def test_every_benchmark_takes_a_custom_score_and_ranked_runs_do_not(name: str) -> None:
    entry = benchmark(name)
    config: Configuration = entry.read({"score": "score - 2 * distance"})

    assert config.custom_score() == "score - 2 * distance"
    assert entry.ranked(config).custom_score() == ""
    with pytest.raises(ConfigurationInvalid, match=r"Custom score.*did you mean distance"):
        entry.read({"score": "distanc"})
    with pytest.raises(ConfigurationInvalid, match=f"at most {MAX_LENGTH} characters"):
        entry.read({"score": "1" * (MAX_LENGTH + 1)})


NESTED = "(" * 40 + "1" + " + 1)" * 40


@pytest.fixture
def threads_that_take_turns_often() -> object:
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


@pytest.mark.slow
@pytest.mark.usefixtures("threads_that_take_turns_often")
def test_many_threads_can_parse_at_the_same_time() -> None:
    with ThreadPoolExecutor(8) as pool:
        trees = list(pool.map(lambda _: expression_of(NESTED), range(800)))

    assert {type(tree.body).__name__ for tree in trees} == {"BinOp"}
    assert len(trees) == 800
