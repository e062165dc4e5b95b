"""How a program ended: data for its owner; and the two exceptions of a box."""

from dataclasses import dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """How the user's program ended. This is data, not our failure: a result like any other."""

    OK = "ok"
    USER_ERROR = "user_error"
    COMPILE_ERROR = "compile_error"
    PROTOCOL_ERROR = "protocol_error"
    TIME_LIMIT = "time_limit"
    MEMORY_LIMIT = "memory_limit"
    OUTPUT_LIMIT = "output_limit"
    PROCESS_LIMIT = "process_limit"


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a program ended. The runner inside the box may claim one: show it, do not trust it."""

    verdict: Verdict
    sentence: str
    traceback: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What is known about a program after its end. All text is written for its owner."""

    verdict: Verdict
    sentence: str
    traceback: str = ""  # the frames of the user's program, without ours
    cpu_s: float = 0.0  # [s] all processes of the box
    wall_s: float = 0.0  # [s] from the program's arrival to its end
    memory_mib: float = 0.0  # [MiB] peak of all processes; of the largest one without cgroups
    output: bytes = b""  # what it printed: head, a line with the number of dropped bytes, tail
    output_dropped: int = 0  # [bytes]
    suspect_host: bool = False  # a wall limit was hit with little CPU time used: worth one retry


class ProgramEnded(Exception):
    """The program ended early, or badly. Carries the outcome."""

    def __init__(self, outcome: Outcome) -> None:
        super().__init__(outcome.sentence)
        self.outcome = outcome


class SandboxBroken(Exception):
    """The box failed, not the program. Nobody is blamed; the run is queued again."""
