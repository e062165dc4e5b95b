"""Custom scores: expressions over the names of metrics, such as "corners + centroid".

Numbers, names, + - * / % **, parentheses and a few functions; nothing else. The syntax tree is
checked node by node against that list, then evaluated with floats only, never by `eval`: an
expression cannot run for long, grow a number without bound or reach a Python object.
"""

import ast
import difflib
import math
import operator
import threading
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import NoReturn

MAX_LENGTH = 500  # characters
MAX_DEPTH = 30  # nested operations
MAX_NODES = 250
_NAMES_SHOWN = 6  # in an error message
# The web server has many threads, and CPython before 3.11.5 can fail when two of them parse
# (SystemError, its issue 106905).
_one_at_a_time = threading.Lock()


def _mean(*values: float) -> float:
    return math.fsum(values) / len(values)


FUNCTIONS: dict[str, tuple[Callable[..., float], int | None]] = {  # None: one or more arguments
    "abs": (abs, 1),
    "exp": (math.exp, 1),
    "max": (lambda *values: max(values), None),
    "mean": (_mean, None),
    "min": (lambda *values: min(values), None),
    "sqrt": (math.sqrt, 1),
}
_OPERATORS: dict[type[ast.operator | ast.unaryop], Callable[..., float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Mod: operator.mod,
    ast.Pow: math.pow,  # raises where ** would return a complex number or a huge integer
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
}
_SYNTAX = (ast.Load, ast.operator, ast.unaryop)  # nodes that come with another one
ALLOWED = (
    f"Allowed are numbers, metrics, + - * / % **, parentheses and the functions "
    f"{', '.join(FUNCTIONS)}."
)


class ExpressionInvalid(ValueError):
    """An expression that gives no score. The message is written for the user."""


def check(expression: str, names: Collection[str]) -> None:
    """Check that this is an expression over these names.

    Raises
    ------
    ExpressionInvalid
        If it cannot be parsed, contains anything but arithmetic, or is too large; the message says
        where and why.
    """
    _parse(expression, names)


def score_of(expression: str, metrics: Mapping[str, float | None]) -> float:
    """Return the value of an expression, given the metrics by name.

    Raises
    ------
    ExpressionInvalid
        As `check`; and if a metric in it has no value, or the result is not a finite number.
    """
    tree = _parse(expression, metrics)
    missing = sorted(name for name in _names(tree) if metrics[name] is None)
    if missing:
        raise ExpressionInvalid(f"There is no score: {_listed(missing)} has no value.")
    values = {name: float(value) for name, value in metrics.items() if value is not None}
    try:
        score = float(_evaluate(tree.body, values))
    except (ArithmeticError, ValueError) as error:
        raise ExpressionInvalid(f"The expression has no value: {error}.") from None
    if not math.isfinite(score):
        raise ExpressionInvalid("The expression has no finite value.")
    return score


def _evaluate(node: ast.expr, values: Mapping[str, float]) -> float:
    """Return the value of a checked node."""
    match node:
        case ast.Constant(value=float(value)):
            return value
        case ast.Name(id=name):
            return values[name]
        case ast.UnaryOp(op=op, operand=operand):
            return _OPERATORS[type(op)](_evaluate(operand, values))
        case ast.BinOp(left=left, op=op, right=right):
            return _OPERATORS[type(op)](_evaluate(left, values), _evaluate(right, values))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return FUNCTIONS[name][0](*(_evaluate(one, values) for one in arguments))
    raise TypeError(f"{type(node).__name__} was not checked")


def expression_of(text: str) -> ast.Expression:
    """Return the tree of one expression; raises as `ast.parse`."""
    with _one_at_a_time:
        tree = ast.parse(text, mode="eval")
    return tree


def _parse(expression: str, names: Collection[str]) -> ast.Expression:
    """Return the checked tree, in which every number is a float."""
    if len(expression) > MAX_LENGTH:
        raise ExpressionInvalid(
            f"The expression has {len(expression)} characters; at most {MAX_LENGTH} are allowed."
        )
    try:
        tree = expression_of(expression.replace("\n", " ").strip())
    except SyntaxError as error:
        position = max(error.offset or 1, 1)
        raise ExpressionInvalid(f"Syntax error at character {position}. {ALLOWED}") from None
    except (ValueError, MemoryError, RecursionError):  # null bytes, thousands of brackets
        raise ExpressionInvalid(f"The expression cannot be parsed. {ALLOWED}") from None
    for count, (node, depth) in enumerate(_nodes(tree.body)):
        if count >= MAX_NODES or depth > MAX_DEPTH:
            raise ExpressionInvalid(
                f"The expression is too large: at most {MAX_NODES} parts, nested at most "
                f"{MAX_DEPTH} deep, are allowed."
            )
        _check_node(node, names)
    return tree


def _nodes(root: ast.AST) -> Iterator[tuple[ast.AST, int]]:
    """Yield all nodes with their depth; the name of a called function does not count."""
    waiting = [(root, 1)]
    while waiting:
        node, depth = waiting.pop()
        yield node, depth
        function = node.func if isinstance(node, ast.Call) else None
        waiting += [
            (child, depth + 1) for child in ast.iter_child_nodes(node) if child is not function
        ]


def _check_node(node: ast.AST, names: Collection[str]) -> None:
    match node:
        case ast.Constant(value=bool() | complex()):
            _reject(node, "is not a real number")
        case ast.Constant(value=int() | float()):
            _make_float(node)
        case ast.Name(id=name) if name not in names:
            _reject_name(node, "metric", name, names)
        case ast.Call():
            _check_call(node)
        case ast.BinOp(op=op) | ast.UnaryOp(op=op) if type(op) in _OPERATORS:
            pass
        case ast.Name():
            pass
        case _ if isinstance(node, _SYNTAX):
            pass
        case _:
            _reject(node, "is not arithmetic")


def _make_float(node: ast.Constant) -> None:
    """Make an integer a float: integers could grow without bound."""
    try:
        node.value = float(node.value)  # type: ignore[arg-type]
    except OverflowError:
        _reject(node, "is too large a number")
    if not math.isfinite(node.value):
        _reject(node, "is too large a number")


def _check_call(node: ast.Call) -> None:
    if not isinstance(node.func, ast.Name) or node.keywords:
        _reject(node, "is not arithmetic")
    name = node.func.id
    if name not in FUNCTIONS:
        _reject_name(node, "function", name, FUNCTIONS)
    count = FUNCTIONS[name][1]
    if not node.args or (count is not None and len(node.args) != count):
        _reject(node, f"is {name}, which takes {'one argument' if count else 'arguments'}")


def _reject_name(node: ast.AST, what: str, name: str, known: Collection[str]) -> NoReturn:
    near = difflib.get_close_matches(name, known, n=3) or sorted(
        one for one in known if name.lower() in one.lower()
    )
    hint = f"did you mean {' or '.join(near[:3])}?" if near else f"there are {_listed(known)}."
    _reject(node, f"is {name[:60]}, which is not a {what}; {hint}", allowed="")


def _reject(node: ast.AST, why: str, *, allowed: str = f". {ALLOWED}") -> NoReturn:
    position = getattr(node, "col_offset", 0) + 1
    raise ExpressionInvalid(f"At character {position} {why}{allowed}")


def _listed(names: Collection[str]) -> str:
    shown = ", ".join(sorted(names)[:_NAMES_SHOWN])
    return f"{shown} ..." if len(names) > _NAMES_SHOWN else shown


def _names(tree: ast.Expression) -> set[str]:
    return {node.id for node, _depth in _nodes(tree.body) if isinstance(node, ast.Name)}
