"""Reads a log of any kind: CSV, MCAP or ROS bag."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from seamark.mission_logs.csv_log import read as read_csv
from seamark.mission_logs.guesses import Guesses
from seamark.mission_logs.mapping import LogMapping
from seamark.mission_logs.result import LogRefused
from seamark.mission_logs.samples import Samples
from seamark.mission_logs.scope import CSV_SUFFIXES, ROS_SUFFIXES, unknown_file


def read(path: Path, mapping: LogMapping) -> tuple[Sequence[Samples], Guesses]:
    """Return what was measured together, each in the frame of the log, and what was guessed.

    Raises
    ------
    LogRefused
        The log cannot be read; the text says where and why.
    """
    try:
        if path.is_dir() or path.suffix in ROS_SUFFIXES:
            from seamark.mission_logs.ros_log import read as read_ros

            return read_ros(path, mapping)
        if path.suffix in CSV_SUFFIXES:
            samples, guessed = read_csv(path, mapping)
            return [samples], guessed
    except OSError as error:
        raise LogRefused(f"The log cannot be read: {error.strerror}.") from None
    raise LogRefused(unknown_file(path.name))
