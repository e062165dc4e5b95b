"""Publishing runs, on which terms, withdrawing them, and showing later who made them.

A leaderboard has one row for each user, or for each of their methods. So the ranked runs of a user
in a benchmark are either all published by name or all for review: a row that replaces another one
would show whose it is.
"""

import time
from dataclasses import dataclass

from sqlalchemy import ColumnElement, select, update
from sqlalchemy.orm import Session

from seamark.programs.licences import LICENCES, NO_PROGRAM
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.publication_tables import Publication
from seamark.server.database.tables import BestMethod, Run, User
from seamark.server.database.upsert import upsert
from seamark.server.runs.leaderboard import best_runs
from seamark.server.runs.record import method_names
from seamark.server.runs.record.states import RunKind, RunState


class PublicationRefused(Exception):
    """The terms of a publication break a rule. The text is for the owner; `field` is at fault."""

    def __init__(self, sentence: str, *, field: str) -> None:
        super().__init__(sentence)
        self.field = field


@dataclass(frozen=True, slots=True, kw_only=True)
class Terms:
    """On which terms a run is published."""

    method: str = ""  # its name; empty: the label of a built-in solution
    program: bool = True  # with the uploaded program and its log; else the results only
    licence: str | None = None  # of the program, a key of LICENCES; None: none is granted
    anonymous: bool = False  # for review: nobody sees whose it is


_PRIVATE = {
    **{"public": False, "published_at": None, "anonymous": False},
    **{"program_public": True, "licence": None},
}


def publish(session: Session, run_id: int, terms: Terms) -> bool:
    """Make a finished run public; False if it has not finished, has no data or is public.

    Raises
    ------
    PublicationRefused
        The terms are not possible for this run.
    """
    acquire(session, AdvisoryLock.LEADERBOARD)
    run = session.get_one(Run, run_id)
    if run.public or run.data_deleted_at is not None:  # whatever the terms
        return False
    _check(session, run, terms)
    method = _method(session, run, terms)
    now = time.time()
    change = (
        update(Run)
        .where(Run.id == run_id, Run.public.is_(False))
        .where(Run.state.in_((RunState.SUCCEEDED, RunState.FAILED)), Run.data_deleted_at.is_(None))
        .values(
            public=True,
            published_at=now,
            method=method,
            anonymous=terms.anonymous,
            program_public=terms.program or not run.has_programs,
            licence=terms.licence,
        )
    )
    if session.scalar(change.returning(Run.id)) is None:
        return False
    row = {"run_id": run_id, "first_at": now, "withdrawn_at": None}
    upsert(session, Publication, row, {"withdrawn_at": None})
    if terms.anonymous:
        _forget_reruns(session, run)
    _rank(session, run_id)
    return True


def withdraw(session: Session, run_id: int) -> bool:
    """Make a run private again and take it off the leaderboard; False if it is not public."""
    return bool(withdraw_all(session, Run.id == run_id))


def withdraw_all(session: Session, which: ColumnElement[bool]) -> int:
    """Make all public runs of a condition private, and return their number."""
    rows = select(BestMethod.benchmark, BestMethod.user_id)  # a user's best run has one as well
    ranked = rows.join(Run, Run.id == BestMethod.run_id).where(which, Run.public)
    boards = session.execute(ranked.distinct()).all()
    public = select(Run.id).where(which, Run.public)
    tombs = update(Publication).where(Publication.run_id.in_(public))
    apart = {"synchronize_session": False}
    session.execute(tombs.values(withdrawn_at=time.time()), execution_options=apart)
    change = update(Run).where(which, Run.public).values(**_PRIVATE)
    withdrawn = session.connection().execute(change).rowcount
    session.expire_all()
    for benchmark, user_id in boards:
        best_runs.refresh(session, benchmark, user_id)
    return withdrawn


def reveal(session: Session, run_id: int) -> bool:
    """Show the author of an anonymous run; False if it is not anonymous.

    With a ranked one, those of the same author in the same benchmark are shown as well.
    """
    acquire(session, AdvisoryLock.LEADERBOARD)
    run = session.get_one(Run, run_id)
    which = Run.id == run_id
    if run.kind == RunKind.RANKED and run.user_id is not None:
        same = (Run.user_id == run.user_id, Run.benchmark == run.benchmark)
        which = same[0] & same[1] & (Run.kind == RunKind.RANKED)
    if not (run.public and run.anonymous):
        return False
    session.execute(update(Run).where(which, Run.public).values(anonymous=False))
    _rank(session, run_id)
    return True


def history(session: Session, run_id: int) -> Publication | None:
    """Return that a run is or was public; None if it never was."""
    return session.get(Publication, run_id)


def _forget_reruns(session: Session, run: Run) -> None:
    """Cut the links from runs that the owner started from this one while nobody else could."""
    own = update(Run).where(Run.owner == run.owner, Run.rerun_of == run.id)
    session.execute(own.values(rerun_of=None))


def _method(session: Session, run: Run, terms: Terms) -> str:
    """Return the name of the method, or raise PublicationRefused."""
    name = method_names.clean(terms.method) or method_names.suggested(
        run, title=run.title if run.kind == RunKind.LOG else ""
    )
    hidden: list[str] = []
    if terms.anonymous and run.user_id is not None:
        user = session.get_one(User, run.user_id)
        hidden = [user.name, user.public_name]
    if why := method_names.refusal(name, program_name=run.program_name, hidden=hidden):
        raise PublicationRefused(why, field="method")
    return name


def _check(session: Session, run: Run, terms: Terms) -> None:
    if terms.licence is not None and terms.licence not in LICENCES:
        raise PublicationRefused(f"Choose one of {', '.join(LICENCES)}, or none.", field="licence")
    if terms.licence is not None and not (run.has_programs and terms.program):
        raise PublicationRefused(NO_PROGRAM, field="licence")
    other = select(Run.id).where(
        Run.user_id == run.user_id,
        Run.benchmark == run.benchmark,
        Run.kind == RunKind.RANKED,
        Run.public,
        Run.anonymous.is_not(terms.anonymous),
    )
    if run.kind != RunKind.RANKED:
        return
    entered = session.scalar(other.limit(1))
    if entered is None:
        return
    how = "under your name" if terms.anonymous else "anonymously"
    todo = "Withdraw it first" if terms.anonymous else "Show your name there, or withdraw it, first"
    raise PublicationRefused(
        f"Run {entered} of this benchmark is published {how}. The leaderboard has one row for each "
        f"user, so it would show whose the anonymous run is. {todo}.",
        field="anonymous",
    )


def _rank(session: Session, run_id: int) -> None:
    run = session.get_one(Run, run_id)
    if run.user_id is not None:
        best_runs.refresh(session, run.benchmark, run.user_id)
