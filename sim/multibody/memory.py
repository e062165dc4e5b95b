"""Memory for compiled code: named tuples of arrays of zeros."""

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")
Sizes = Mapping[str, tuple[int, ...]]


def zeros(
    kind: Callable[..., T], sizes: Sizes, lanes: tuple[int, ...], *, integers: Sizes | None = None
) -> T:
    """Return a tuple of float64 arrays of these sizes with lanes as last index, and of integers."""
    made: dict[str, Any] = {name: np.zeros((*size, *lanes)) for name, size in sizes.items()}
    made |= {name: np.zeros(size, np.int64) for name, size in (integers or {}).items()}
    return kind(**made)
