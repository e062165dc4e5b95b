"""The first result of a submission counts: its fresh trials are known from then on.

What reaches a program besides its bytes, such as the time of day, could tell it which of many
stored variants fits that water. So a later run of the same submission ranks only with the same
result. A worker holds the data of fresh trials back until the run has ended by what its program
does: until then nobody knows the water. What was seen outlives the run and the account.

A run that was cancelled, or exceeded a time limit, which may be the fault of a busy host, never
shows its fresh trials: nobody can use up a submission of somebody else by starting and cancelling
it. For the account itself it is used up all the same, since a program can tell a little even so, by
how fast it runs.
"""

import time

from sqlalchemy import Select, and_, or_, select
from sqlalchemy.orm import Session

from seamark.programs.failure_reasons import FailureReason
from seamark.server.database.submission_tables import SeenSubmission
from seamark.server.database.tables import Run
from seamark.server.database.upsert import insert_missing
from seamark.server.runs.record.states import RunState

# By what depends on the host too: a busy one makes a program exceed its time limit.
HIDDEN_FAILURES = (FailureReason.PLATFORM_ERROR, FailureReason.TIME_LIMIT)
_AGAIN = "Change the program to enter again, with other fresh trials."


def shows_fresh_trials(failure: str | None) -> bool:
    """Return whether the data of a run's fresh trials are shown when it has ended like this.

    Parameters
    ----------
    failure
        A FailureReason; None if it succeeded.
    """
    return failure not in HIDDEN_FAILURES


def record(session: Session, run_id: int, digest: str | None) -> None:
    """Record that the data of a run's fresh trials are about to be shown, unless others were.

    Parameters
    ----------
    digest
        Of its telemetry; None if its program failed.
    """
    run = session.get_one(Run, run_id)
    if not _has_fresh_water(run):
        return
    row = {"submission": run.submission, "run_id": run_id, "digest": digest}
    insert_missing(session, SeenSubmission, row | {"seen_at": time.time()})


def refusal(session: Session, run: Run, digest: str | None) -> str | None:
    """Return why a run with this result does not rank after others; None if it does."""
    if not _has_fresh_water(run):
        return None
    first = session.get(SeenSubmission, run.submission)
    if first is not None and first.run_id != run.id:
        return None if first.digest == digest else _other_result(session, run, first.run_id)
    hidden = session.scalar(_own_hidden(run).limit(1))
    if hidden is None:
        return None
    return (
        f"Run {hidden} was of the same program and configuration, and was cancelled or exceeded "
        f"its time limit after its start. {_AGAIN}"
    )


def _has_fresh_water(run: Run) -> bool:
    """Return whether knowing its water could help: built-in solutions are the same every time."""
    return run.submission is not None and run.has_programs


def _other_result(session: Session, run: Run, first_id: int) -> str:
    first = session.get(Run, first_id)
    may_see = first is not None and (first.public or first.user_id == run.user_id)
    named = f"Run {first_id}" if may_see else "A run of another account"
    return (
        f"{named} was of the same program and configuration and did not have this result. "
        "The first run of a submission counts, because its fresh trials are known from then on. "
        f"{_AGAIN}"
    )


def _own_hidden(run: Run) -> Select[int]:
    cancelled = and_(Run.state == RunState.CANCELLED, Run.started_at.is_not(None))
    failed = and_(Run.state == RunState.FAILED, Run.cause == FailureReason.TIME_LIMIT)
    return select(Run.id).where(
        Run.submission == run.submission,
        Run.user_id == run.user_id,
        Run.id != run.id,
        or_(cancelled, failed),
    )
