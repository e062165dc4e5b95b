"""Publishing and withdrawing runs, with their entries in the audit log: for pages and API alike."""

from dataclasses import asdict

from sqlalchemy.orm import Session

from seamark.server.accounts.audit import AuditAction
from seamark.server.accounts.permissions import Action, can
from seamark.server.runs.publication import publications
from seamark.server.runs.publication.publications import Terms
from seamark.server.runs.recomputation import verifications
from seamark.server.web import access
from seamark.server.web.services import services
from seamark.server.web.site_address import site_address


def address_of(run_id: int) -> str:
    """Return the permanent address of a publication."""
    return f"{site_address()}/p/{run_id}"


def publish(session: Session, run_id: int, terms: Terms) -> bool:
    """Make a finished run public; False if it has not finished, has no data or is public.

    Raises
    ------
    PublicationRefused
        The terms are not possible for this run.
    """
    changed = publications.publish(session, run_id, terms)
    if changed:
        access.record(session, AuditAction.RUN_PUBLISHED, f"run {run_id}", asdict(terms))
    return changed


def verify(run_id: int) -> None:
    """Queue a verification of a run; admins may have it repeated.

    Raises
    ------
    VerificationRefused
        The run cannot be verified now.
    """
    held, repeat = services(), can(access.viewer(), Action.ADMINISTER)
    with held.database.writing() as session:
        verifications.request(session, run_id, held.settings, repeat=repeat)
        access.record(session, AuditAction.VERIFICATION_REQUESTED, f"run {run_id}")
    held.wake_worker()


def withdraw(session: Session, run_id: int) -> bool:
    """Make a run private again and take it off the leaderboard; False if it is not public."""
    changed = publications.withdraw(session, run_id)
    if changed:
        access.record(session, AuditAction.RUN_WITHDRAWN, f"run {run_id}")
    return changed


def reveal(session: Session, run_id: int) -> bool:
    """Show the author of an anonymous run; False if it is not anonymous."""
    changed = publications.reveal(session, run_id)
    if changed:
        access.record(session, AuditAction.RUN_REVEALED, f"run {run_id}")
    return changed
