"""Evaluating published ranked runs again on fresh trials, to see whether their scores hold.

A verification is a hidden run (rejudged.py) with the program and the configuration of the published
one and newly drawn fresh seeds. Their water is unknown beforehand and is not shown afterwards.

The scores agree unless they differ significantly: by Welch's t test at the level `ALPHA`, between
the fresh trials of both. So 1 in 100 programs that are as good on new trials as on those of their
published run is marked as different by chance. docs/publishing.md explains it for users.

A program must not be able to avoid a bad mark in either of two ways: by stopping the simulation
when it does badly (so an invalid state counts as a failure, `_says_nothing`), and by doing well in
only a part of its published water, if it knew that, which gives a high score with so large a spread
that every other score agrees with it (so the spread is limited, `SPREAD_MAX`).
"""

import math
import time
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from importlib.metadata import version

from sqlalchemy import func, select
from sqlalchemy.orm import Session, undefer

from seamark.programs.failure_reasons import FailureReason
from seamark.server.accounts.permissions import VERIFICATIONS
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.publication_tables import Verification
from seamark.server.database.tables import BestMethod, Result, Run
from seamark.server.runs.leaderboard import leaderboard
from seamark.server.runs.recomputation import rejudged
from seamark.server.runs.record import turns
from seamark.server.runs.record.states import LIVE, RunKind, RunState
from seamark.server.runs.record.trial_scores import error_of_score
from seamark.server.settings import Settings
from seamark.server.storage import storage
from seamark.sim import registry
from seamark.sim.numerics.ranking import Estimate
from seamark.sim.numerics.statistics import welch_degrees
from seamark.sim.numerics.student_t import quantile

ALPHA = 0.01  # probability that a score which holds is called different
SPREAD_MAX = 2.0  # largest published standard error in the lower margin, in fresh ones
BROKEN_MAX = 3  # verifications of a run that the service may break before its owner has to ask


class VerificationRefused(Exception):
    """A run cannot be verified now. The text is shown to the user."""


class Outcome(StrEnum):
    """The result of a verification."""

    AGREES = "agrees"
    DIFFERS = "differs"
    FAILED = "failed"  # the program failed on the fresh trials


@dataclass(frozen=True, slots=True, kw_only=True)
class VerificationView:
    """A verification that has ended."""

    outcome: Outcome
    at: float  # [s since 1970]
    version: str  # of Seamark
    digest: str | None  # of the telemetry
    cause: str | None  # a FailureReason, if the program failed
    score: float | None
    score_low: float | None  # of its own 95 % interval
    score_high: float | None
    expected_low: float | None  # scores between these agree with the published one
    expected_high: float | None


def request(session: Session, run_id: int, settings: Settings, *, repeat: bool = False) -> int:
    """Queue a verification of a published run, after all runs of users; return its hidden run's id.

    Parameters
    ----------
    repeat
        Also if this version has verified it already: for admins only, since owners could ask until
        chance gives a result that they like.

    Raises
    ------
    VerificationRefused
        The run cannot be verified, is being verified, or has been.
    StorageUnavailable
        There is no room for what it may record, or the data folder is away.
    """
    storage.require(settings)
    acquire(session, AdvisoryLock.SUBMISSION)
    run = session.get_one(Run, run_id, options=[undefer(Run.program_parameters)])
    if refusal := _refusal(session, run):
        raise VerificationRefused(refusal)
    done = select(func.count()).where(Verification.run_id == run_id)
    if not repeat and session.scalar(done.where(Verification.version == version("seamark"))):
        raise VerificationRefused("This version of Seamark has verified the run already.")
    broken = session.scalar(done.where(Verification.ended_at.is_(None))) or 0
    if not repeat and broken >= BROKEN_MAX:
        raise VerificationRefused(f"{broken} verifications of this run broke: ask an admin.")
    draw = (session.scalar(done) or 0) + 1
    hidden = rejudged.enqueue(session, run, VERIFICATIONS, settings, draw=draw)
    session.flush()
    session.add(Verification(again_id=hidden.id, run_id=run_id, requested_at=time.time()))
    turns.refresh(session, VERIFICATIONS)
    return hidden.id


def request_first(session: Session, settings: Settings) -> list[int]:
    """Queue verifications of the first `verify_top` entries of each leaderboard; return the runs.

    Entries that have a verification already, even one that broke, are left to their owners.
    """
    queued: list[int] = []
    for name in registry.BENCHMARKS if settings.verify_top else ():
        leaders = leaderboard.leaders(session, registry.benchmark(name), settings.verify_top)
        ids = {rank.run_id for rank in leaders}
        known = select(Verification.run_id).where(Verification.run_id.in_(ids))
        for run_id in sorted(ids - set(session.scalars(known))):
            if not _refusal(session, session.get_one(Run, run_id)):
                queued.append(request(session, run_id, settings))
    return queued


def record(session: Session, run_id: int) -> None:
    """Store the result of a verification when its hidden run ends, unless the service failed."""
    row = session.get(Verification, run_id)
    run = session.get_one(Run, run_id)
    if row is None or _says_nothing(run):
        return
    result = session.get_one(Result, run_id)
    row.ended_at, row.version = time.time(), version("seamark")
    row.digest, row.cause = result.digest, run.cause
    row.score, row.score_low, row.score_high = result.score, result.score_low, result.score_high
    row.standard_error, row.degrees = error_of_score(run.benchmark, result.metrics)
    run.data_deleted_at, run.data_bytes = time.time(), 0  # its water stays unknown


def _says_nothing(run: Run) -> bool:
    """Return whether a verification ended because of the service or an outdated configuration.

    A simulation that reached an invalid state did so because of the program's commands: the
    published run did not reach one.
    """
    if run.cause == FailureReason.BENCHMARK_ERROR:
        return not run.t_simulated
    return run.cause == FailureReason.PLATFORM_ERROR


def of_run(session: Session, run_id: int) -> list[VerificationView]:
    """Return the verifications of a run that have ended, the newest first."""
    return _views(session, [run_id]).get(run_id, [])


def newest(session: Session, run_ids: Collection[int]) -> Mapping[int, VerificationView]:
    """Return the newest verification of each run that has one."""
    return {run_id: views[0] for run_id, views in _views(session, run_ids).items()}


def is_pending(session: Session, run_id: int) -> bool:
    """Return whether a verification of the run waits or is under way."""
    query = select(Run.id).join(Verification, Verification.again_id == Run.id)
    live = query.where(Verification.run_id == run_id, Run.state.in_(LIVE))
    return session.scalar(live.limit(1)) is not None


def agree(published: Estimate, again: Estimate) -> bool:
    """Return whether two scores differ by no more than chance allows; True if that is unknown."""
    margins = _margins(published, again)
    return margins is None or -margins[0] <= again.score - published.score <= margins[1]


def _views(session: Session, run_ids: Collection[int]) -> dict[int, list[VerificationView]]:
    query = (
        select(Verification, Run.benchmark, Result.score)
        .add_columns(BestMethod.standard_error, BestMethod.degrees)
        .join(Run, Run.id == Verification.run_id)
        .join(Result, Result.run_id == Verification.run_id)
        .outerjoin(BestMethod, BestMethod.run_id == Verification.run_id)
        .where(Verification.run_id.in_(run_ids), Verification.ended_at.is_not(None))
        .order_by(Verification.again_id.desc())
    )
    by_run = dict[int, list[VerificationView]]()
    for row, benchmark, score, best_error, best_degrees in session.execute(query):
        error, degrees = best_error, best_degrees
        if degrees is None:  # the run is not on the leaderboard, which stores both
            metrics = session.scalar(select(Result.metrics).where(Result.run_id == row.run_id))
            error, degrees = error_of_score(benchmark, metrics)
        published = Estimate(score=score or 0.0, standard_error=error, degrees=degrees)
        by_run.setdefault(row.run_id, []).append(_view(row, published))
    return by_run


def _view(row: Verification, published: Estimate) -> VerificationView:
    again = Estimate(score=row.score or 0.0, standard_error=row.standard_error, degrees=row.degrees)
    margins = None if row.score is None else _margins(published, again)
    low = high = None
    outcome = Outcome.FAILED
    if margins is not None:
        low, high = published.score - margins[0], published.score + margins[1]
        outcome = Outcome.AGREES if agree(published, again) else Outcome.DIFFERS
    return VerificationView(
        outcome=outcome,
        at=row.ended_at or 0.0,
        version=row.version or "",
        digest=row.digest,
        cause=row.cause,
        score=row.score,
        score_low=row.score_low,
        score_high=row.score_high,
        expected_low=low,
        expected_high=high,
    )


def _margins(published: Estimate, again: Estimate) -> tuple[float, float] | None:
    """Return how far below and above the published score another agrees; None if it is unknown."""
    if published.standard_error is None or again.standard_error is None:
        return None
    spread = min(published.standard_error, SPREAD_MAX * again.standard_error)
    return _margin(replace(published, standard_error=spread), again), _margin(published, again)


def _margin(one: Estimate, other: Estimate) -> float:
    """Return the least difference of two scores that is significant."""
    first, second = one.standard_error or 0.0, other.standard_error or 0.0
    error = math.hypot(first, second)
    share = (first / error) ** 2 if error else 1.0
    degrees = welch_degrees(share, float(one.degrees), float(other.degrees))
    return quantile(0.5 * ALPHA, degrees) * error


def _refusal(session: Session, run: Run) -> str:
    """Return why a run cannot be verified; empty if it can."""
    result = session.get(Result, run.id)
    if not run.public or run.kind != RunKind.RANKED or run.state != RunState.SUCCEEDED:
        return "Only published ranked runs that succeeded can be verified."
    if result is None or not result.rankable or run.benchmark not in registry.BENCHMARKS:
        return "Only runs that count for the leaderboard can be verified."
    if error_of_score(run.benchmark, result.metrics)[0] is None:
        return "The run has too few trials to tell whether two scores differ."
    if run.data_deleted_at is not None:
        return "The data of the run have been deleted, and its program with them."
    if is_pending(session, run.id):
        return "The run is being verified. That may take a while: runs of users go first."
    return ""
