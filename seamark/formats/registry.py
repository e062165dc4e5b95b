"""The formats by name: what they are called, and what writes them. Importing this is light."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, BinaryIO

if TYPE_CHECKING:
    from seamark.formats.recording import Recording

REVISION = 3  # of all formats: a change of one makes the copies of clients stale


@dataclass(frozen=True, slots=True, kw_only=True)
class Format:
    """A file format of runs."""

    name: str
    file: str  # its name at the API
    media_type: str
    label: str
    module: str  # has `write(recording, file)`
    packages: tuple[str, ...] = ()  # beyond those that Seamark always has

    def write(self, recording: Recording, file: BinaryIO) -> None:
        """Write a run to a file that need not be readable or seekable.

        Raises
        ------
        RowsGone, FormatRefused
        """
        writing: Callable[[Recording, BinaryIO], None]
        writing = importlib.import_module(self.module).write
        writing(recording, file)


_ALL = (
    Format(
        name="csv",
        file="telemetry.csv",
        media_type="text/csv",
        label="text, with units in its comments",
        module="seamark.formats.csv_file",
    ),
    Format(
        name="parquet",
        file="telemetry.parquet",
        media_type="application/vnd.apache.parquet",
        label="Apache Parquet, with units: pandas, Polars, DuckDB, MATLAB",
        module="seamark.formats.parquet",
        packages=("pyarrow",),
    ),
    Format(
        name="mcap",
        file="telemetry.mcap",
        media_type="application/octet-stream",
        label="ROS 2 messages: odometry, sensors, camera images and all columns, for Foxglove",
        module="seamark.formats.ros.mcap_file",
        packages=("mcap_ros2",),
    ),
    Format(
        name="npz",
        file="telemetry.npz",
        media_type="application/zip",
        label="NumPy",
        module="seamark.formats.npz",
    ),
    Format(
        name="mat",
        file="telemetry.mat",
        media_type="application/x-matlab-data",
        label="MATLAB and Octave",
        module="seamark.formats.mat",
    ),
    Format(
        name="archive",
        file="archive.zip",
        media_type="application/zip",
        label="everything that `seamark rerun` needs",
        module="seamark.formats.archive",
    ),
)
FORMATS: Mapping[str, Format] = {one.name: one for one in _ALL}
