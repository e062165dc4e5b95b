"""Which ended runs their owners get an e-mail about.

A row in the transaction that ends the run, so that none is forgotten. A worker writes it without
knowing the address, which its role may not read.
"""

from sqlalchemy import bindparam, insert, select
from sqlalchemy.orm import Session

from seamark.server.database.mail_tables import RunNotice
from seamark.server.database.tables import IS_LISTED, Run, User

_MINUTE_S = 60.0
_WANTED = (
    select(Run.user_id, Run.id)
    .join(User, User.id == Run.user_id)
    .where(Run.id == bindparam("ended_run"), IS_LISTED, User.notify_minutes.is_not(None))
    .where(Run.finished_at - Run.queued_at >= User.notify_minutes * _MINUTE_S)
)
_NOTE = insert(RunNotice).from_select(["user_id", "run_id"], _WANTED)


def note(session: Session, run_id: int) -> None:
    """Note that a run has ended, if its owner wants to know and it took long enough."""
    session.connection().execute(_NOTE, {"ended_run": run_id})
