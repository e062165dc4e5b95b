"""A score as an expression over the names of measures, such as "corners + centroid".

Numbers, names, + - * / ** % and parentheses, abs, min, max, sqrt; nothing else. Parsed and worked
out by simpleeval, never by `eval`.
"""

import ast
import math
from collections.abc import Mapping

from simpleeval import InvalidExpression, SimpleEval

LONGEST = 500  # characters
FUNCTIONS = {"abs": abs, "min": min, "max": max, "sqrt": math.sqrt}
# What simpleeval would work out beside arithmetic.
NOT_ARITHMETIC = (ast.Attribute, ast.Subscript, ast.Slice, ast.JoinedStr, ast.Assign, ast.AugAssign)


class ExpressionInvalid(ValueError):
    """An expression that gives no score. The sentence is written for the user."""


def score_of(expression: str, measures: Mapping[str, float]) -> float:
    """Return what an expression gives for measures by name.

    Raises
    ------
    ExpressionInvalid
        If it is no expression, names what is not there, or gives no finite number.
    """
    if len(expression) > LONGEST:
        raise ExpressionInvalid(f"A score's expression has at most {LONGEST} characters.")
    numbers = {name: float(value) for name, value in measures.items()}
    evaluator = SimpleEval(names=numbers, functions=dict(FUNCTIONS))
    for kind in NOT_ARITHMETIC:
        evaluator.nodes.pop(kind, None)
    try:
        value = evaluator.eval(expression)
    except (InvalidExpression, SyntaxError, ArithmeticError, ValueError, TypeError) as refusal:
        known = ", ".join(sorted(numbers))
        raise ExpressionInvalid(
            f"{expression!r} gives no score: {refusal}. Measures: {known}."
        ) from None
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ExpressionInvalid(f"{expression!r} gives no finite number.")
    return float(value)
