"""A score of one's own: an expression over the names of measures, such as "corners + centroid".

Numbers, names, + - * / % **, parentheses and a few functions; nothing else. Checked here node by
node, then worked out by simpleeval with floats alone, never by `eval`: no expression can take long,
grow a number without bound or reach an object of Python.
"""

import ast
import difflib
import math
import operator
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import NoReturn

from simpleeval import InvalidExpression, SimpleEval

from seamark.sim.metrics.syntax_trees import expression_of

LONGEST = 500  # characters
DEEPEST = 30  # nested operations
MOST_NODES = 250
_SHOWN = 6  # names in a refusal


def _mean(*values: float) -> float:
    return math.fsum(values) / len(values)


FUNCTIONS: dict[str, tuple[Callable[..., float], int | None]] = {  # None: one or more values
    "abs": (abs, 1),
    "exp": (math.exp, 1),
    "max": (lambda *values: max(values), None),
    "mean": (_mean, None),
    "min": (lambda *values: min(values), None),
    "sqrt": (math.sqrt, 1),
}
_CALLS = {name: call for name, (call, _) in FUNCTIONS.items()}
_OPERATORS: dict[type, Callable[..., float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Mod: operator.mod,
    ast.Pow: math.pow,  # refuses what would be complex, and what would overflow
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
}
_SYNTAX = (ast.Load, ast.operator, ast.unaryop)  # nodes that come with another one
WORDS = f"Possible are numbers, measures, + - * / % **, parentheses and {', '.join(FUNCTIONS)}."


class ExpressionInvalid(ValueError):
    """An expression that gives no score. The sentence is written for the user."""


def check(expression: str, names: Collection[str]) -> None:
    """Refuse what is no expression over these names; the sentence says where and why.

    Raises
    ------
    ExpressionInvalid
        If it cannot be understood, has something else in it than arithmetic, or is too large.
    """
    _parsed(expression, names)


def score_of(expression: str, measures: Mapping[str, float | None]) -> float:
    """Return what an expression gives for measures by name.

    Raises
    ------
    ExpressionInvalid
        As `check`; and if a measure that it names has no value, or it gives no finite number.
    """
    tree = _parsed(expression, measures)
    missing = sorted(name for name in _names(tree) if measures[name] is None)
    if missing:
        raise ExpressionInvalid(f"{_listed(missing)} has no value here, so there is no score.")
    numbers = {name: float(value) for name, value in measures.items() if value is not None}
    evaluator = SimpleEval(operators=_OPERATORS, functions=_CALLS, names=numbers)
    try:
        value = float(evaluator.eval(expression, previously_parsed=tree.body))
    except (InvalidExpression, ArithmeticError, ValueError) as refusal:
        raise ExpressionInvalid(f"The expression gives no number: {refusal}.") from None
    if not math.isfinite(value):
        raise ExpressionInvalid("The expression gives no finite number.")
    return value


def _parsed(expression: str, names: Collection[str]) -> ast.Expression:
    """Return the checked tree, every number in it a float."""
    if len(expression) > LONGEST:
        raise ExpressionInvalid(
            f"The expression has {len(expression)} characters; at most {LONGEST} are possible."
        )
    try:
        tree = expression_of(expression.replace("\n", " ").strip())
    except SyntaxError as error:
        place = max(error.offset or 1, 1)
        raise ExpressionInvalid(
            f"At character {place} the expression cannot be understood. {WORDS}"
        ) from None
    except (ValueError, MemoryError, RecursionError):  # null bytes, thousands of brackets
        raise ExpressionInvalid(f"The expression cannot be understood. {WORDS}") from None
    for count, (node, depth) in enumerate(_nodes(tree.body)):
        if count >= MOST_NODES or depth > DEEPEST:
            raise ExpressionInvalid(
                f"The expression is too large: at most {MOST_NODES} parts, {DEEPEST} within each "
                "other."
            )
        _check_node(node, names)
    return tree


def _nodes(root: ast.AST) -> Iterator[tuple[ast.AST, int]]:
    """Yield all nodes with their depth; a call's function is no node of its own."""
    waiting = [(root, 1)]
    while waiting:
        node, depth = waiting.pop()
        yield node, depth
        inner = ast.iter_child_nodes(node)
        named = node.func if isinstance(node, ast.Call) else None
        waiting += [(child, depth + 1) for child in inner if child is not named]


def _check_node(node: ast.AST, names: Collection[str]) -> None:
    match node:
        case ast.Constant(value=bool()) | ast.Constant(value=complex()):
            _refuse(node, "is no number")
        case ast.Constant(value=int() | float()):
            _make_float(node)
        case ast.Name(id=name) if name not in names:
            _refuse_name(node, "measure", name, names)
        case ast.Call():
            _check_call(node)
        case ast.BinOp(op=op) | ast.UnaryOp(op=op) if type(op) in _OPERATORS:
            pass
        case ast.Name():
            pass
        case _ if isinstance(node, _SYNTAX):
            pass
        case _:
            _refuse(node, "is something that is no arithmetic")


def _make_float(node: ast.Constant) -> None:
    """Make a whole number a float: whole numbers could grow without bound."""
    try:
        node.value = float(node.value)  # type: ignore[arg-type]
    except OverflowError:
        _refuse(node, "is a number that is too large")
    if not math.isfinite(node.value):
        _refuse(node, "is a number that is too large")


def _check_call(node: ast.Call) -> None:
    if not isinstance(node.func, ast.Name) or node.keywords:
        _refuse(node, "is something that is no arithmetic")
    name = node.func.id
    if name not in FUNCTIONS:
        _refuse_name(node, "function", name, FUNCTIONS)
    wanted = FUNCTIONS[name][1]
    if not node.args or (wanted is not None and len(node.args) != wanted):
        _refuse(node, f"is {name}, which takes {'one value' if wanted else 'one value or more'}")


def _refuse_name(node: ast.AST, kind: str, name: str, known: Collection[str]) -> NoReturn:
    near = difflib.get_close_matches(name, known, n=3) or sorted(
        one for one in known if name.lower() in one.lower()
    )
    hint = f"did you mean {' or '.join(near[:3])}?" if near else f"there are {_listed(known)}."
    _refuse(node, f"is {name[:60]}, which is no {kind}; {hint}", words="")


def _refuse(node: ast.AST, why: str, *, words: str = f". {WORDS}") -> NoReturn:
    place = getattr(node, "col_offset", 0) + 1
    raise ExpressionInvalid(f"At character {place} {why}{words}")


def _listed(names: Collection[str]) -> str:
    shown = ", ".join(sorted(names)[:_SHOWN])
    return f"{shown} ..." if len(names) > _SHOWN else shown


def _names(tree: ast.Expression) -> set[str]:
    return {node.id for node, _depth in _nodes(tree.body) if isinstance(node, ast.Name)}
