"""How trials and runs ended: what crosses the borders between the processes of a worker."""

from dataclasses import asdict, dataclass, field
from typing import Any, Self

from seamark.programs.failure_reasons import FailureReason
from seamark.sandbox.outcome import Outcome
from seamark.sim.engine.trial import TrialResult


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialOutcome:
    """How one trial ended: with a result, or because the program failed or the state diverged."""

    result: TrialResult | None = None
    program: Outcome | None = None  # of the program in its box; None for a built-in controller
    divergence: str = ""  # why the simulation could not continue
    box_start_s: float | None = None  # [s] until the program was loaded; None: there is none


@dataclass(frozen=True, slots=True, kw_only=True)
class RunOutcome:
    """How the evaluation of a run or of a check ended; a check has no metrics and no manifest."""

    failure: FailureReason | None = None  # None: it succeeded
    sentence: str = ""
    traceback: str = ""  # of the user's program
    usage: dict[str, float] = field(default_factory=dict)  # of the program; never compared
    metrics: dict[str, Any] | None = None
    manifest: dict[str, Any] | None = None
    digest: str = ""
    box_starts_s: list[float] = field(default_factory=list)  # of the trials; for monitoring

    def to_json(self) -> dict[str, Any]:
        """Return the outcome as values that JSON knows."""
        return asdict(self)

    @classmethod
    def from_json(cls, values: dict[str, Any]) -> Self:
        """Return the outcome that `to_json` was given."""
        failure = values.pop("failure")
        return cls(failure=None if failure is None else FailureReason(failure), **values)


def no_longer_valid(why: Exception) -> RunOutcome:
    """Return how a run ends whose configuration most likely an older version has accepted."""
    sentence = f"This configuration is no longer valid: {why}"
    return RunOutcome(failure=FailureReason.BENCHMARK_ERROR, sentence=sentence)
