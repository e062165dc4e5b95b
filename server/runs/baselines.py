"""The built-in entries of the leaderboard: ordinary ranked runs of users that nobody can be.

A user stands on the leaderboard once, with the best run; so each built-in entry has its own.
"""

import time

import structlog
from sqlalchemy import select
from sqlalchemy.orm import Session

from seamark.server.accounts.accounts import RESERVED_PREFIX
from seamark.server.accounts.permissions import Viewer
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.tables import Run, User
from seamark.server.runs.states import RunKind, RunState
from seamark.server.runs.submission import Submission, enqueue
from seamark.server.settings import Settings
from seamark.sim import registry

_log = structlog.get_logger()


def ensure(session: Session, settings: Settings) -> list[int]:
    """Queue the baselines that are neither there nor on their way; return the new runs' ids.

    The worker computes them like everybody's runs; they become public when they succeed. A baseline
    that failed or was withdrawn is not queued again by itself: somebody should look at it.
    """
    acquire(session, AdvisoryLock.BASELINES)
    made: list[int] = []
    for name in registry.BENCHMARKS:
        for ending, baseline in registry.benchmark(name).baselines.items():
            user = _user(session, f"{RESERVED_PREFIX}-{ending}")
            if not _there(session, user.id, name):
                order = Submission(
                    viewer=Viewer(user_id=user.id, name=user.name),
                    benchmark=name,
                    config=baseline.config,
                    kind=RunKind.RANKED,
                    controller=baseline.built_in,
                    title=baseline.title,
                )
                made.append(enqueue(session, order, settings))
    if made:
        _log.info("baselines_queued", runs=made)
    return made


def _user(session: Session, name: str) -> User:
    user = session.scalar(select(User).where(User.name_key == name))
    if user is None:
        user = User(name=name, name_key=name, is_baseline=True, created_at=time.time())
        session.add(user)
        session.flush()
    return user


def _there(session: Session, user_id: int, benchmark: str) -> bool:
    query = select(Run.id).where(
        Run.user_id == user_id, Run.benchmark == benchmark, Run.state != RunState.CANCELLED
    )
    return session.scalar(query.limit(1)) is not None
