"""Parquet, NPZ and MAT, read by the programs that people open them with."""

import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pyarrow.parquet as pq
import pytest
import scipy  # its parts are loaded when they are used

from seamark.formats import parquet
from seamark.formats.recording import FormatRefused, Recording, RowsGone
from seamark.formats.registry import FORMATS
from seamark.sim.recording.telemetry import COLUMNS, NAMES, Rows

Written = Callable[[str], BytesIO]


def assert_same_bits(found: Any, rows: Rows) -> None:
    """Compare bit for bit: not-a-number and the sign of zero count."""
    assert np.ascontiguousarray(found, dtype="<f8").tobytes() == rows.tobytes()


def test_pandas_reads_the_same_bits_from_parquet(written: Written, rows: Rows) -> None:
    table = pd.read_parquet(written("parquet"))

    assert tuple(table.columns) == NAMES
    assert_same_bits(table.to_numpy(), rows)


def test_pandas_reads_the_units_from_parquet(written: Written) -> None:
    units = pd.read_parquet(written("parquet")).attrs["units"]

    assert units == {column.name: column.unit for column in COLUMNS}


def test_polars_reads_the_same_bits_from_parquet(written: Written, rows: Rows) -> None:
    table = pl.read_parquet(written("parquet"))

    assert tuple(table.columns) == NAMES
    assert_same_bits(table.to_numpy(), rows)


def test_columns_of_parquet_have_their_units(written: Written, recording: Recording) -> None:
    schema = pq.read_schema(written("parquet"))

    assert {field.name: field.metadata[b"unit"].decode() for field in schema} == {
        column.name: column.unit for column in COLUMNS
    }
    told = json.loads(schema.metadata[b"seamark"])
    assert told["digest"] == (recording.manifest or {})["digest"]
    assert told["configuration"]["level_duration_s"] == 5.0


def test_parquet_is_written_in_groups_of_rows(
    recording: Recording, rows: Rows, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(parquet, "ROW_GROUP_ROWS", 150)
    file = BytesIO()
    FORMATS["parquet"].write(recording, file)

    found = pq.ParquetFile(BytesIO(file.getvalue()))
    assert found.num_row_groups == -(-len(rows) // 150)
    assert_same_bits(found.read().to_pandas().to_numpy(), rows)


def test_numpy_reads_the_same_bits_from_npz(written: Written, rows: Rows) -> None:
    with np.load(written("npz"), allow_pickle=False) as arrays:
        telemetry = arrays["telemetry"]
        units = dict(zip(arrays["columns"], arrays["units"], strict=True))
        told = json.loads(str(arrays["description"]))

    assert telemetry.dtype.names == NAMES
    assert_same_bits(np.stack([telemetry[name] for name in NAMES], axis=1), rows)
    assert units == {column.name: column.unit for column in COLUMNS}
    assert told["benchmark"] == "currents-v1"


def test_scipy_reads_the_same_bits_from_mat(written: Written, rows: Rows) -> None:
    found = scipy.io.loadmat(written("mat"), simplify_cells=True)

    assert_same_bits(np.stack([found[name] for name in NAMES], axis=1), rows)
    # An empty text comes back as an empty array.
    units = {name: unit if isinstance(unit, str) else "" for name, unit in found["units"].items()}
    assert units == {column.name: column.unit for column in COLUMNS}
    assert json.loads(found["description"])["title"] == "Run 12"


def test_octave_reads_the_same_bits_from_mat(written: Written, rows: Rows, tmp_path: Path) -> None:
    (tmp_path / "telemetry.mat").write_bytes(written("mat").getvalue())
    names = ", ".join(f"run.{name}" for name in NAMES)
    script = (
        'run = load("telemetry.mat"); file = fopen("rows.f64", "w");'
        f'fwrite(file, [{names}]\', "double"); fclose(file); disp(run.units.ref_r)'
    )
    said = subprocess.run(
        ["octave-cli", "--norc", "--quiet", "--eval", script],
        cwd=tmp_path,
        check=True,
        capture_output=True,
        text=True,
    )

    assert said.stdout.strip() == "rad/s"
    assert_same_bits(np.fromfile(tmp_path / "rows.f64"), rows)


def test_a_mat_file_of_too_many_rows_is_refused_with_another_way(recording: Recording) -> None:
    long = replace(recording, row_count=(FORMATS["mat"].rows_max or 0) + 1)

    with pytest.raises(FormatRefused, match="parquetread"):
        FORMATS["mat"].write(long, BytesIO())


@pytest.mark.slow
@pytest.mark.parametrize("name", [*FORMATS])
def test_the_same_run_gives_the_same_bytes(name: str, written: Written) -> None:
    assert written(name).getvalue() == written(name).getvalue()


@pytest.mark.parametrize("name", [*FORMATS])
def test_a_run_without_rows_is_a_file_without_rows(name: str, recording: Recording) -> None:
    file = BytesIO()
    FORMATS[name].write(replace(recording, row_count=0, manifest=None, metrics=None), file)

    assert file.getvalue()


@pytest.mark.parametrize("name", [*FORMATS])
def test_rows_that_vanish_meanwhile_end_the_writing(name: str, recording: Recording) -> None:
    shrunk = replace(recording, row_count=recording.row_count + 1)

    with pytest.raises(RowsGone):
        FORMATS[name].write(shrunk, BytesIO())


def test_the_names_of_the_formats_load_no_library() -> None:
    heavy = "{'numpy', 'pyarrow', 'mcap', 'scipy', 'cv2', 'numba'}"
    code = f"import sys, seamark.formats.registry; sys.exit(len({heavy} & set(sys.modules)))"

    subprocess.run([sys.executable, "-c", code], check=True)
