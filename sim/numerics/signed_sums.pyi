"""Types of signed_sums.py."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Terms = Sequence[tuple[int, int]]

def signed_sums(table: Mapping[int, Terms]) -> Callable[[Array, Array], None]: ...
