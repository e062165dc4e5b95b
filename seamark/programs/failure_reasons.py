"""Why a run failed, explained to its owner: one table for the pages, the API and the log."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from seamark.programs.failure_hints import hint
from seamark.sandbox.outcome import Verdict


class FailureReason(StrEnum):
    """Why a run failed: because of its program, as the sandbox says, or of something else."""

    USER_ERROR = Verdict.USER_ERROR.value
    COMPILE_ERROR = Verdict.COMPILE_ERROR.value
    PROTOCOL_ERROR = Verdict.PROTOCOL_ERROR.value
    TIME_LIMIT = Verdict.TIME_LIMIT.value
    MEMORY_LIMIT = Verdict.MEMORY_LIMIT.value
    OUTPUT_LIMIT = Verdict.OUTPUT_LIMIT.value
    PROCESS_LIMIT = Verdict.PROCESS_LIMIT.value
    BENCHMARK_ERROR = "benchmark_error"
    PLATFORM_ERROR = "platform_error"


@dataclass(frozen=True, slots=True)
class Description:
    """What the owner reads about a failure; the sandbox may have a more precise sentence."""

    title: str
    sentence: str
    remedy: str


DESCRIPTIONS: dict[FailureReason, Description] = {
    FailureReason.USER_ERROR: Description(
        "The program raised an error",
        "The program stopped with an exception.",
        "Read the traceback below; the last lines of the log show what was printed before it.",
    ),
    FailureReason.COMPILE_ERROR: Description(
        "The program could not be loaded",
        "The source has an error that was found before the first step.",
        "Fix the line named below, then check the file before you submit it again.",
    ),
    FailureReason.PROTOCOL_ERROR: Description(
        "The program returned an invalid answer",
        "Each step must return four finite numbers: surge, sway, heave [m/s] and yaw rate [rad/s].",
        "Look for NaN, a missing return statement, or a list of the wrong length.",
    ),
    FailureReason.TIME_LIMIT: Description(
        "The program took too long",
        "The program exceeded its time limit.",
        "Look for infinite loops, sleep(), and work that reset() could do once.",
    ),
    FailureReason.MEMORY_LIMIT: Description(
        "The program used too much memory",
        "The program needed more memory than a run may use.",
        "The usual reason is a list that grows at every step; keep only what is needed.",
    ),
    FailureReason.OUTPUT_LIMIT: Description(
        "The program printed too much",
        "The program printed more than a run may store.",
        "Print less: the telemetry records every step anyway.",
    ),
    FailureReason.PROCESS_LIMIT: Description(
        "The program started too many processes",
        "The program started more processes or threads than a run may have.",
        "Do the work in one process; numerical libraries already use a single thread.",
    ),
    FailureReason.BENCHMARK_ERROR: Description(
        "The experiment could not be carried out",
        "With this configuration the simulation reached an invalid state.",
        "Change the configuration, the gains first; the run does not count against your quota.",
    ),
    FailureReason.PLATFORM_ERROR: Description(
        "The service failed",
        "The service failed several times in a row. Your program did not cause this.",
        "Run it again; the run does not count against your quota.",
    ),
}
# The owner did nothing wrong: these runs do not count against the quota.
UNCHARGED = (FailureReason.BENCHMARK_ERROR, FailureReason.PLATFORM_ERROR)


def describe(reason: FailureReason, *, sentence: str = "") -> dict[str, Any]:
    """Return title, sentence, remedy and the address of a page about it for a run's `detail`.

    `sentence` replaces the general one.
    """
    description, special = DESCRIPTIONS[reason], hint(sentence)
    return {
        "title": description.title,
        "sentence": sentence or description.sentence,
        "remedy": special.remedy or description.remedy,
        "page": special.page,
    }
