"""Compiled functions that count no references."""

from collections.abc import Callable
from typing import Any, TypeVar

import numba

F = TypeVar("F", bound=Callable[..., Any])


def uncounted(function: F) -> F:
    """Compile a function that neither makes nor returns arrays.

    Numba counts the references of every array that is taken out of a tuple, in inner loops, too,
    and keeps nothing in registers over the calls for it. Half of a mechanism's step went into that.
    """
    compile_with: Any = numba.njit
    compiled: F = compile_with(cache=True, error_model="numpy", _nrt=False)(function)
    return compiled
