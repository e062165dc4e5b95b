"""Parquet, NPZ and MAT, read by the programs that people open them with."""

import importlib
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

from seamark.formats import npz, parquet
from seamark.formats.recording import FormatRefused, Recording, RowsGone
from seamark.formats.registry import FORMATS
from seamark.sim.recording.telemetry import COLUMNS, NAMES, Rows, detections, names, width_for

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


@pytest.fixture
def detector(recording: Recording) -> tuple[Recording, Rows]:
    """The rows of a detector of a vehicle with everything that adds columns."""
    width = width_for(10, arm=True, work=True, detections=True)
    wide = np.random.default_rng(3).normal(size=(recording.row_count, width))
    detections(wide)[::2] = np.nan
    return replace(recording, width=width, read=lambda start, stop: wide[start:stop]), wide


@pytest.mark.parametrize(
    ("format_name", "read"),
    [
        ("csv", lambda path: pd.read_csv(path, comment="#")),
        ("parquet", pd.read_parquet),
        ("mat", lambda path: scipy.io.loadmat(path, squeeze_me=True)),
    ],
)
def test_every_format_has_the_columns_of_a_detector(
    detector: tuple[Recording, Rows], format_name: str, read: Callable[[Path], Any], tmp_path: Path
) -> None:
    recorded, rows = detector
    path = tmp_path / "file"
    with path.open("wb") as file:
        importlib.import_module(FORMATS[format_name].module).write(recorded, file)

    found = read(path)

    for name, column in zip(names(rows.shape[1]), rows.T, strict=True):
        assert np.array_equal(np.asarray(found[name]), column, equal_nan=True), name


def test_numpy_loads_the_rows_of_a_detector_with_nested_columns(
    detector: tuple[Recording, Rows], tmp_path: Path
) -> None:
    recorded, rows = detector
    path = tmp_path / "file.npz"
    with path.open("wb") as file:
        npz.write(recorded, file)

    found = np.load(path)["telemetry"]

    assert_same_bits(found.view(np.float64).reshape(rows.shape), rows)
    at = names(rows.shape[1]).index
    assert_same_bits(found["object"]["distance"][:, 7], rows[:, at("object_7_distance")].copy())
    assert_same_bits(found["answer"]["y3"][:, 15], rows[:, at("answer_15_y3")].copy())
    assert_same_bits(found["work_fz"], rows[:, at("work_fz")].copy())
    assert_same_bits(found["thrust_9"], rows[:, at("thrust_9")].copy())
