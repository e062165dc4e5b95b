"""Telemetry as a table: NumPy, pandas, Polars or Arrow, and as a plot."""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
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


def table(
    kind: TableKind, names: Sequence[str], data: bytes, units: Mapping[str, str] | None = None
) -> Any:
    """Return rows of little-endian float64 as a table of this kind.

    Units are in the metadata of Arrow's fields (`unit`), and in pandas' `attrs["units"]`.

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
    told = dict(units or {})
    if kind == "arrow":
        fields = [
            library.field(name, library.float64(), metadata={"unit": told[name]} if told else None)
            for name in names
        ]
        return library.table(columns, schema=library.schema(fields))
    frame = library.DataFrame(columns)
    if kind == "pandas":
        frame.attrs["units"] = told
    return frame


def package(name: str) -> Any:
    """Import and return a package; raises PackageMissing with how to install it."""
    try:
        return importlib.import_module(name)
    except ImportError:
        top = name.partition(".")[0]
        raise PackageMissing(f"{top} is not installed. `pip install {top}` installs it.") from None
