"""Arrays as columns of Arrow."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def vectors(values: NDArray[Any], missing: int = 0) -> Any:
    """Return a column with a list of k numbers in each row, given (n, k); then missing rows."""
    import pyarrow as pa

    rows, width = values.shape
    kind = pa.list_(pa.from_numpy_dtype(values.dtype), width)
    flat = np.concatenate([values, np.zeros((missing, width), values.dtype)]).ravel()
    mask = np.arange(rows + missing) >= rows
    return pa.FixedSizeListArray.from_arrays(
        pa.array(flat), type=kind, mask=pa.array(mask) if missing else None
    )


def numbers(values: NDArray[Any], missing: int = 0) -> Any:
    """Return a column of numbers, given (n,); then missing rows."""
    import pyarrow as pa

    padded = np.concatenate([values, np.zeros(missing, values.dtype)])
    return pa.array(padded, mask=np.arange(len(padded)) >= len(values))
