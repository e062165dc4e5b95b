"""Syntax trees of Python source, parsed one at a time: the web server has many threads.

CPython before 3.11.5 can fail when two threads parse (SystemError, its issue 106905).
"""

import ast
import threading

_one_at_a_time = threading.Lock()


def expression_of(text: str) -> ast.Expression:
    """Return the tree of one expression; raises as `ast.parse`."""
    with _one_at_a_time:
        tree = ast.parse(text, mode="eval")
    return tree
