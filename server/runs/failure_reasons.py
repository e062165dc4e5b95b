"""Why a run failed, in words for its owner: one table for all pages, the API and the log."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any


class Cause(StrEnum):
    """Why a run is `failed`. The first seven are seamark.sandbox.outcome.Verdict's values."""

    USER_ERROR = "user_error"
    COMPILE_ERROR = "compile_error"
    PROTOCOL_ERROR = "protocol_error"
    TIME_LIMIT = "time_limit"
    MEMORY_LIMIT = "memory_limit"
    OUTPUT_LIMIT = "output_limit"
    PROCESS_LIMIT = "process_limit"
    BENCHMARK_ERROR = "benchmark_error"
    PLATFORM_ERROR = "platform_error"


@dataclass(frozen=True, slots=True)
class Words:
    """What is shown for a cause when the sandbox gives no better sentence."""

    title: str
    sentence: str
    remedy: str


WORDS: dict[Cause, Words] = {
    Cause.USER_ERROR: Words(
        "The program raised an error",
        "The program stopped with an exception of its own.",
        "Read the traceback below; the last lines of the log show what it printed before.",
    ),
    Cause.COMPILE_ERROR: Words(
        "The program could not be loaded",
        "The source has an error that shows before its first step.",
        "Correct the line named below and check the file before you submit it again.",
    ),
    Cause.PROTOCOL_ERROR: Words(
        "The program gave an unusable answer",
        "Each step must return four finite numbers: surge, sway, heave [m/s] and yaw rate [rad/s].",
        "Check for NaN, for a missing return and for lists of another length.",
    ),
    Cause.TIME_LIMIT: Words(
        "The program took too long",
        "The program used up its time.",
        "Look for endless loops, for sleep() and for work that could be done once in reset().",
    ),
    Cause.MEMORY_LIMIT: Words(
        "The program used too much memory",
        "The program asked for more memory than a run may use.",
        "Keep only what the program needs; lists that grow at each step are the usual reason.",
    ),
    Cause.OUTPUT_LIMIT: Words(
        "The program printed too much",
        "The program wrote more output than a run may keep.",
        "Print less: the telemetry of every step is recorded anyway.",
    ),
    Cause.PROCESS_LIMIT: Words(
        "The program started too many processes",
        "The program started more processes or threads than a run may have.",
        "Do the work in one process; numerical libraries are set to one thread already.",
    ),
    Cause.BENCHMARK_ERROR: Words(
        "The experiment could not be carried out",
        "This configuration brings the simulation to a point where it has no valid state.",
        "Change the configuration, gains above all; nobody's quota is charged for this run.",
    ),
    Cause.PLATFORM_ERROR: Words(
        "The service failed",
        "Something on our side broke several times in a row. Your program is not to blame.",
        "Run it again; the run does not count against your quota.",
    ),
}
# What programs meet that look for something outside of their box.
OUTSIDE = ("PermissionError", "FileNotFoundError", "ConnectionError", "gaierror")
_ALONE = (
    "A program runs in a sandbox: it has no network and sees no files but its own under /tmp. "
    "Put what it needs into its text."
)
UNCHARGED = (Cause.BENCHMARK_ERROR, Cause.PLATFORM_ERROR)  # not the owner's doing: no quota


def words(cause: Cause, *, sentence: str = "") -> dict[str, Any]:
    """Return title, sentence and remedy for a run's `detail`; a better sentence replaces ours."""
    found = WORDS[cause]
    outside = cause is Cause.USER_ERROR and sentence.startswith(OUTSIDE)
    return {
        "title": found.title,
        "sentence": sentence or found.sentence,
        "remedy": _ALONE if outside else found.remedy,
    }
