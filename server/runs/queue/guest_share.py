"""How guests get their share of the queue, although accounts come first.

Each run of an account that starts while a guest waits leaves a row: a number that all of them
change would be a row that all claims wait for. Claims at the same time do not see each other's: for
n of them, up to 2 (n - 1) more accounts go first.
"""

from sqlalchemy import ScalarSelect
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import GUESTS
from seamark.server.database import counters

GUEST_SHARE = 4  # runs of accounts that start before one of a guest, while both wait
_PASSED_OVER = "guests_passed_over"


def passed_over(session: Session) -> int:
    """Return how many runs of accounts have started while guests waited, since one of theirs."""
    return int(counters.total(session, _PASSED_OVER))


def stored() -> ScalarSelect[float]:
    """Return `passed_over` as an expression, for a query that asks for more; NULL for 0."""
    return counters.stored_total(_PASSED_OVER)


def count(session: Session, owner: str, run_id: int, *, before: int, guests_wait: bool) -> None:
    """Count a run that starts.

    Parameters
    ----------
    owner
        Of the run.
    before
        How many have passed guests over until now.
    """
    if not guests_wait or owner.startswith(GUESTS):
        if before:
            counters.forget(session, _PASSED_OVER)
    elif before < GUEST_SHARE:
        counters.add(session, f"{_PASSED_OVER}:{run_id}", 1.0)
