"""Files of currents are read by the names and units that their makers use."""

from pathlib import Path
from typing import Any

import h5netcdf
import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from scipy.io import netcdf_file

from seamark.current_data.reading import read
from seamark.current_data.series import CurrentRefused, record_of

DEPTHS = np.array([3.0, 6.0, 9.0])
COUNT = 40


def truth() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """East, north and up, (COUNT, depths)."""
    grid = np.arange(COUNT)[:, None] + 10.0 * DEPTHS[None, :]
    return 0.001 * grid, 0.2 - 0.001 * grid, 0.0001 * grid


def expected() -> np.ndarray:
    east, north, up = truth()
    return np.stack([north.T, east.T, -up.T], axis=1)


def write_cf(file: Any, *, old: bool, **changes: Any) -> None:
    """Variables by CF, packed as integers with a fill value, over a single place."""

    def create(name: str, kind: str, dims: tuple[str, ...], values: Any, **attributes: Any) -> None:
        if old:
            variable = file.createVariable(name, kind, dims)
        else:
            variable = file.create_variable(name, dims, kind)
        variable[...] = values
        target = variable if old else variable.attrs
        for key, value in (attributes | changes.get(name, {})).items():
            setattr(target, key, value) if old else target.__setitem__(key, value)

    sizes = {"time": COUNT, "depth": 3, "lat": 1}
    for name, size in sizes.items():
        file.createDimension(name, size) if old else file.dimensions.__setitem__(name, size)
    hours = np.arange(COUNT) / 6.0
    create("time", "f8", ("time",), hours, units="hours since 2024-05-01 12:00:00")
    create("depth", "f8", ("depth",), DEPTHS, standard_name="depth", units="m", positive="down")
    for name, values, word in zip(
        ("ua", "va", "wa"), truth(), ("eastward", "northward", "upward"), strict=True
    ):
        packed = np.round(values * 1e4).astype("i2")[:, :, None]
        packed[7, 1] = -32768
        create(
            name,
            "i2",
            ("time", "depth", "lat"),
            packed,
            standard_name=f"{word}_sea_water_velocity",
            units="cm s-1",
            scale_factor=0.01,
            _FillValue=np.int16(-32768),
        )


@pytest.mark.parametrize("old", [True, False])
def test_netcdf_by_cf_is_read_with_units_packing_and_gaps(tmp_path: Path, old: bool) -> None:
    path = tmp_path / "model.nc"
    with netcdf_file(path, "w") if old else h5netcdf.File(path, "w") as file:
        write_cf(file, old=old)

    found = read(path)

    whole = expected()
    assert np.isnan(found.velocity[1, :, 7]).all()
    whole[1, :, 7] = np.nan
    assert found.velocity == pytest.approx(whole, abs=1e-4, nan_ok=True)
    assert found.levels.tolist() == DEPTHS.tolist()
    assert found.down
    assert np.diff(found.times) == pytest.approx(600.0)
    assert found.begins == "2024-05-01T12:00:00+00:00"
    assert record_of(found, bottom_m=12.0).gaps.filled == 1


def test_netcdf_as_dolfyn_writes_an_adcp_is_read(tmp_path: Path) -> None:
    path = tmp_path / "adcp.nc"
    east, north, up = truth()
    with h5netcdf.File(path, "w") as file:
        file.dimensions = {"dir": 4, "range": 3, "time": COUNT}
        directions = np.array([b"E", b"N", b"U1", b"U2"], dtype="S2")
        file.create_variable("dir", ("dir",), data=directions)
        file.create_variable("range", ("range",), data=DEPTHS).attrs["units"] = "m"
        time = file.create_variable("time", ("time",), data=np.arange(COUNT) * 0.5)
        time.attrs["units"] = "seconds since 2020-08-15 00:16:40.5"
        values = np.stack([east.T, north.T, up.T, up.T])
        file.create_variable("vel", ("dir", "range", "time"), data=values).attrs["units"] = "m s-1"

    found = read(path)

    assert found.velocity == pytest.approx(expected())
    assert found.levels.tolist() == DEPTHS.tolist()
    assert not found.down
    assert np.diff(found.times) == pytest.approx(0.5)


def test_csv_with_dates_units_and_missing_values_is_read(tmp_path: Path) -> None:
    path = tmp_path / "adcp.csv"
    east, north, up = truth()
    lines = ["# Deployment 7", "Time; Depth (m); u (cm/s); v (cm/s); w (mm/s)"]
    for i in range(COUNT):
        for d, depth in enumerate(DEPTHS):
            middle = "-9999" if (i, d) == (7, 1) else f"{100 * north[i, d]}"
            lines.append(
                f"2024-05-01T12:{i:02d}:00Z;{depth};{100 * east[i, d]};{middle};{1000 * up[i, d]}"
            )
    path.write_text("\n".join(lines))

    found = read(path)

    whole = expected()
    whole[1, 0, 7] = np.nan
    assert found.velocity == pytest.approx(whole, nan_ok=True)
    assert np.diff(found.times) == pytest.approx(60.0)


def test_speed_and_direction_are_those_the_water_goes_to(tmp_path: Path) -> None:
    path = tmp_path / "meter.csv"
    path.write_text("time_s,speed_cm_s,direction_deg\n" + "".join(f"{i},20,90\n" for i in range(9)))

    found = read(path)

    assert found.velocity[0, :, 0] == pytest.approx([0.0, 0.2, 0.0])
    assert any("goes to" in sentence for sentence in found.said)


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("a.csv", "", "must name the columns"),
        ("a.csv", "time,u\n1,2\n", "must name the columns"),
        ("a.csv", "time,u,v\n", "no rows"),
        ("a.csv", "time,u,v\nyesterday,1,1\n", "seconds or a date"),
        ("a.csv", "time,u (furlongs),v\n1,1,1\n", "none of a velocity"),
        ("a.csv", "time,u,v\n" + "1" * 20_000 + ",1,1\n", "longer than"),
        ("a.csv", "time,u,v,depth\n1,1,1,\n", "has no depth"),
        ("a.csv", "time,u,v\nnan,1,1\n", "finite number"),
        ("a.csv", "# seamark-current 1\nnonsense\n", "the line time_s"),
        ("a.nc", "no netcdf", "no NetCDF"),
        ("a.nc", "CDF\x01", "cannot be read"),
        ("a.nc", "\x89HDF and nothing", "no NetCDF|cannot be read"),
    ],
)
def test_a_damaged_file_is_refused_with_a_sentence(
    tmp_path: Path, name: str, content: str, sentence: str
) -> None:
    path = tmp_path / name
    path.write_bytes(content.encode("latin-1"))

    with pytest.raises(CurrentRefused, match=sentence):
        read(path)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"ua": {"units": "degC"}}, "none of a velocity"),
        ({"ua": {"standard_name": "sea_water_temperature"}}, "no variables eastward"),
        ({"time": {"units": "fortnights since 2024-01-01"}}, "unit or calendar"),
        ({"time": {"calendar": "360_day"}}, "unit or calendar"),
        ({"time": {"units": "hours"}}, "has no time"),
    ],
)
def test_netcdf_that_says_something_else_is_refused(
    tmp_path: Path, changes: dict[str, Any], sentence: str
) -> None:
    path = tmp_path / "model.nc"
    with h5netcdf.File(path, "w") as file:
        write_cf(file, old=False, **changes)

    with pytest.raises(CurrentRefused, match=sentence):
        read(path)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=200)
@given(at=st.integers(0, 2000), value=st.binary(min_size=1, max_size=8))
@example(at=39, value=b"\x00\x13")  # claims more data than fit in memory
def test_netcdf_with_changed_bytes_is_read_or_refused(
    tmp_path: Path, at: int, value: bytes
) -> None:
    whole = tmp_path / "whole.nc"
    if not whole.exists():
        with netcdf_file(whole, "w") as file:
            write_cf(file, old=True)
    content = bytearray(whole.read_bytes())
    content[at : at + len(value)] = value
    path = tmp_path / "changed.nc"
    path.write_bytes(content)

    try:
        found = read(path)
    except CurrentRefused:
        return
    assert found.velocity.ndim == 3
