"""Publishing and withdrawing runs, with their entries in the audit log: for pages and API alike."""

from sqlalchemy.orm import Session

from seamark.server.audit import AuditAction
from seamark.server.runs import results
from seamark.server.web import access


def publish(session: Session, run_id: int) -> bool:
    """Make a finished run public; False if it has not finished, has no data or is public."""
    changed = results.publish(session, run_id)
    if changed:
        access.record(session, AuditAction.RUN_PUBLISHED, f"run {run_id}")
    return changed


def withdraw(session: Session, run_id: int) -> bool:
    """Make a run private again and take it off the leaderboard; False if it is not public."""
    changed = results.withdraw(session, run_id)
    if changed:
        access.record(session, AuditAction.RUN_WITHDRAWN, f"run {run_id}")
    return changed
