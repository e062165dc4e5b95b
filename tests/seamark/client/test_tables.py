"""Telemetry as tables of other libraries: the same values under the same names."""

import builtins
from typing import Any

import numpy as np
import pytest

from seamark.client import PackageMissing
from seamark.client.tables import TableKind, table

NAMES = ("t", "x", "tracker_ok")
ROWS = np.array([[0.0, 1.5, 1.0], [0.05, -0.0, 0.0], [0.1, np.nan, 1.0]], dtype="<f8")


@pytest.mark.parametrize("kind", ["pandas", "polars", "arrow"])
def test_a_table_has_the_columns_of_the_numpy_rows_bit_for_bit(kind: TableKind) -> None:
    rows = table("numpy", NAMES, ROWS.tobytes())

    found = table(kind, NAMES, ROWS.tobytes())

    names: Any = found.column_names if kind == "arrow" else found.columns
    assert tuple(names) == NAMES
    for name in NAMES:
        column = np.asarray(found[name].to_numpy(), dtype="<f8")
        assert column.tobytes() == rows[name].tobytes()


def test_arrow_and_pandas_know_the_units_of_the_columns() -> None:
    units = {"t": "s", "x": "m", "tracker_ok": ""}

    arrow = table("arrow", NAMES, ROWS.tobytes(), units)
    frame = table("pandas", NAMES, ROWS.tobytes(), units)

    assert [arrow.schema.field(name).metadata[b"unit"] for name in NAMES] == [b"s", b"m", b""]
    assert frame.attrs == {"units": units}
    assert frame.groupby("tracker_ok").mean().attrs == {"units": units}


def test_a_table_of_an_unknown_kind_is_refused() -> None:
    with pytest.raises(ValueError, match="not as 'excel'"):
        table("excel", NAMES, ROWS.tobytes())  # type: ignore[arg-type]


def test_a_missing_package_is_named_with_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def fails(name: str, *rest: Any) -> Any:
        if name == "polars":
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr("importlib.import_module", fails)

    with pytest.raises(PackageMissing, match="pip install polars"):
        table("polars", NAMES, ROWS.tobytes())
