"""The baselines: ordinary ranked runs of built-in controllers and trackers.

They belong to reserved users. A user is on the leaderboard once, with the best run, so
each baseline has a user of its own.
"""

import time

import structlog
from sqlalchemy import select
from sqlalchemy.orm import Session

from seamark.server.accounts.accounts import RESERVED_PREFIX
from seamark.server.accounts.permissions import Viewer
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.tables import Run, User
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.runs.submission import submission, validation
from seamark.server.runs.submission.validation import Submission
from seamark.server.settings import Settings
from seamark.sim import registry

_log = structlog.get_logger()


def ensure(session: Session, settings: Settings) -> list[int]:
    """Submit the baselines that are missing; return the ids of the new runs.

    The workers evaluate them like all runs; they become public when they succeed. A baseline that
    failed or was withdrawn is not submitted again: the operator should see why.
    """
    acquire(session, AdvisoryLock.BASELINES)
    submitted: list[int] = []
    for benchmark in map(registry.benchmark, registry.BENCHMARKS):
        for suffix, baseline in benchmark.baselines.items():
            user = _user(session, f"{RESERVED_PREFIX}-{suffix}")
            if _exists(session, user.id, benchmark.name):
                continue
            baseline_run = Submission(
                viewer=Viewer(user_id=user.id, name=user.name),
                benchmark=benchmark.name,
                config=baseline.config,
                kind=RunKind.RANKED,
                controller=baseline.built_in,
                title=baseline.title,
                notes=baseline.notes,
                baseline=True,
            )
            valid = validation.validate(baseline_run, settings)
            submitted.append(submission.submit(session, valid, settings))
    if submitted:
        _log.info("baselines_submitted", runs=submitted)
    return submitted


def _user(session: Session, name: str) -> User:
    user = session.scalar(select(User).where(User.name_key == name))
    if user is None:
        user = User(name=name, name_key=name, is_baseline=True, created_at=time.time())
        session.add(user)
        session.flush()
    return user


def _exists(session: Session, user_id: int, benchmark: str) -> bool:
    query = select(Run.id).where(
        Run.user_id == user_id, Run.benchmark == benchmark, Run.state != RunState.CANCELLED
    )
    return session.scalar(query.limit(1)) is not None
