"""The end of a run: state, result, metrics, manifest and rank in one transaction."""

import math
import time
from dataclasses import dataclass, field
from typing import Any

from sqlalchemy import case, select, update
from sqlalchemy.orm import Session

from seamark.server.classes import assignments
from seamark.server.database.tables import Result, Run, User
from seamark.server.programs import own_files
from seamark.server.runs.data.error_curve import Curve
from seamark.server.runs.ending import first_results
from seamark.server.runs.leaderboard import best_runs
from seamark.server.runs.publication import publications
from seamark.server.runs.publication.publications import Terms
from seamark.server.runs.queue import paces
from seamark.server.runs.queue.queue import Claim
from seamark.server.runs.recomputation import rejudged, verifications
from seamark.server.runs.record import entries, method_names
from seamark.server.runs.record.solutions import ROSBRIDGE
from seamark.server.runs.record.states import LIVE, RunKind, RunState, move
from seamark.server.runs.record.trial_scores import trial_scores
from seamark.sim.engine.seeds import REFERENCE


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """How an evaluation ended. If it failed, `detail` explains why to the owner."""

    state: RunState  # succeeded, failed or cancelled
    cause: str | None = None
    detail: dict[str, Any] = field(default_factory=dict)
    metrics: dict[str, Any] | None = None
    manifest: dict[str, Any] | None = None
    digest: str | None = None
    progress: float = 1.0
    t_simulated: float = 0.0
    isolation: str | None = None
    data_bytes: int = 0  # of its files and its program
    error_curve: Curve | None = None


class ResultInvalid(Exception):
    """A successful run without a finite score: a bug, never stored or ranked."""


def finish(session: Session, claim: Claim, report: Report) -> bool:
    """Store how a run ended; False, with nothing written, if the claim is no longer valid."""
    if report.state is RunState.CANCELLED:
        return _close_cancelled(session, claim, report)
    score = _score(report)
    moved = move(
        session,
        claim.run_id,
        RunState.RUNNING,
        report.state,
        fence=claim.attempt,
        cause=report.cause,
        detail=report.detail,
        progress=report.progress,
        t_simulated=report.t_simulated,
        isolation=report.isolation,
        data_bytes=report.data_bytes,
        data_measured=True,
    )
    if not moved:
        return False
    metrics = report.metrics or {}
    is_baseline = _is_baseline(session, claim)
    refusal = None if is_baseline else _refusal(session, claim, report)
    allowed = is_baseline or bool(metrics.get("rankable", True))
    entered = entries.record(session, claim.run_id, report.metrics)
    refusal = refusal or entered
    session.add(
        Result(
            run_id=claim.run_id,
            attempt=claim.attempt,
            digest=report.digest,
            score=score,
            score_low=metrics.get("score_low"),
            score_high=metrics.get("score_high"),
            level_held=metrics.get("level_held"),
            rankable=score is not None and allowed and refusal is None,
            not_ranked=refusal,
            reference_scores=trial_scores(metrics, REFERENCE) or None,
            error_curve=report.error_curve,
            metrics=report.metrics,
            manifest=None if report.manifest is None else own_files.without_texts(report.manifest),
            created_at=time.time(),
        )
    )
    session.flush()
    assignments.score(session, claim.run_id, score)
    if report.state is RunState.SUCCEEDED and claim.controller != ROSBRIDGE:
        _record_pace(session, claim.run_id)
    best_runs.recount(session, claim.run_id)
    if is_baseline and report.state is RunState.SUCCEEDED:
        _publish_baseline(session, claim)
    rejudged.compare(session, claim.run_id)
    verifications.record(session, claim.run_id)
    return True


def cancel(session: Session, run_id: int) -> RunState | None:
    """Cancel a queued or running run and return the state it was in; None if it has ended.

    The state changes here and not in the worker, so that a run whose worker hangs is cancelled
    too. A working worker notices within half a second and stops.
    """
    # Without an attempt there are no files, and nobody who will measure them.
    nothing: dict[str, Any] = {"data_bytes": case((Run.attempt == 0, 0), else_=Run.data_bytes)}
    for state in LIVE:
        if move(session, run_id, state, RunState.CANCELLED, **nothing):
            return state
    return None


def _close_cancelled(session: Session, claim: Claim, report: Report) -> bool:
    """Complete a run that is already cancelled with what the worker recorded."""
    closed = (
        update(Run)
        .where(Run.id == claim.run_id, Run.attempt == claim.attempt)
        .where(Run.state == RunState.CANCELLED, Run.data_deleted_at.is_(None))
        .values(
            detail=report.detail,
            progress=report.progress,
            t_simulated=report.t_simulated,
            isolation=report.isolation,
            data_bytes=report.data_bytes,
            data_measured=True,
        )
    )
    if session.scalar(closed.returning(Run.id)) is None:
        return False
    best_runs.recount(session, claim.run_id)
    return True


def _score(report: Report) -> float | None:
    if report.state is not RunState.SUCCEEDED:
        return None
    score = (report.metrics or {}).get("score")
    if not isinstance(score, int | float) or not math.isfinite(score):
        raise ResultInvalid(f"a succeeded run must have a finite score, not {score!r}")
    return float(score)


def _record_pace(session: Session, run_id: int) -> None:
    times = select(Run.finished_at - Run.started_at, Run.t_simulated).where(Run.id == run_id)
    wall_s, simulated_s = session.execute(times).one()
    paces.record(session, run_id, wall_s=wall_s or 0.0, simulated_s=simulated_s)


def _refusal(session: Session, claim: Claim, report: Report) -> str | None:
    """Return why a run does not rank; None if the rules of benchmark and service allow it."""
    run = session.get_one(Run, claim.run_id)
    if run.kind != RunKind.RANKED or report.state is not RunState.SUCCEEDED:
        return None
    by_benchmark: str | None = (report.metrics or {}).get("not_ranked")
    return by_benchmark or first_results.refusal(session, run, report.digest)


def _is_baseline(session: Session, claim: Claim) -> bool:
    """Return whether the run is a baseline: a mark, which no rule keeps off the leaderboard."""
    owner = select(User.is_baseline).join(Run, Run.user_id == User.id)
    return bool(session.scalar(owner.where(Run.id == claim.run_id)))


def _publish_baseline(session: Session, claim: Claim) -> None:
    """Publish a baseline as soon as it has succeeded: it is for everybody to compare with."""
    run = session.get_one(Run, claim.run_id)
    name = method_names.suggested(run, title=run.title)
    publications.publish(session, run.id, Terms(method=name))
