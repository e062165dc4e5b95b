"""What measuring a log gives: a result, or a refusal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from seamark.sim.recording.telemetry import Rows

LOG = "log"  # what stands where runs have the name of a solution
WHAT = "measured log, not simulated"


class LogRefused(Exception):
    """The log or its mapping breaks a rule. The text is for the user."""


@dataclass(frozen=True, kw_only=True)
class LogResult:
    """What `seamark run --out` and a server store of a run, of a log."""

    benchmark: str
    config: dict[str, Any]
    trials: int
    rows: Rows
    metrics: dict[str, Any]
    manifest: dict[str, Any]
    digest: str
