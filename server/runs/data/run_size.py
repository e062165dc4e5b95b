"""How much a run records: estimated before it starts, so that nobody is surprised by a full disk.

The rows are known exactly. Metrics and log are estimated from above.
"""

from dataclasses import dataclass

from seamark.server.runs.data.files import HEAD_MAX, TAIL_MAX
from seamark.sim.settings.configuration import Configuration

# [B] of metrics.json and of its copy in the database: 6 KiB each in currents-v2, 2 in visibility-v2
METRICS_BYTES_PER_LEVEL = 12 * 2**10
MANIFEST_SHARE = 3  # [B] of manifest.json for a byte of a text: "\u00e9" for two
_UNITS = ("bytes", "KiB", "MiB", "GiB", "TiB")


@dataclass(frozen=True, slots=True)
class RunSize:
    """What a run may record."""

    rows: int  # of telemetry
    bytes: int

    def refusal(self, limit: int) -> str | None:
        """Return why a run of this size is refused; None if it has at most `limit` bytes."""
        if self.bytes <= limit:
            return None
        return (
            f"This run would record {self.rows:,} rows of telemetry, about {size(self.bytes)}; a "
            f"practice run may record {size(limit)}. Choose fewer levels or trials, shorter levels "
            "or a longer control period."
        )


def estimate(
    config: Configuration, *, trials: int, program_bytes: int | None, files_bytes: int = 0
) -> RunSize:
    """Return what a run may record.

    Parameters
    ----------
    program_bytes
        Size of the uploaded program, which is stored with the run and may print; None without one.
    files_bytes
        Size of the user's own files that settings name, which are stored, and again in the
        manifest.
    """
    rows, columns = config.telemetry_shape()
    per_trial = 8 * rows * columns + METRICS_BYTES_PER_LEVEL * len(config.level_values())
    own = 0 if program_bytes is None else program_bytes + HEAD_MAX + TAIL_MAX
    own += files_bytes * (1 + MANIFEST_SHARE)
    return RunSize(trials * rows, trials * per_trial + own)


def size(count: int) -> str:
    """Return a number of bytes in a suitable unit."""
    if count < 1024:
        return f"{count} bytes"
    value, unit = float(count), 0
    while value >= 1000 and unit < len(_UNITS) - 1:
        value, unit = value / 1024, unit + 1
    return f"{value:.3g} {_UNITS[unit]}"
