"""The runs of a guest who signs in become those of the account."""

from sqlalchemy import select, update
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import Viewer
from seamark.server.database.tables import Run
from seamark.server.runs.record import turns


def adopt_runs(session: Session, user_id: int, guest: str) -> int:
    """Transfer the runs of a guest (hash of the cookie) to a user; return how many."""
    owner = Viewer(user_id=user_id).owner or ""
    before = session.scalars(select(Run.owner).where(Run.guest == guest).distinct()).all()
    change = update(Run).where(Run.guest == guest)
    adopted = session.scalars(
        change.values(owner=owner, user_id=user_id, guest=None).returning(Run.id)
    ).all()
    if adopted:
        for changed in sorted({*before, owner}):
            turns.refresh(session, changed)
    return len(adopted)
