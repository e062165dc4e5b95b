"""Which files and which benchmarks logs are for. Importing this is light."""

from __future__ import annotations

from pathlib import PurePath

from seamark.mission_logs.result import LogRefused
from seamark.sim import registry
from seamark.sim.settings.station_keeping import StationKeepingSettings

CSV_SUFFIXES = (".csv", ".gz")
ROS_SUFFIXES = (".mcap", ".bag", ".db3")  # and the folder of a ROS 2 bag
SUFFIXES = (*CSV_SUFFIXES, *ROS_SUFFIXES)
_NAME_SHOWN = 60


def measurable() -> tuple[str, ...]:
    """Return the names of the benchmarks whose metrics a log can be measured by."""
    return tuple(name for name in registry.BENCHMARKS if _measures(name))


def _measures(name: str) -> bool:
    return issubclass(registry.benchmark(name).configuration, StationKeepingSettings)


def check_benchmark(name: str) -> None:
    """Raise LogRefused if no log can be measured by this benchmark."""
    if name not in registry.BENCHMARKS or not _measures(name):
        known = " or ".join(measurable())
        raise LogRefused(f"Logs are measured by {known}, not by {name[:_NAME_SHOWN]!r}.")


def unknown_file(name: str) -> str:
    """Return the sentence that refuses a file by its name."""
    suffix = PurePath(name).suffix[:_NAME_SHOWN]
    return (
        "A log is a CSV (.csv, .csv.gz), an MCAP file or a ROS bag (.bag, .db3, or its folder), "
        f"not {suffix or 'a file without a suffix'}."
    )
