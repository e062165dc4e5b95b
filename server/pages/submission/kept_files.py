"""Stored files that a form keeps, since browsers do not send them again when it has errors.

A kept file is named by a hidden field, which is signed and valid for this user only.
"""

from typing import Any

from flask import g
from itsdangerous import BadData, URLSafeTimedSerializer

from seamark.server.programs import store
from seamark.server.web.services import services

VALID_S = store.UNUSED_KEPT_S / 2  # of the hidden field


def field(what: str) -> str:
    """Return the name of the hidden field for the file of a setting."""
    return f"kept_{what}"


def token(what: str, sha256: str, *more: object) -> str:
    """Return the value of the hidden field for a stored file, and what else is known of it."""
    return str(_signer(what).dumps([sha256, *more, g.viewer.user_id]))


def kept(what: str, text: str) -> list[Any] | None:
    """Return the values of a hidden field if they are this user's and the file is still stored."""
    values: list[Any]
    try:
        *values, user_id = _signer(what).loads(text, max_age=int(VALID_S))
    except (BadData, ValueError):
        return None
    if user_id != g.viewer.user_id or store.touch(services().settings, values[0]) is None:
        return None
    return values


def _signer(what: str) -> URLSafeTimedSerializer:
    return URLSafeTimedSerializer(services().settings.secret_key, salt=f"kept {what}")
