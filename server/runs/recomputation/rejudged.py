"""Runs that are computed again: what of a result differs, and how the new one replaces it.

A run of a rejudgement is a row of `runs` that nobody sees, with the program, the configuration and
the seeds of the run `rejudges`. It evaluates as any other run, after those of users.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from sqlalchemy import select, update
from sqlalchemy.orm import Session

from seamark.programs.failure_reasons import UNCHARGED
from seamark.server.accounts.permissions import REJUDGEMENTS
from seamark.server.classes import assignments
from seamark.server.database.rejudgement_tables import RejudgedRun, Rejudgement
from seamark.server.database.tables import Result, Run, User
from seamark.server.runs.record import copies, entries, seeds, totals
from seamark.server.runs.record.states import RunState
from seamark.server.settings import Settings

METRICS_SHOWN = 20  # paths of metrics that differ; their number is kept as well
# Columns of a result that one computation decides.
_RESULT = (
    *("digest", "score", "score_low", "score_high", "level_held", "rankable", "not_ranked"),
    *("reference_scores", "error_curve", "metrics", "manifest", "created_at"),
)
_RUN = ("state", "cause", "detail", "progress", "t_simulated", "isolation")


class Outcome(StrEnum):
    """Whether a run that was computed again has the same result."""

    SAME = "same"
    DIFFERENT = "different"


def owner_of(rejudgement_id: int) -> str:
    """Return the owner of the runs of a rejudgement, by which they take their turn."""
    return f"{REJUDGEMENTS}{rejudgement_id}"


def enqueue(
    session: Session, original: Run, owner: str, settings: Settings, *, draw: int | None = None
) -> Run:
    """Return a new queued run that computes another one again; the caller refreshes the turn.

    Parameters
    ----------
    draw
        Of other fresh trials; None: those of the original.
    """
    run = copies.copy_of(original, owner, rejudges=original.id, draw=draw)
    run.trial_seeds = seeds.derived(run, settings)
    session.add(run)
    return run


def compare(session: Session, run_id: int) -> None:
    """Record how the result of a run that has been computed again differs, when it ends.

    One that failed because of the service, not of its program, has no outcome.
    """
    run = session.get_one(Run, run_id)
    rejudged = session.get(RejudgedRun, run_id)
    if run.rejudges is None or rejudged is None or run.cause in UNCHARGED:
        return
    original = session.get(Run, run.rejudges)
    if original is None:
        return
    before, after = session.get(Result, original.id), session.get(Result, run.id)
    rejudged.before, rejudged.after = _summary(original, before), _summary(run, after)
    paths = _differing(before.metrics if before else None, after.metrics if after else None)
    rejudged.metrics, rejudged.metrics_count = paths[:METRICS_SHOWN], len(paths)
    same = rejudged.before == rejudged.after and not paths
    rejudged.outcome = Outcome.SAME if same else Outcome.DIFFERENT
    if same:  # nobody needs a second copy of its data
        run.data_deleted_at, run.data_bytes = time.time(), 0


def replace(session: Session, run: Run, original: Run, rejudged: RejudgedRun) -> None:
    """Give a run the result that was computed again, and keep the earlier one.

    When it was submitted and ended stays, and with that its place among equal scores.
    """
    new, old = session.get_one(Result, run.id), session.get(Result, original.id)
    rejudged.replaced_at = time.time()
    rejudged.earlier = {name: getattr(original, name) for name in (*_RUN, "data_run")}
    rejudged.earlier |= {} if old is None else {name: getattr(old, name) for name in _RESULT}
    if old is None:
        old = Result(run_id=original.id, attempt=original.attempt)
        session.add(old)
    refusal = None if _by_benchmark(old) else old.not_ranked
    is_baseline = select(User.is_baseline).where(User.id == original.user_id)
    totals.change_state(session, original, RunState(run.state))
    for name in _RUN:
        setattr(original, name, getattr(run, name))
    for name in _RESULT:
        setattr(old, name, getattr(new, name))
    if session.scalar(is_baseline):
        old.rankable, old.not_ranked = new.score is not None, None
    elif refusal is not None:  # another run of the same submission decided that
        old.rankable, old.not_ranked = False, new.not_ranked or refusal
    if original.data_deleted_at is None:
        original.data_run = run.id
    else:
        run.data_deleted_at, run.data_bytes = time.time(), 0
    assignments.score(session, original.id, new.score)
    session.flush()
    entries.record_again(session, original.id, new.metrics)


def forget(session: Session, run_ids: Sequence[int]) -> None:
    """Empty what rejudgements know of runs that are deleted."""
    again = select(Run.id).where(Run.rejudges.in_(run_ids))
    rows = update(RejudgedRun).where(RejudgedRun.run_id.in_(again))
    nothing = dict.fromkeys(("before", "after", "metrics", "earlier"))
    session.execute(rows.values(**nothing), execution_options={"synchronize_session": False})


@dataclass(frozen=True, slots=True, kw_only=True)
class Recomputation:
    """That the result of a run was computed again, as its page and the API show it."""

    at: float  # when it was accepted
    reason: str
    outcome: Outcome
    earlier: dict[str, Any] | None  # result that was replaced; None: it stayed the same
    metrics_count: int


def history(session: Session, run_id: int) -> list[Recomputation]:
    """Return the accepted computations of a run after the first one, newest first."""
    query = (
        select(RejudgedRun, Rejudgement)
        .join(Run, Run.id == RejudgedRun.run_id)
        .join(Rejudgement, Rejudgement.id == RejudgedRun.rejudgement_id)
        .where(Run.rejudges == run_id, RejudgedRun.outcome.is_not(None))
        .where(Rejudgement.decision == "accepted")
        .order_by(RejudgedRun.run_id.desc())
    )
    return [
        Recomputation(
            at=rejudgement.decided_at or 0.0,
            reason=rejudgement.reason,
            outcome=Outcome(rejudged.outcome or Outcome.SAME),
            earlier=rejudged.earlier,
            metrics_count=rejudged.metrics_count,
        )
        for rejudged, rejudgement in session.execute(query)
    ]


def _summary(run: Run, result: Result | None) -> dict[str, Any]:
    names = ("digest", "score")
    summary = {"state": str(run.state), "cause": run.cause} | dict.fromkeys(names)
    return summary if result is None else summary | {name: getattr(result, name) for name in names}


def _by_benchmark(result: Result) -> bool:
    """Return whether the benchmark itself, rather than another run, keeps a result off a board."""
    return bool((result.metrics or {}).get("not_ranked"))


def _differing(before: object, after: object) -> list[str]:
    old, new = dict(_leaves(before or {})), dict(_leaves(after or {}))
    missing = object()
    return [path for path in old | new if old.get(path, missing) != new.get(path, missing)]


def _leaves(value: object, path: str = "") -> Iterator[tuple[str, object]]:
    """Yield the numbers and texts of a JSON value with their paths: `trials[0].score`."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from _leaves(inner, f"{path}.{name}" if path else name)
    elif isinstance(value, list):
        for at, inner in enumerate(value):
            yield from _leaves(inner, f"{path}[{at}]")
    else:
        yield path, value
