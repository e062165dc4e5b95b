"""A file of currents, whatever its format."""

from __future__ import annotations

from pathlib import Path

from seamark.current_data.csv_reading import read_csv
from seamark.current_data.netcdf_reading import SUFFIXES, read_netcdf
from seamark.current_data.series import CurrentRefused, Series

FILE_BYTES_MAX = 2 * 1024**3


def read(path: Path) -> Series:
    """Return the currents of a file.

    Raises
    ------
    CurrentRefused
        It is too large, or is not what it is named as.
    """
    try:
        size = path.stat().st_size
    except OSError as error:
        raise CurrentRefused(f"The file cannot be read: {error.strerror}.") from None
    if size > FILE_BYTES_MAX:
        raise CurrentRefused("The file has more than 2 GiB: cut out a part first.")
    return read_netcdf(path) if path.suffix.lower() in SUFFIXES else read_csv(path)
