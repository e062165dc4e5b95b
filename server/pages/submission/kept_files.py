"""Files of settings that a form keeps, since browsers do not send them again.

As a program (`submitted_program`), a kept file is named by a signed field, valid for this user.
"""

from typing import NamedTuple

from flask import g
from itsdangerous import BadData, URLSafeTimedSerializer

from seamark.server.programs import store
from seamark.server.web.services import services

VALID_S = store.UNUSED_KEPT_S / 2


class KeptFile(NamedTuple):
    """A file in the store, and the value of the setting that it is for."""

    name: str
    sha256: str


def field(setting: str) -> str:
    """Return the name of the hidden field for the file of a setting."""
    return f"kept_{setting}"


def token(setting: str, name: str, sha256: str) -> str:
    """Return the value of the hidden field for a stored file."""
    return str(_signer(setting).dumps([name, sha256, g.viewer.user_id]))


def kept(setting: str, text: str) -> KeptFile | None:
    """Return the file of a hidden field if it belongs to this user and is still stored."""
    try:
        name, sha256, user_id = _signer(setting).loads(text, max_age=int(VALID_S))
    except (BadData, ValueError):
        return None
    if user_id != g.viewer.user_id or store.touch(services().settings, sha256) is None:
        return None
    return KeptFile(name, sha256)


def _signer(setting: str) -> URLSafeTimedSerializer:
    return URLSafeTimedSerializer(services().settings.secret_key, salt=f"kept {setting}")
