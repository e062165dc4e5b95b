"""Telemetry as a table: NumPy, pandas, Polars or Arrow, and as a plot."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, get_args

from seamark.client.errors import PackageMissing

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

TableKind = Literal["numpy", "pandas", "polars", "arrow"]
_PACKAGES = {"numpy": "numpy", "pandas": "pandas", "polars": "polars", "arrow": "pyarrow"}


def structured(names: Sequence[str], data: bytes) -> NDArray[np.void]:
    """Return rows of little-endian float64 as a structured array: `rows["t"]` is a column."""
    numpy = package("numpy")
    rows: NDArray[np.void] = numpy.frombuffer(data, dtype=[(name, "<f8") for name in names])
    return rows


def table(kind: TableKind, names: Sequence[str], data: bytes) -> Any:
    """Return rows of little-endian float64 as a table of this kind.

    Raises
    ------
    PackageMissing
        The package is not installed.
    ValueError
        There is no such kind.
    """
    if kind not in _PACKAGES:
        raise ValueError(f"Telemetry comes as {', '.join(get_args(TableKind))}, not as {kind!r}.")
    library = package(_PACKAGES[kind])
    rows = structured(names, data)
    if kind == "numpy":
        return rows
    columns = {name: rows[name].copy() for name in names}  # each in one piece
    if kind == "arrow":
        return library.table(columns)
    return library.DataFrame(columns)


def package(name: str) -> Any:
    """Import and return a package; raises PackageMissing with how to install it."""
    try:
        return importlib.import_module(name)
    except ImportError:
        top = name.partition(".")[0]
        raise PackageMissing(f"{top} is not installed. `pip install {top}` installs it.") from None
