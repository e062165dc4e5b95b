"""The formats by name: what they are called, and what writes them. Importing this is light."""

from __future__ import annotations

import importlib
from collections.abc import Callable
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
    document: str = ""  # of its download, in the documentation of the API
    packages: tuple[str, ...] = ()  # beyond those that Seamark always has
    converted: bool = True  # by a process of its own for each download
    folded: bool = True  # on the page of a run, with the others
    images: bool = False  # renders camera images, which needs the seeds of the trials
    whole: bool = False  # has the program of the run as well, and how it is cited
    rows_max: int | None = None
    noun: str = ""  # where there are more rows than that
    instead: str = ""  # what to do then

    def refusal(self, rows: int) -> str:
        """Return why a run with this number of rows cannot be written; empty if it can."""
        if self.rows_max is None or rows <= self.rows_max:
            return ""
        most = f"{self.rows_max:,}"
        return f"The run has {rows:,} rows; a {self.noun} may have {most}. {self.instead}"

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
        converted=False,
        folded=False,
    ),
    Format(
        name="parquet",
        file="telemetry.parquet",
        media_type="application/vnd.apache.parquet",
        label="for pandas, Polars, DuckDB; with units",
        module="seamark.formats.parquet",
        document="Download all rows so far as Apache Parquet; the metadata of a column has its "
        "unit.",
        packages=("pyarrow",),
    ),
    Format(
        name="mcap",
        file="telemetry.mcap",
        media_type="application/octet-stream",
        label="for Foxglove and ROS 2; with poses and camera images",
        module="seamark.formats.ros.mcap_file",
        document="Download all rows so far as MCAP: ROS 2 messages with poses and camera images, "
        "for Foxglove.\n\nAn image per second of simulated time, 600 at most; the layout for "
        "Foxglove is attached.",
        images=True,
        packages=("mcap_ros2",),
    ),
    Format(
        name="npz",
        file="telemetry.npz",
        media_type="application/zip",
        label="for NumPy",
        module="seamark.formats.npz",
        document="Download all rows so far for NumPy: a structured array, and arrays with the "
        "units.",
    ),
    Format(
        name="mat",
        file="telemetry.mat",
        media_type="application/x-matlab-data",
        label="for MATLAB and Octave",
        module="seamark.formats.mat",
        document="Download all rows so far as a MAT-file (version 7): a variable for each column.",
        # A variable may have 2 GB, but it is compressed in memory: 40 bytes for each row.
        rows_max=3_000_000,
        noun="MAT-file",
        instead="MATLAB reads telemetry.parquet with parquetread, at any length.",
    ),
    Format(
        name="archive",
        file="archive.zip",
        media_type="application/zip",
        label="everything that `seamark rerun` needs",
        module="seamark.formats.archive",
        document="Download manifest, configuration, metrics, telemetry and program for `seamark "
        "rerun`.\n\nThe program is in the archive of your own and of public runs. A run that has "
        "not ended has no\nmanifest and no metrics yet.",
        folded=False,
        whole=True,
    ),
)
FORMATS: dict[str, Format] = {one.name: one for one in _ALL}
