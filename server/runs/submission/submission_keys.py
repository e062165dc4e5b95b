"""Idempotency keys: a submission that is sent again is answered as before, and starts nothing.

A client that got no answer cannot know whether its request arrived. With a key of its own it sends
the request again (draft-ietf-httpapi-idempotency-key-header-07).
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Self

from sqlalchemy import delete
from sqlalchemy.orm import Session

from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.submission_tables import KeyOfSubmission
from seamark.server.runs.submission.validation import SubmissionRejected

FIELD = "Idempotency-Key"
KEPT_S = 86_400.0


@dataclass(frozen=True, slots=True)
class SubmissionKey:
    """A key of one account, and what was submitted with it."""

    user_id: int
    key: str
    request: str

    @classmethod
    def of(cls, user_id: int, text: str, *, request: Mapping[str, object]) -> Self:
        """Return the key with the digest of the request."""
        content = json.dumps(request, sort_keys=True)
        return cls(user_id, _sha256(text), _sha256(content))


def number_of(session: Session, key: SubmissionKey, *, now: float) -> int | None:
    """Return the number of what this request has started before; None if it is new.

    Raises as `once`.
    """
    known = session.get(KeyOfSubmission, (key.user_id, key.key))
    if known is None or known.created_at < now - KEPT_S:
        return None
    if known.request != key.request:
        raise SubmissionRejected(
            f"This {FIELD} was already used for another submission.", field=FIELD
        )
    return known.number


def once(
    session: Session, key: SubmissionKey | None, start: Callable[[], int], *, now: float
) -> int:
    """Return the number of what `start` starts, or of what this request has started before.

    Raises
    ------
    SubmissionRejected
        The account has used the key for another submission within a day.
    """
    if key is None:
        return start()
    # Of two requests at once the second sees the row of the first.
    acquire(session, AdvisoryLock.SUBMISSION)
    own = KeyOfSubmission.user_id == key.user_id
    session.execute(delete(KeyOfSubmission).where(own, KeyOfSubmission.created_at < now - KEPT_S))
    known = number_of(session, key, now=now)
    if known is not None:
        return known
    number = start()
    row = {"user_id": key.user_id, "key": key.key, "request": key.request}
    session.add(KeyOfSubmission(**row, number=number, created_at=now))
    return number


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
